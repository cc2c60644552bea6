"""A recording in the Playback FMU: it puts out what a replay feeds, and filters make the same of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from plant_signals import as_csv, sensed
from played import difference_from_replay, put_out, until
from typer.testing import CliRunner

from sim_scenarios import Start
from sim_scenarios.archives import read_archive, write_archive
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import export_recording, signals
from sim_scenarios.exchange.forms import FORMS
from sim_scenarios.exchange.replay import difference, experiment
from sim_scenarios.exchange.verification import verify
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLANT, PLAYBACK, Fmus, load
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings import reference as references
from sim_scenarios.recordings.feed import feed
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.tables import Recording
from sim_scenarios.units import DEGREE

AIDS = {"body_velocity.rate": 1.0, "heading_aid.rate": 2.0, "height_aid.rate": 5.0, "gnss.rate": 4.0}


@pytest.fixture(scope="module")
def all_fmus() -> Fmus:
    return Fmus({name: load(name) for name in (PLANT, PLAYBACK, ALIGNMENT_FILTER, NAVIGATION_FILTER)})


@pytest.fixture(scope="module")
def ship(all_fmus: Fmus) -> Recording:
    """30 s with every aid."""
    return sensed(all_fmus, "swaying_ship", 30.0, settings=AIDS)


def at_an_epoch(recording: Recording) -> Recording:
    """By a clock that counts from 1970."""
    shifted = {
        name: replace(table, time=table.time + 1.7e9)
        for name in ("imu", "gnss", "body_velocity", "heading_aid", "height_aid", "reference")
        if (table := getattr(recording, name)) is not None
    }
    return replace(recording, **shifted)


def of_milliseconds(recording: Recording) -> Recording:
    """Stamps of the IMU are off by up to 2 ms and rounded."""
    imu = recording.imu
    late = 0.002 * np.sin(np.arange(len(imu.time)))
    return replace(recording, imu=replace(imu, time=np.round(imu.time + late, 3)))


def with_gaps(recording: Recording) -> Recording:
    """Samples 500 to 519 and 800 were lost; so was the position of some fixes."""
    imu, gnss = recording.imu, recording.gnss
    left = np.ones(len(imu.time), dtype=bool)
    left[[*range(500, 520), 800]] = False
    cut = {name: getattr(imu, name)[left] for name in ("time", "delta_angle", "delta_velocity")}
    position = gnss.position.copy()
    position[7:9] = np.nan
    return replace(recording, imu=replace(imu, **cut), gnss=replace(gnss, position=position))


def without_fixes(recording: Recording) -> Recording:
    return replace(recording, gnss=None, reference=None)


CHANGES = [lambda recording: recording, at_an_epoch, of_milliseconds, with_gaps, without_fixes]


@pytest.mark.parametrize("change", CHANGES, ids=["as it is", *(c.__name__ for c in CHANGES[1:])])
@pytest.mark.parametrize("start", [0.0, 100.0])
def test_every_row_of_a_feed_is_put_out(
    ship: Recording,
    change: Callable[[Recording], Recording],
    start: float,
    all_fmus: Fmus,
    tmp_path: Path,
) -> None:
    """Bit for bit, but for stamps, which are moved onto the simulation's clock."""
    recording = change(ship)
    fed = feed(recording)
    found = put_out(fed, recording, all_fmus, tmp_path, start)
    assert len(found["imu.sample"]) == len(fed.time)
    for name, column in fed.columns.items():
        if name.endswith(".time"):
            np.testing.assert_allclose(found[name] - start, column - fed.time[0], rtol=0, atol=1e-9)
        else:
            np.testing.assert_array_equal(found[name], column, err_msg=name)
    np.testing.assert_array_equal(found["recording.time"], fed.time)
    if recording.reference is None:
        assert np.isnan(found["truth.heading"]).all()
    else:
        for name, column in references.at(recording.reference, fed.time).items():
            np.testing.assert_array_equal(found[name], column, err_msg=name)
            assert np.isfinite(column[1:-1]).all()


