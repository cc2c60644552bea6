"""`truenorth campaign`: what stands where, and words of refusal; the runs are there already."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from sim_scenarios.cli.application import app
from sim_scenarios.studies import page, store, table
from sim_scenarios.studies.statistics import summarise
from sim_scenarios.studies.store import open_results


def campaign(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["campaign", *(str(a) for a in arguments)])


def test_a_complete_campaign_is_reported_again(plan_file: Path, results_folder: Path) -> None:
    result = campaign(plan_file, "-o", results_folder)
    assert result.exit_code == 0
    assert "all were there already" in result.stdout
    assert str(results_folder / "report.html") in result.stdout
    assert "pictures" not in result.stderr  # of so few
    for case in summarise(open_results(results_folder)):
        assert case.label in result.stdout
        for row in table.figures(case)[1:]:
            assert all(cell in result.stdout for cell in row)


def test_it_says_how_far_many_pictures_are(
    plan_file: Path, results_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sim_scenarios.cli.campaign.MANY_PICTURES", 2)
    count = len(list(summarise(open_results(results_folder))))
    said = campaign(plan_file, "-o", results_folder).stderr
    assert f"courses: {count} of {count} pictures" in said.splitlines()


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
        (["waves", "--grid", "gnss.rate"], "--grid gnss.rate: write NAME=VALUE"),
        (["waves", "-n", "0"], "runs: input should be greater than or equal to 1, not 0"),
        (["waves", "--seed", "-1"], "seed: input should be greater than or equal to 0, not -1"),
        (["waves", "--master", "container"], "'container' is not one of 'auto',"),
        (["waves", "--workers", "0"], "--workers"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(tmp_path: Path, arguments: list[str], words: str) -> None:
    result = campaign(*arguments, "-o", tmp_path)
    assert result.exit_code == 2
    assert words.lower() in " ".join(result.stderr.lower().split())
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("scenarios = []", "scenarios: list should have at least 1 item"),
        ('scenarios = "waves"', "scenarios: input should be a valid list"),
        ('scenarios = ["waves"]\nfilters = []', "filters: names no filter"),
        ('scenarios = ["waves"]\nrun = 5', "run: there is no such entry; did you mean 'runs'?"),
        ('scenarios = ["waves"', "not valid TOML"),
        ('scenarios = ["waves"]\nfilters = 5', "filters: 5: must be a list of labels, or tables"),
        ('scenarios = ["waves"]\nfilters = [5]', "filters: [5]: must be a list of labels"),
        ('scenarios = ["waves"]\n[filters]\na = 5', "filters: a = 5: must be a table of parameters"),
        ('scenarios = ["waves"]\n[filters.a]\nscenarios = 5', "a.scenarios = 5: must be a list of names"),
        ('scenarios = ["waves"]\n[filters.a]\nscenarios = "waves"', "a.scenarios = 'waves': must be a list"),
        ('scenarios = ["waves"]\n[draw]\nx = {}', "draw.x: must be one of uniform, log_uniform, choice"),
    ],
)
def test_a_campaign_file_that_is_wrong_says_where(tmp_path: Path, content: str, words: str) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(content, encoding="utf-8")
    result = campaign(file, "-o", tmp_path / "results")
    assert result.exit_code == 2
    assert words in result.stderr
    assert not (tmp_path / "results").exists()


def test_a_folder_with_something_else_of_that_name_is_refused(plan_file: Path, tmp_path: Path) -> None:
    (tmp_path / store.NAME).mkdir()
    result = campaign(plan_file, "-o", tmp_path)
    assert result.exit_code == 2
    assert "is not the data set of a campaign" in result.stderr


def test_a_full_disk_is_told_in_a_sentence(
    plan_file: Path, results_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(page, "write", full)
    result = campaign(plan_file, "-o", results_folder)
    assert result.exit_code == 2
    assert "No space left on device; what is done is kept, and the same command resumes" in result.stderr


def test_results_of_another_campaign_are_not_touched(plan_file: Path, results_folder: Path) -> None:
    result = campaign(plan_file, "--seed", 9, "-o", results_folder)
    assert result.exit_code == 2
    assert "--overwrite" in result.stderr
    assert campaign(plan_file, "-o", results_folder).exit_code == 0
