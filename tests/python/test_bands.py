"""The bands: that they name what there is, and the command that checks them, stopped and gone on with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sim_scenarios import catalogue
from sim_scenarios.cli.application import app
from sim_scenarios.fmus import Fmus
from sim_scenarios.studies import store
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.expectations import Band
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.store import State

BANDS = catalogue.files(catalogue.BANDS)


@pytest.mark.parametrize("name", BANDS)
def test_bands_name_a_scenario_its_filters_and_their_reason(name: str, fmus: Fmus) -> None:
    plan = load_plan(BANDS[name])
    assert plan.scenarios == (name,)
    assert cases(plan, fmus)  # refuses filters that are not compared
    for expectations in plan.expect:
        assert expectations.why
        assert all(isinstance(one, Band) for of in expectations.figures.values() for one in of.values())


SHORT = """
scenarios = ["{name}"]
filters = ["UKF"]
set = {{ duration = {duration}, "evaluation.start" = 10.0 }}

[[expect]]
why = "So that it is {why}."

[expect.figures]
"UKF" = {{ heading = [0, {high}] }}
"""


MODULE = """
import runpy, sys
from pathlib import Path
from sim_scenarios import catalogue
catalogue.BANDS = Path(sys.argv.pop(1))
runpy.run_module("sim_scenarios.bands", run_name="__main__")
"""
"""`python -m sim_scenarios.bands` with bands of another folder."""


def command(bands: Path, *arguments: object) -> list[str]:
    return [sys.executable, "-c", MODULE, str(bands), *map(str, arguments), "--workers", "2"]


def states(folder: Path) -> Mapping[Path, int]:
    return {file: file.stat().st_mtime_ns for file in folder.glob("*/campaign.zarr/state/[0-9]*")}


def finished(folder: Path) -> int:
    path = folder / store.NAME
    return store.counts(path)[State.finished] if path.exists() else 0


def test_bands_that_are_interrupted_go_on(
    fmus: Fmus,  # noqa: ARG001
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Between and within scenarios; what is done is not done again, and says the same as in one go."""
    bands = tmp_path_factory.mktemp("bands")
    for name in ("turn", "zigzag"):  # runs that take long enough to be interrupted
        text = SHORT.format(name=name, duration=150.0, why="ok", high=1e6)
        (bands / f"{name}.toml").write_text(text, encoding="utf-8")
    asked = command(bands, "--only", "turn", "zigzag", "-n", 3, "--json", "-o", tmp_path)
    with subprocess.Popen(asked, stdout=-1, stderr=-1, text=True, start_new_session=True) as running:
        while finished(tmp_path / "zigzag") == 0:
            assert running.poll() is None
            time.sleep(0.02)
        os.killpg(running.pid, signal.SIGINT)
        _, said = running.communicate(timeout=300)
    assert running.returncode == 130
    assert "the same command resumes" in said
    before = states(tmp_path)
    assert 3 < len(before) < 6
    resumed = subprocess.run(asked, capture_output=True, text=True, check=False)
    assert states(tmp_path).items() >= before.items()
    assert (tmp_path / "zigzag" / "report.html").is_file()
    monkeypatch.setattr(catalogue, "BANDS", bands)
    at_once = CliRunner().invoke(
        app, ["bands", "turn", "zigzag", "-n", "3", "--json", "-o", str(tmp_path / "b")]
    )
    assert json.loads(resumed.stdout)["rows"] == json.loads(at_once.stdout)["rows"]
    assert resumed.returncode == at_once.exit_code


@pytest.mark.parametrize(("high", "why", "code"), [(1e6, "ok", 0), (1e-6, "**missed**", 1)])
def test_the_table_the_page_and_the_exit_code(
    fmus: Fmus,  # noqa: ARG001
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    high: float,
    why: str,
    code: int,
) -> None:
    (tmp_path / "short.toml").write_text(
        SHORT.format(name="turn", duration=20.0, high=high, why=why), encoding="utf-8"
    )
    monkeypatch.setattr(catalogue, "BANDS", tmp_path)
    result = CliRunner().invoke(app, ["bands", "-n", "2", "-o", str(tmp_path), "--workers", "1"])
    assert result.exit_code == code, result.output
    heading, _, row = result.stdout.splitlines()
    assert heading == "| case | filter | figure | expected | measured | 95 % | single runs |  |"
    assert row.startswith("| turn | UKF | heading RMSE ['] | 0 to ")
    assert row.endswith(f" | {why} |")
    page = (tmp_path / "short" / "report.html").read_text(encoding="utf-8")
    assert f"So that it is {why}." in page


def test_a_scenario_without_bands_is_refused() -> None:
    result = CliRunner().invoke(app, ["bands", "zagzig"])
    assert result.exit_code == 2
    assert "there are no bands of 'zagzig'" in result.stderr
