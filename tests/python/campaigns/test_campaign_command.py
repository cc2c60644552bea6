"""`truenorth campaign`: what stands where, and words of refusal; the runs are there already."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from sim_scenarios.campaigns import table
from sim_scenarios.campaigns.statistics import summarise
from sim_scenarios.campaigns.store import open_results
from sim_scenarios.cli.application import app


def campaign(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["campaign", *(str(a) for a in arguments)])


def test_a_complete_campaign_is_reported_again(plan_file: Path, results_folder: Path) -> None:
    result = campaign(plan_file, "-o", results_folder)
    assert result.exit_code == 0
    assert "all were there already" in result.stdout
    assert str(results_folder / "report.html") in result.stdout
    for case in summarise(open_results(results_folder)):
        assert case.label in result.stdout
        for row in table.figures(case)[1:]:
            assert all(cell in result.stdout for cell in row)


def test_json_alone_stands_on_standard_output(plan_file: Path, results_folder: Path) -> None:
    result = campaign(plan_file, "-o", results_folder, "--json")
    content = json.loads(result.stdout)
    assert (content["runs"], content["seed"]) == (5, 3)
    case = content["cases"]["zigzag gnss.rate=1.0"]
    assert case["reference"] == "UKF"
    rmse, lower, upper = case["filters"]["EKF"]["heading_rmse"]
    assert lower < rmse < upper
    assert case["filters"]["UKF"]["convergence_median"] is None  # 40 s are too short
    assert Path(content["data"]).is_dir()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["swaying_shp"], "did you mean 'swaying_ship'"),
        (["waves", "--filter", "UFK"], "did you mean 'ukf'"),
        (["waves", "--grid", "gnss.rate=1"], "gnss.rate: input should be a valid list"),
        (["waves", "--grid", "gnss.rate"], "write NAME=VALUE"),
        (["waves", "-n", "0"], "runs: input should be greater than or equal to 1"),
        (["waves", "--set", "gnss.rate=20", "--master", "container"], "cannot run in a container"),
        (["waves", "--workers", "0"], "--workers"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(tmp_path: Path, arguments: list[str], words: str) -> None:
    result = campaign(*arguments, "-o", tmp_path)
    assert result.exit_code == 2
    assert words.lower() in " ".join(result.stderr.lower().split())
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


def test_results_of_another_campaign_are_not_touched(plan_file: Path, results_folder: Path) -> None:
    result = campaign(plan_file, "--seed", 9, "-o", results_folder)
    assert result.exit_code == 2
    assert "--overwrite" in result.stderr
    assert campaign(plan_file, "-o", results_folder).exit_code == 0
