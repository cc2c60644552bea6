"""The command line: exit codes, what stands where, words of refusal."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner, Result

from sim_scenarios.cli import app

SHORT = ["--set", "duration=60", "--set", "evaluation.start=30"]
LONG = ["--set", "duration=320"]


def truenorth(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.usefixtures("fmus")
def test_run_converges(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *LONG, "--output", tmp_path)
    assert result.exit_code == 0
    for line in (
        "Converged: heading RMSE",
        "heading RMSE, 300 to 320 s",
        "Cramer-Rao bound",
        "converged",
        "report",
    ):
        assert line in result.stdout
    assert str(tmp_path / "report.html") in result.stdout
    assert (tmp_path / "report.html").is_file()
    assert (tmp_path / "recording.nc").is_file()
    assert "100 %" in result.stderr
    assert "%" not in result.stdout


@pytest.mark.usefixtures("fmus")
def test_run_that_does_not_converge(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *SHORT, "--output", tmp_path)
    assert result.exit_code == 1
    assert "Not converged" in result.stdout


@pytest.mark.usefixtures("fmus")
def test_json_alone_stands_on_standard_output(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *LONG, "--json", "--seed", 4, "-o", tmp_path)
    content = json.loads(result.stdout)
    assert content["seed"] == 4
    assert content["converged"] is True
    assert content["bound_arcmin"] == pytest.approx(17, abs=3)
    assert Path(content["report"]).is_file()


@pytest.mark.usefixtures("fmus")
def test_the_seed_decides(tmp_path: Path) -> None:
    figures = [
        json.loads(truenorth("run", "swaying_ship", *SHORT, "--json", "--seed", s, "-o", tmp_path).stdout)[
            "heading_rmse_arcmin"
        ]
        for s in (1, 1, 2)
    ]
    assert figures[0] == figures[1] != figures[2]


@pytest.mark.usefixtures("fmus")
def test_compare(tmp_path: Path) -> None:
    result = truenorth("compare", "swaying_ship_printed", *LONG, "-o", tmp_path)
    assert result.exit_code == 0
    for label in ("EKF", "UKF", "robust UKF (printed)", "robust UKF (rate-invariant)"):
        assert label in result.stdout
    words = " ".join(result.stdout.split())
    assert "4.3' cannot be a statistic of them" in words
    assert (tmp_path / "comparison.png").is_file()


@pytest.mark.usefixtures("fmus")
def test_compare_json(tmp_path: Path) -> None:
    result = truenorth("compare", "zigzag", *SHORT, "--json", "-o", tmp_path)
    filters = json.loads(result.stdout)["filters"]
    assert {"EKF", "UKF", "robust UKF"} <= set(filters)
    assert result.exit_code == 1


@pytest.mark.usefixtures("fmus")
def test_bound(tmp_path: Path) -> None:
    result = truenorth("bound", "zigzag", "--json", "-o", tmp_path)
    content = json.loads(result.stdout)
    assert result.exit_code == 0
    assert content["bound_arcmin"] == pytest.approx(5.53, rel=0.03)
    assert content["heading_sigma_arcmin"][0] == pytest.approx(600)
    better = truenorth("bound", "zigzag", "--set", "gnss.velocity_sigma=0.02", "-o", tmp_path)
    assert "1.76 arcmin" in better.stdout


def test_list() -> None:
    assert "swaying_ship" in truenorth("list").stdout
    assert "zigzag" in json.loads(truenorth("list", "--json").stdout)


@pytest.mark.usefixtures("fmus")
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "swaying_shp"], "did you mean 'swaying_ship'"),
        (["run", "nowhere.toml"], "there is no scenario file nowhere.toml"),
        (["run", "swaying_ship", "--set", "robust.gama=1"], "did you mean 'robust.gamma'"),
        (["run", "swaying_ship", "--set", "robust.gamma"], "write NAME=VALUE"),
        (["run", "swaying_ship", "--set", "prior.heading_sigma=10 mg"], "not in a unit"),
        (["run", "swaying_ship", "--set", "robust.gamma=-1"], "robust.gamma"),
        (["compare", "swaying_ship", "--set", "duration=-3"], "duration = -3 s"),
        (["bound", "swaying_ship", "--set", "gnss.velocity_sigma=0"], "the bound needs GNSS"),
        (["replay", "absent.csv", "--heading", "10"], "there is no recording absent.csv"),
        (["replay", "absent.csv", "--heading", "10", "--zero-velocity"], "LATITUDE,LONGITUDE,HEIGHT"),
        (["run"], "SCENARIO"),
        (["run", "swaying_ship", "--sed", "3"], "--sed"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(arguments: list[str], words: str) -> None:
    result = truenorth(*arguments)
    assert result.exit_code == 2
    assert words.lower() in " ".join(result.stderr.lower().split())
    assert "Traceback" not in result.output
    assert result.stdout == ""


@pytest.mark.usefixtures("fmus")
def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    result = truenorth("bound", "turn", "-o", tmp_path / "file")
    assert result.exit_code == 2
    assert "--output" in result.stderr


@pytest.mark.usefixtures("fmus")
def test_replay_shows_the_heading_over_time(tmp_path: Path) -> None:
    """A vehicle at rest, level and heading north on the equator, sensed without error."""
    n, rate, g = 6001, 7.292115e-5, 9.7803253359
    table = pd.DataFrame({"time": [0.01 * (i + 1) for i in range(n)]})
    for kind, vector in (("angle", (0, rate * 0.01, 0)), ("velocity", (0, 0, g * 0.01))):
        for axis, value in zip("xyz", vector, strict=True):
            table[f"delta_{kind}_{axis}"] = value
    table.to_csv(tmp_path / "still.csv", index=False)
    options = ["--heading", 5, "--zero-velocity", "--position", "0,0,0", "-o", tmp_path]
    result = truenorth("replay", tmp_path / "still.csv", *options)
    assert result.exit_code == 1  # one minute is too short
    assert "heading at the end" in result.stdout
    content = json.loads(truenorth("replay", tmp_path / "still.csv", *options, "--json").stdout)
    assert content["headings"][0]["heading_deg"] == pytest.approx(5)
    end = content["headings"][-1]["heading_deg"]
    assert abs((end + 180) % 360 - 180) < 5


@pytest.mark.parametrize("command", ["run", "compare", "bound", "replay"])
def test_help_teaches_with_examples(command: str) -> None:
    result = truenorth(command, "--help")
    assert result.exit_code == 0
    assert "For example" in result.stdout
    assert f"truenorth {command}" in result.stdout
    for option in ("--output", "--seed", "--set", "--json"):
        assert option in result.stdout
