"""A car with a MEMS IMU and an RTK receiver, from its two files as they are: nothing was tuned to it.

The recording does not come with the repository: `drive_0708` of rtklibexplorer/GNSS_IMU, IMU and solution
file, in the folder `car_drive` of the recordings.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from played import difference_from_replay, until

import sim_scenarios
from sim_scenarios import Outages, Start
from sim_scenarios.exchange import export_recording
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLAYBACK, Fmus, load
from sim_scenarios.recordings import Recording, comparison, outages
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.units import DEGREE

FOLDER = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "car_drive").absolute()
pytestmark = pytest.mark.skipif(
    not (FOLDER / "imu.csv.gz").exists(), reason="no car_drive in the folder TRUENORTH_RECORDINGS"
)
DESCRIPTION = """
name = "car drive"

[imu]
file = "{folder}/imu.csv.gz"
clock = "gps-day"
axes = "forward-right-down"
mounting = [[-0.98866, -0.092586, 0.118231], [-0.093239, 0.995644, 0.0], [-0.117716, -0.011024, -0.992986]]
units = {{ angular = "deg/s", force = "g" }}

[imu.columns]
time = "time_gpst_s"
angular = ["gx_dps", "gy_dps", "gz_dps"]
force = ["ax_g", "ay_g", "az_g"]

[gnss]
file = "{folder}/gnss.pos.gz"
lever_arm = [-0.05, 0.0, 0.0]
"""
# Eight times what the owner's bench gives of the sensor: on the road vibration is larger by almost ten.
ROAD: dict[str, object] = {
    "process.angle_random_walk": 8 * 0.0038 * DEGREE,
    "process.velocity_random_walk": "1120 ug/Hz^0.5",
    "prior.gyro_bias_sigma": 0.2 * DEGREE,
    "prior.accelerometer_bias_sigma": 0.1,
}
# The solution takes itself for surer than it is: what the independent script assumes of the fixes.
FIXES: dict[str, object] = {
    "measurement.position_sigma": 0.05,
    "measurement.height_sigma": 0.05,
    "measurement.velocity_sigma": 0.15,
    "filter.gate.enabled": False,
}
MOVING_OFF = Start(course_above=3.0)


@pytest.fixture(scope="module")
def fmus_of_filters() -> Fmus:
    return Fmus({name: load(name) for name in (ALIGNMENT_FILTER, NAVIGATION_FILTER)})


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("car") / "recording.toml"
    path.write_text(DESCRIPTION.format(folder=FOLDER.as_posix()))
    return load_recording(path)


@pytest.fixture(scope="module")
def without_sigmas(drive: Recording) -> Recording:
    zero = np.zeros_like(drive.gnss.position_sigma)
    return replace(drive, gnss=replace(drive.gnss, position_sigma=zero, velocity_sigma=zero))


def navigated(drive: Recording, fmus: Fmus, length: float | None = None, **settings: object) -> xr.Dataset:
    dark = None if length is None else Outages(length, {15.0: 45.0, 60.0: 120.0}[length])
    return sim_scenarios.replay(
        drive, MOVING_OFF, filter="navigation", outages=dark, set={**ROAD, **settings}, fmus=fmus
    )


def test_the_drive_is_that_of_the_two_files(drive: Recording) -> None:
    assert np.median(np.diff(drive.imu.time)) == pytest.approx(0.01, abs=1e-3)
    assert np.median(np.diff(drive.gnss.time)) == pytest.approx(0.25, abs=1e-3)
    assert np.ptp(drive.imu.time) == pytest.approx(549, abs=2)
    force = drive.imu.delta_velocity[:1000].sum(axis=0)
    assert force[2] > np.cos(3 * DEGREE) * np.linalg.norm(force)  # it stands, level


@pytest.mark.parametrize("model", ["loose", "invariant"])
def test_it_stays_on_its_track(without_sigmas: Recording, fmus_of_filters: Fmus, model: str) -> None:
    run = navigated(without_sigmas, fmus_of_filters, **FIXES, error_model=model)
    found = comparison.against_fixes(run)
    assert found.horizontal < 0.10  # the independent script: 0.10 m, 0.02 m, 1.2 deg; 0.092, 0.025, 1.26 here
    assert found.vertical < 0.03
    assert found.heading_deviation < 1.3 * DEGREE
    assert int(run["missed_samples"].values[-1]) == 0
    assert int(run["rejected_fixes"].values[-1]) == 0


@pytest.mark.parametrize(
    ("length", "count", "others"),
    [(15.0, 11, 7.1), (60.0, 4, 371.0)],  # RMS of KF-GINS on the same increments, fixes and noise [m]
)
def test_the_ends_of_outages_are_no_worse_than_those_of_others(
    without_sigmas: Recording, fmus_of_filters: Fmus, length: float, count: int, others: float
) -> None:
    run = navigated(without_sigmas, fmus_of_filters, length, **FIXES)
    ends = outages.ends(run)
    assert len(ends) == count
    rms = outages.figures(ends)["horizontal_rms_m"]
    assert rms == pytest.approx(others, rel=0.03)


def test_the_sigmas_of_the_fixes_are_worth_being_told(drive: Recording, fmus_of_filters: Fmus) -> None:
    run = navigated(drive, fmus_of_filters, 15.0, **{"filter.gate.enabled": False})
    ends = outages.ends(run)
    assert outages.figures(ends)["horizontal_rms_m"] < 7.0
    assert not any(end.converged and end.horizontal > 3 * end.sigma for end in ends)


@pytest.mark.parametrize(
    ("task", "settings"),
    [
        ("align_then_navigate", {}),
        ("navigation", {"error_model": "invariant", "predictor": "linearised"}),
    ],
)
def test_it_finds_its_heading_from_standstill(
    without_sigmas: Recording, fmus_of_filters: Fmus, task: str, settings: dict[str, object]
) -> None:
    """No heading is told; the car stands for 25 s. Its straight first street tells the heading late."""
    told = {**ROAD, **FIXES, **settings}
    run = sim_scenarios.replay(
        without_sigmas, filter=task, evaluate_after=150.0, set=told, fmus=fmus_of_filters
    )
    found = comparison.against_fixes(run)
    assert found.horizontal < 0.15
    assert abs(found.heading_mean) < 1.0 * DEGREE
    assert found.heading_deviation < 1.3 * DEGREE
    time, off = comparison.heading_minus_course(run)
    sure = np.interp(time, run["time"].values, run["converged"].values.astype(float)) > 0.5
    assert not np.any(sure & (np.abs(off) > 10 * DEGREE))


def test_it_is_put_out_by_playback_and_navigated_on_in_fmpy(drive: Recording, tmp_path: Path) -> None:
    """A minute after it moves off; stamps 8 to 11 ms apart, so that a step of 5 ms never covers two."""
    start = Start(course_above=3.0)
    moved_off = until(drive, 100.0)
    fmus = Fmus({name: load(name) for name in (PLAYBACK, NAVIGATION_FILTER)})
    system = export_recording(moved_off, tmp_path, start, filter="navigation", set=ROAD, fmus=fmus)
    assert system.step == 0.005
    run = sim_scenarios.replay(moved_off, start, filter="navigation", set=ROAD, fmus=fmus)
    assert difference_from_replay(system, tmp_path, run) <= 1e-9