def test_a_later_begin_is_the_feed_from_there(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    fed = feed(ship, 12.34)
    found = put_out(fed, ship, all_fmus, tmp_path, 0.0)
    np.testing.assert_array_equal(found["imu.sample"], np.arange(len(fed.time)))
    np.testing.assert_array_equal(found["gnss.sample"], fed.columns["gnss.sample"])
    assert found["gnss.sample"][-1] == 71  # each 0.25 s from 12.5 s to 30 s


# ------------------------------------------------------------------ the step


def test_a_steady_clock_has_its_period_for_step() -> None:
    assert signals.suitable_step(0.01 * np.arange(1000)) == 0.01
    assert signals.suitable_step(1.7e9 + np.arange(100_000) / 187.5) == pytest.approx(1 / 187.5, rel=1e-11)
    late = np.concatenate((0.01 * np.arange(500), 0.01 * np.arange(520, 1000)))
    assert signals.suitable_step(late) == 0.01


@pytest.mark.parametrize(
    ("clock", "step"),
    [
        (np.cumsum(np.tile([0.008, 0.009, 0.011, 0.012], 100)), 0.005),
        (np.round(np.arange(1000) / 400, 3), 0.002),
        (np.round(np.arange(1000) / 187.5, 3), 0.005),
        (np.cumsum(np.tile([0.0199, 0.0001], 100)), 0.001),  # a tenth of 0.01 s
    ],
)
def test_jittered_stamps_have_a_step_that_no_two_samples_share(clock: np.ndarray, step: float) -> None:
    assert signals.suitable_step(clock) == pytest.approx(step, rel=1e-12)


# ------------------------------------------------------------------ exports


def test_an_alignment_in_fmpy_is_that_of_replay(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    recording = of_milliseconds(ship)
    start = Start(heading=ship.reference.attitude[0, 2] + 2 * DEGREE, heading_sigma=3 * DEGREE)
    system = export_recording(recording, tmp_path, start, fmus=all_fmus)
    assert difference_from_replay(system, tmp_path, replay(recording, start, fmus=all_fmus)) <= 1e-9


def test_alignment_and_navigation_in_fmpy_are_those_of_replay(
    ship: Recording, all_fmus: Fmus, tmp_path: Path
) -> None:
    """The alignment hands over within the 30 s."""
    start = Start(heading=ship.reference.attitude[0, 2], heading_sigma=0.4 * DEGREE)
    # It starts level on a ship that sways.
    settings = {
        "alignment.error_model": "large_azimuth",
        "alignment.prior.tilt_sigma": "10 deg",
        "alignment.convergence.heading_sigma": "2 deg",
        "alignment.convergence.hold_time": 5.0,
    }
    options = {"filter": "align_then_navigate", "set": settings, "fmus": all_fmus}
    system = export_recording(ship, tmp_path, start, **options)
    run = replay(ship, start, **options)
    assert not run["heading_sigma"].to_numpy()[0] > 0
    assert run["heading_sigma"].to_numpy()[-1] > 0
    assert difference_from_replay(system, tmp_path, run) <= 1e-9


def test_an_export_holds(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    """With fixes that have no position and a reference: what is no number stays so."""
    recording = until(with_gaps(ship), 10.0)
    system = export_recording(recording, tmp_path, fmus=all_fmus)
    assert (system.name, system.step, system.stop) == ("swaying_ship", 0.01, pytest.approx(10.01))
    failed = [check for check in verify(tmp_path) if not check.holds]
    assert not failed
    for form in ("fmi2", "fmi3"):
        assert validate_fmu(str(tmp_path / form / "Playback.fmu")) == []
    assert "nan" in (tmp_path / "reference" / "Playback_ref.csv").read_text()
    page = (tmp_path / "README.md").read_text()
    assert "`Playback` plays the recording" in page
    assert "imu.rate" not in page


def test_exporting_again_gives_the_same_bytes(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    recording = until(ship, 5.0)
    for folder in ("one", "two"):
        export_recording(recording, tmp_path / folder, fmus=all_fmus)
    one, two = (
        {path.relative_to(tmp_path / folder): path.read_bytes() for path in (tmp_path / folder).rglob("*.*")}
        for folder in ("one", "two")
    )
    assert len(one) > 20
    assert one == two


def test_another_recording_makes_another_fmu(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    """Importers know an FMU by its token; one that is shown another recording is not instantiated."""
    recording = until(ship, 5.0)
    turned = replace(recording, imu=replace(recording.imu, delta_angle=-recording.imu.delta_angle))
    for folder, given in {"one": recording, "two": turned}.items():
        export_recording(given, tmp_path / folder, fmus=all_fmus)
    for form in FORMS:
        one, two = (read_archive(tmp_path / folder / form.name / "Playback.fmu") for folder in ("one", "two"))
        assert one["resources/start_values.txt"] == two["resources/start_values.txt"]
        assert one["modelDescription.xml"] != two["modelDescription.xml"]
        swapped = tmp_path / "Playback.fmu"
        write_archive(swapped, {**one, signals.FILE: two[signals.FILE]})
        with pytest.raises(Exception, match="nstantiat"):
            difference(swapped, experiment(one))


def test_a_parameter_of_playback_can_be_set(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    settings = {"gnss.outage.begin": [2.0, 0, 0, 0], "gnss.outage.end": [4.0, 0, 0, 0]}
    system = export_recording(until(ship, 5.0), tmp_path, set=settings, fmus=all_fmus)
    assert system.plant.values["gnss.outage.end[1]"] == 4.0
    with pytest.raises(InputError, match="no FMU has such a parameter"):
        export_recording(until(ship, 5.0), tmp_path, set={"gnss.outages": 4.0}, fmus=all_fmus)


# ------------------------------------------------------------------ the command


@pytest.fixture
def csv(ship: Recording, tmp_path: Path) -> Path:
    return as_csv(until(ship, 5.0), tmp_path / "a recorded ship.csv")


def test_the_command(csv: Path, tmp_path: Path) -> None:
    folder = tmp_path / "partner"
    arguments = ["export", str(csv), "-o", str(folder), "--heading", "10", "--json"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert said["recording"] == "a_recorded_ship"
    assert said["communication_step"] == 0.01
    assert Path(said["ssp"]).exists()
    parameters = (folder / "parameters" / "filter.ssv").read_text()
    assert f'"initial.heading"><ssv:Real value="{10 * DEGREE}"' in parameters
    assert load_recording(csv).imu.time[-1] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("what", "options", "sentence"),
    [
        ("csv", ["--seed", "3"], "which has no random streams"),
        ("swaying_ship", ["--heading", "3"], "swaying_ship is a scenario; --filter and"),
        ("swaying_ship", ["--filter", "navigation"], "are for recordings"),
        ("csv", ["--start", "course", "--course-speed", "80"], "no fix of the IMU's time is as fast as 80"),
    ],
)
def test_options_of_the_other_kind_are_refused(
    csv: Path, what: str, options: list[str], sentence: str
) -> None:
    result = CliRunner().invoke(app, ["export", str(csv) if what == "csv" else what, *options])
    assert result.exit_code == 2
    assert sentence in " ".join(result.output.split())
