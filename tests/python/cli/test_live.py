"""`truenorth run --live`: on standard error, beside the results, at a pace."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from sim_scenarios.cli.application import app
from sim_scenarios.cli.live import BLANK, COLUMNS, ROWS, drawn

SHORT = ["--set", "duration=60", "--set", "evaluation.start=30"]


def truenorth(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.usefixtures("fmus")
def test_a_run_is_shown_beside_its_results(tmp_path: Path) -> None:
    options = ["--live", "--pace", 100, "--json", "--output", tmp_path]
    result = truenorth("run", "swaying_ship", *SHORT, *options)
    assert result.exit_code == 1  # it is too short
    assert json.loads(result.stdout)["scenario"] == "swaying_ship"
    address, *lines = result.stderr.splitlines()
    assert re.fullmatch(r"swaying_ship: live at http://127\.0\.0\.1:\d+/[\w-]{32}/", address)
    for name in ("time", "heading", "1 sigma", "error", "status", "place"):
        assert f"{name} " in lines[0]
    assert lines[0].startswith("time 0.0 s of 60 s")
    assert lines[-1].startswith("time 60.0 s of 60 s")
    assert 3 < len(lines) <= 11


def test_a_pace_is_that_of_a_live_run() -> None:
    result = truenorth("run", "swaying_ship", "--pace", 10)
    assert result.exit_code == 2
    assert "--pace 10: goes with --live alone" in result.stderr
    result = truenorth("run", "swaying_ship", "--live", "--pace", 0)
    assert result.exit_code == 2
    assert "pace = 0: must be greater than 0" in result.stderr


def test_a_track_is_drawn_to_scale() -> None:
    circle = [(10 * math.cos(angle / 50), 10 * math.sin(angle / 50)) for angle in range(315)]
    lines, across = drawn([*circle, (math.nan, math.nan)])
    assert len(lines) == ROWS
    assert {len(line) for line in lines} == {COLUMNS}
    inked = [i for line in lines for i, character in enumerate(line) if ord(character) != BLANK]
    wide = max(inked) - min(inked) + 1
    assert wide == pytest.approx(2 * ROWS, abs=1)  # a character is twice as high as wide
    assert across / COLUMNS * wide == pytest.approx(20, rel=0.1)


def test_a_track_has_north_above() -> None:
    lines, _ = drawn([(0.0, 0.0), (0.0, 5.0), (1.0, 5.0)])
    inked = [sum(ord(character) != BLANK for character in line) for line in lines]
    assert inked[0] > inked[-1] == 1
    assert drawn([(math.nan, 0.0)])[0] == []
    lines, _ = drawn([(3.0, 4.0)])
    assert sum(ord(character) != BLANK for line in lines for character in line) == 1
