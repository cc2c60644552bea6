"""Recordings that nobody here made or tuned anything to: a car between two stoplights, and small aircraft.

They come with the package `onavdata`, which is no dependency (HGuide n380, 2021-03-29; UMN UAV flights).
"""

from __future__ import annotations

import importlib.util
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sim_scenarios
from sim_scenarios import Start, toml
from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmus
from sim_scenarios.recordings import load
from sim_scenarios.recordings.checks import doubts
from sim_scenarios.recordings.derive import derive
from sim_scenarios.recordings.drafting import draft
from sim_scenarios.units import DEGREE

PACKAGE = importlib.util.find_spec("onavdata")
pytestmark = pytest.mark.skipif(PACKAGE is None, reason="the package onavdata is not installed")
STOPLIGHTS = "data/HGuide n380/2021-03-29-automotive-stoplight-to-stoplight"
LEVER_ARM = "[0.10, -1.46, 1.46]"  # right, forward, up; fitted by those who know the car, on another drive
FLIGHTS = "data/2014-09-09 UofMN Conservancy 7 UAV Flights/Processed and Parsed Data"


def unpacked(folder: str, name: str, into: Path) -> Path:
    assert PACKAGE is not None
    assert PACKAGE.origin is not None
    with zipfile.ZipFile(Path(PACKAGE.origin).parent / folder / f"{name}.zip") as archive:
        archive.extractall(into)
    return into / name


def described(files: list[Path], folder: Path) -> Path:
    text, _ = draft(files, folder)
    (folder / "recording.toml").write_text(text)
    return folder / "recording.toml"


def test_a_car_finds_its_heading_between_two_stoplights(tmp_path: Path, fmus: Fmus) -> None:
    """From nothing, with the noise of the rest before it: the drive itself is too short to tell any."""
    names = ("n380-imu-nav.csv", "n380-gnss-pvt.csv", "n380-attitude.csv")
    path = described([unpacked(STOPLIGHTS, name, tmp_path) for name in names], tmp_path)
    assert toml.read(path)["imu"]["axes"] == "down-right-backward"
    path.write_text(path.read_text().replace("lever_arm = [0.0, 0.0, 0.0]", f"lever_arm = {LEVER_ARM}"))
    recording = load(path)
    derived = derive(recording, filter_fmu=ALIGNMENT_FILTER, fmus=fmus)
    assert derived.unused is not None
    told = {one.name: one.value for one in derived.findings if one.value is not None}
    told |= {"error_model": "invariant", "predictor": "linearised", "corrector": "standard"}
    run = sim_scenarios.replay(recording, Start(), set=told, fmus=fmus)
    error = np.abs(wrap(run["heading_error"].values[-1]))
    sigma = float(run["heading_sigma"].values[-1])
    assert sigma < 0.5 * DEGREE
    assert error < 3 * np.hypot(sigma, 0.2 * DEGREE)  # the unit knows its own heading to 0.2 deg
    assert int(run["rejected_fixes"].values[-1]) == 0


@pytest.mark.parametrize("flight", ["THOR-Flight-79", "FASER-Flight-5", "GPSFASER-Flight-3"])
def test_rates_of_an_aircraft_are_told_from_degrees_by_its_course(flight: str, tmp_path: Path) -> None:
    """It turns all the time and its forces tell no tilt: the size of its rates is that of degrees.

    Gyros and accelerometers are in two files, as they are, and in one.
    """
    kinds = ("accel_data", "gyro_data", "gps_traj_data", "gps_velocity_data")
    files = [unpacked(f"{FLIGHTS}/{flight}", f"{kind}.txt", tmp_path) for kind in kinds]
    accel, gyro, place, velocity = map(pd.read_csv, files)
    accel.merge(gyro, on="time").to_csv(tmp_path / "imu.csv", index=False)
    fixes = place.merge(velocity, on="time")
    fixes[fixes.drop(columns="time").diff().abs().sum(axis=1) > 0].to_csv(tmp_path / "gnss.csv", index=False)
    path = described([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    assert toml.read(path)["imu"]["units"]["angular"] == "rad/s"
    recording = load(path)
    assert not [doubt for doubt in doubts(replace(recording, remarks=())) if "delta angles" in doubt]
    halves = load(described([*files[:2], tmp_path / "gnss.csv"], tmp_path))
    np.testing.assert_array_equal(halves.imu.delta_angle, recording.imu.delta_angle)
    np.testing.assert_allclose(halves.imu.delta_velocity, recording.imu.delta_velocity, rtol=0, atol=1e-11)
