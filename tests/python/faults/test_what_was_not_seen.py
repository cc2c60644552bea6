"""What happened while nothing was measured, before a hand-over, or elsewhere: no filter is sure of it."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from generator import RATE, Drive
from numpy.typing import NDArray
from wire import STATUS, Fed, Wire, run

from sim_scenarios.fmus import NAVIGATION_FILTER, Fmus

Array = NDArray[np.float64]
Columns = dict[str, NDArray[np.generic]]

OUTPUTS = [
    *(f"nav.{name}" for name in ("latitude", "longitude", "height", "heading", "time")),
    *("heading_sigma", "status", "converged", "used_fixes"),
]
EVERY = 10
DEGREE = np.deg2rad(1.0)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return Drive(duration=260.0)


def fed(
    fmus: Fmus, drive: Drive, columns: Columns, **told: object
) -> tuple[dict[str, Array], Array, list[str]]:
    """Outputs of a NavigationFilter, its heading error and what it said."""
    fmu, values = fmus[NAVIGATION_FILTER], {}
    for name, value in drive.told(**told).items():
        values |= fmu.assignments(name, value)
    out, messages = Fed(fmu, columns, values).run(drive.time, OUTPUTS, every=EVERY)
    _, heading = drive.errors(out, np.arange(0, len(drive.time), EVERY))
    return out, heading, [message.text for message in messages]


@pytest.mark.parametrize("model", ["loose", "full_state", "invariant"])
def test_a_turn_that_no_sample_tells_is_doubted(model: str, drive: Drive, fmus: Fmus) -> None:
    """11 s without IMU data, in which the vehicle turns by 64 deg; its heading was known to 1 deg."""
    first, last = round(102 * RATE), round(113 * RATE)
    columns = dict(drive.columns)
    for name in [name for name in columns if name.startswith("imu.")]:
        columns[name] = columns[name].copy()
        columns[name][first:last] = columns[name][first]
    out, heading, messages = fed(fmus, drive, columns, error_model=model, predictor="linearised")
    before, after = first // EVERY - 1, last // EVERY + 1
    assert out["heading_sigma"][before] < DEGREE
    assert abs(heading[after]) > 30 * DEGREE
    assert out["heading_sigma"][after] > 30 * DEGREE
    wrong = out["converged"].astype(bool) & (np.abs(heading) > 3 * out["heading_sigma"])
    assert wrong.sum() * EVERY / RATE <= 0.5  # until silence is one
    assert abs(heading[-1]) < min(2 * DEGREE, 3 * out["heading_sigma"][-1])
    assert any("after a gap that cannot be bridged" in text for text in messages)


@pytest.mark.parametrize("seconds", [1.5, 8.6])
@pytest.mark.parametrize("refused", [False, True])
@pytest.mark.parametrize("model", ["loose", "full_state", "invariant"])
def test_fixes_from_inside_a_gap_teach_nothing(
    model: str, refused: bool, seconds: float, drive: Drive, fmus: Fmus
) -> None:
    """34 fixes come in 8.6 s whose samples do not, or are no numbers, while the vehicle turns."""
    first, last = round(102 * RATE), round((102 + seconds) * RATE)
    columns = dict(drive.columns)
    for name in [name for name in columns if name.startswith("imu.")]:
        columns[name] = columns[name].copy()
        if not refused:
            columns[name][first:last] = columns[name][first]
        elif name.startswith("imu.delta"):
            columns[name][first:last] = np.nan
    out, heading, _ = fed(fmus, drive, columns, error_model=model, predictor="linearised")
    assert not out["converged"][first // EVERY + 10 : last // EVERY].any()
    wrong = out["converged"].astype(bool) & (np.abs(heading) > 3 * out["heading_sigma"])
    assert wrong.sum() * EVERY / RATE <= 0.5  # until silence is one
    horizontal, _ = drive.errors(out, np.arange(0, len(drive.time), EVERY))
    assert np.max(horizontal[(last + round(15 * RATE)) // EVERY :]) < 0.2
    assert abs(heading[-1]) < min(2 * DEGREE, 3 * out["heading_sigma"][-1])


def handed(heading: float, gyro: float) -> dict[str, float]:
    """A covariance that an alignment hands over, of these sigmas [rad], [rad/s], the rest as the prior."""
    sigma = [DEGREE, DEGREE, heading, *3 * [0.1], *3 * [gyro], *3 * [0.1]]
    return {f"initial.covariance[{i},{i}]": s**2 for i, s in enumerate(sigma, 1)}


@pytest.mark.parametrize("late", [0.0, 0.06, 1.4e9])
def test_a_handed_covariance_outlives_the_first_sample(late: float, drive: Drive, fmus: Fmus) -> None:
    """Whatever its stamp: before it there is nothing that could have been missed."""
    columns = dict(drive.columns)
    for name in ("imu.time", "gnss.time"):
        columns[name] = columns[name] + late
    told = {"error_model": "loose", **handed(60 * DEGREE, DEGREE)}
    out, _, messages = fed(fmus, drive, columns, **told)
    assert out["heading_sigma"][1] == pytest.approx(60 * DEGREE, rel=1e-2)
    assert not any("gap that cannot be bridged" in text for text in messages)


def test_a_hand_over_is_taken_although_the_clock_was_set(drive: Drive, fmus: Fmus) -> None:
    """The filter waits while the clock of the IMU leaps; what is handed over has its stamp."""
    columns = dict(drive.columns)
    leapt = (drive.time >= 10.0) * 1.0
    columns["imu.time"] = columns["imu.time"] + leapt
    columns["gnss.time"] = columns["gnss.time"] + (columns["gnss.time"] >= 10.0)
    columns["initial.valid"] = (drive.time >= 20.0).astype(np.int32)
    columns["initial.time"] = columns["imu.time"]
    out, heading, messages = fed(fmus, drive, columns, error_model="loose")
    assert out["status"][100] == STATUS["waiting"]
    assert out["status"][210] != STATUS["waiting"]
    assert out["used_fixes"][-1] > 800
    assert abs(heading[-1]) < DEGREE
    assert not any("refused" in text for text in messages)


def nowhere(begin: float, end: float):
    """Zeros, as many receivers put out without a fix."""

    def fault(time: float, wire: Wire) -> None:
        if begin <= time < end:
            for name in ("gnss.latitude", "gnss.longitude", "gnss.height"):
                wire[name] = 0.0
            wire.put("gnss.velocity", np.zeros(3))

    return fault


def test_a_single_fix_of_zeros_after_an_outage_is_no_place(fmus: Fmus) -> None:
    zeros = nowhere(470.0, 470.5)
    last: dict[str, float] = {}

    def fault(time: float, wire: Wire) -> None:
        if time <= 400.0:
            last.update(wire.gnss())
        elif time < 470.0:
            wire.restore(last)
        zeros(time, wire)

    data: xr.Dataset = run("waves", fmus, fault, settings={"duration": 600.0})
    assert not (np.abs(data["nav.latitude"].values) < 0.01).any()
    assert int(data["used_fixes"][-1]) > 500


@pytest.mark.parametrize("model", ["loose", "invariant"])
def test_a_first_sample_that_was_waited_for_finds_an_attitude_in_doubt(
    model: str, drive: Drive, fmus: Fmus
) -> None:
    """30 s after the start, from another epoch of stamps."""
    first = round(30 * RATE)
    columns = dict(drive.columns)
    for name in ("imu.time", "gnss.time"):
        columns[name] = columns[name] + 1.4e9
    for name in [name for name in columns if name.startswith("imu.")]:
        columns[name] = columns[name].copy()
        columns[name][:first] = columns[name][0]
    out, _, messages = fed(fmus, drive, columns, error_model=model, **handed(DEGREE, DEGREE))
    assert out["heading_sigma"][first // EVERY + 1] > 30 * DEGREE
    assert any("after a gap that cannot be bridged" in text for text in messages)


@pytest.mark.parametrize("seconds", [40.0, 120.0])
def test_zeros_are_no_place(seconds: float, fmus: Fmus) -> None:
    """Of a ship that moves they are refused, as out of reach and then by their velocity."""
    data: xr.Dataset = run("waves", fmus, nowhere(400.0, 400.0 + seconds), settings={"duration": 1000.0})
    assert not (np.abs(data["nav.latitude"].values) < 0.01).any()
    wrong = np.abs(data["heading_error"].values) > 3 * data["heading_sigma"].values
    assert not (data["converged"].values & wrong).any()
    end = data.isel(time=-1)
    assert abs(float(end["nav.latitude"]) - float(end["truth.latitude"])) < 1e-4
    assert bool(end["converged"])
