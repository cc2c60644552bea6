"""Several filters on one recording."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from plant_signals import as_csv, sensed
from typer.testing import CliRunner, Result

from sim_scenarios import recording as results
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings import comparison, outages
from sim_scenarios.recordings.description import load
from sim_scenarios.recordings.outages import Outages
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.side_by_side import replays, table, together
from sim_scenarios.recordings.start import Start
from sim_scenarios.report import report_replays
from sim_scenarios.units import DEGREE

LENGTH = 60.0  # s
CONDITIONS = {
    "start": Start(heading=4.0 * DEGREE),
    "filter": "navigation",
    "outages": Outages(10.0, 30.0),
    "evaluate_after": 10.0,
}
FILTERS = {"loose": {"error_model": "loose"}, "full": {"error_model": "full_state"}}
TRUSTING = {"gate.enabled": False}


@pytest.fixture(scope="module")
def ship(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ship") / "ship.csv"
    return as_csv(sensed(Fmus(), "align_then_navigate", LENGTH), path)


@pytest.fixture(scope="module")
def runs(ship: Path) -> dict[str, xr.Dataset]:
    return replays(ship, FILTERS, set=TRUSTING, **CONDITIONS)


def test_each_filter_does_what_it_does_alone(ship: Path, runs: dict[str, xr.Dataset]) -> None:
    alone = replay(load(ship), set={**TRUSTING, **FILTERS["full"]}, **CONDITIONS)  # type: ignore[arg-type]
    assert alone.identical(runs["full"])
    assert not np.array_equal(runs["loose"]["nav.heading"], runs["full"]["nav.heading"])


def test_the_table_has_the_figures_of_each(runs: dict[str, xr.Dataset]) -> None:
    heading, *rows = table(runs)
    cells = {row[0]: dict(zip(heading, row, strict=True)) for row in rows}
    assert list(cells) == ["loose", "full"]
    for label, run in runs.items():
        fixes = comparison.against_fixes(run)
        assert cells[label]["before fix,\nhoriz. [m]"] == f"{fixes.horizontal:.3f}"
        ends = outages.figures(outages.ends(run))
        assert cells[label]["ends of\noutages [m]"] == f"{ends['horizontal_rms_m']:.2f}"
    assert not any("NEES" in column for column in heading)  # there is no reference


def test_errors_against_a_reference_stand_in_the_table_and_a_picture(
    ship: Path, runs: dict[str, xr.Dataset], tmp_path: Path
) -> None:
    """The reference is what one of the filters has found: its errors are zero then."""
    names = ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity")
    found = runs["full"][[f"nav.{name}" for name in names]]
    path = tmp_path / "recording.nc"
    results.save(found.rename({f"nav.{name}": f"truth.{name}" for name in names}), path)
    against = replays(ship, FILTERS, set=TRUSTING, reference=path, **CONDITIONS)
    heading, *rows = table(against)
    column = heading.index("head.\n[deg]")
    loose, full = (float(row[column]) for row in rows)
    assert full == 0  # to the three digits of the table
    assert loose > 0
    page = report_replays(against, tmp_path / "report").read_text(encoding="utf-8")
    assert all(f'id="{name}"' in page for name in ("heading", "errors", "fixes", "outages"))
    assert "Seed None" not in page


def test_messages_stand_once(runs: dict[str, xr.Dataset]) -> None:
    said = [json.loads(run.attrs["messages"]) for run in runs.values()]
    told = json.loads(together(runs).attrs["messages"])
    assert len(told) == len(set(told))
    assert set(told) == {line for lines in said for line in lines}
    assert set(json.loads(together(runs).attrs["settings"])) == {"loose, filter", "full, filter"}


def test_a_wrong_setting_is_refused_with_its_filter(ship: Path) -> None:
    with pytest.raises(InputError, match="second: the setting gain: no FMU has such a parameter"):
        replays(ship, {**FILTERS, "second": {"gain": 1.0}}, **CONDITIONS)


def truenorth(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_the_command(ship: Path, tmp_path: Path) -> None:
    options = ["--filter", "navigation", "--heading", 4, "--axis", "corrector=standard,igg"]
    result = truenorth("replay", ship, *options, "-o", tmp_path / "out", "--json")
    content = json.loads(result.stdout)
    assert list(content["filters"]) == ["standard", "igg"]
    converged = [told["converged"] for told in content["filters"].values()]
    assert result.exit_code == (0 if all(converged) else 1)
    for told in content["filters"].values():
        run = results.load(Path(told["recording"]))
        assert told["against_fixes"] == comparison.against_fixes(run).figures()
    assert Path(content["report"]).is_file()
    refused = truenorth("replay", ship, *options, "--export", "kml", "-o", tmp_path / "out")
    assert (refused.exit_code, "--export kml: is of one filter" in refused.output) == (2, True)


def test_compare_says_which_command_does_it(ship: Path) -> None:
    result = truenorth("compare", ship)
    assert result.exit_code == 2
    assert f"truenorth replay {ship} --axis" in result.output


@pytest.mark.parametrize("command", ["run", "bound", "campaign"])
def test_what_runs_scenarios_says_what_takes_a_recording(command: str, ship: Path, tmp_path: Path) -> None:
    described = tmp_path / "recording.toml"
    described.write_text('[imu]\nfile = "imu.csv"\n')
    for given, said in (
        (described, "describes a recording: `truenorth replay"),
        (ship, "is no scenario; a rec"),
    ):
        result = truenorth(command, given)
        assert result.exit_code == 2
        assert f"{given} {said}" in result.stderr


def test_what_is_an_axis_is_not_set_for_all() -> None:
    filters = {"igg": {"corrector": "igg"}}
    with pytest.raises(InputError, match="the setting corrector: is for all filters, and igg has one"):
        replays("absent.toml", filters, set={"corrector": "standard"})
