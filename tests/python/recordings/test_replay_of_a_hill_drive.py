"""A car with an integrated unit, whose own navigation is a reference of attitude; nothing was tuned to it.

The recording comes with the package `onavdata`, which is no dependency (HGuide n380, 2021-04-27C). The car
stands until about 164 s, and the unit knows its own heading to 0.2 deg from 210 s on.
"""

from __future__ import annotations

import importlib.util
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import Start, toml
from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import NAVIGATION_FILTER, Fmus, load
from sim_scenarios.metrics import certainty
from sim_scenarios.recordings import Recording
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings.derive import Derivation, derive
from sim_scenarios.recordings.drafting import draft
from sim_scenarios.units import DEGREE

PACKAGE = importlib.util.find_spec("onavdata")
pytestmark = pytest.mark.skipif(PACKAGE is None, reason="the package onavdata is not installed")
DRIVE = "data/HGuide n380/2021-04-27C-car-hill-drive"
FILES = ("n380-imu-nav.csv", "n380-gnss-pvt.csv", "n380-attitude.csv")
LEVER_ARM = "[0.10, -1.46, 1.46]"  # right, forward, up; fitted by those who know the car
A_MINUTE_AFTER_MOVING_OFF = 225.0  # s
INVARIANT = {"error_model": "invariant", "predictor": "linearised"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert PACKAGE is not None
    assert PACKAGE.origin is not None
    folder = tmp_path_factory.mktemp("hill")
    for name in FILES:
        with zipfile.ZipFile(Path(PACKAGE.origin).parent / DRIVE / f"{name}.zip") as archive:
            archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def description(folder: Path) -> Path:
    """As drafted, with the lever arm filled in, and without a lag that a lever arm looks like."""
    text, _ = draft([folder / name for name in FILES], folder)
    text = text.replace("lever_arm = [0.0, 0.0, 0.0]", f"lever_arm = {LEVER_ARM}").replace(
        'offset = "found"', ""
    )
    path = folder / "recording.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def drive(description: Path) -> Recording:
    return load_recording(description)


@pytest.fixture(scope="module")
def fmus() -> Fmus:
    return Fmus({NAVIGATION_FILTER: load(NAVIGATION_FILTER)})


@pytest.fixture(scope="module")
def noise(drive: Recording, fmus: Fmus) -> Derivation:
    return derive(drive, fmus=fmus)


def test_the_draft_is_right(description: Path) -> None:
    said = toml.read(description)
    assert said["imu"]["units"] == {"time": "s", "angular": "rad", "force": "m/s"}
    assert said["imu"]["axes"] == "down-right-backward"  # the case's, from its description: -z, y, x
    assert said["gnss"]["units"] == {"time": "s", "position": "rad", "velocity": "m/s"}
    assert said["gnss"]["columns"]["velocity"] == ["GnssVelocityE", "GnssVelocityN", "-GnssVelocityD"]
    assert said["gnss"]["columns"]["velocity_sigma"] == ["GnssStdvE", "GnssStdvN", "GnssStdvD"]
    assert said["reference"]["units"] == {"time": "s", "attitude": "rad"}


CASES: dict[str, tuple[Start, dict[str, object]]] = {
    "loose, from the course": (Start(course_above=3.0), {"error_model": "loose"}),
    "invariant, from the course": (Start(course_above=3.0), INVARIANT),
    "invariant, from no heading": (Start(), INVARIANT),
    "invariant, from a wrong heading": (Start(heading=135.0 * DEGREE), INVARIANT),
    "loose, from a wrong heading": (Start(heading=180.0 * DEGREE), {"error_model": "loose"}),
    "loose, from the opposite heading": (Start(heading=90.0 * DEGREE), {"error_model": "loose"}),
}


@pytest.mark.parametrize("case", CASES)
def test_it_agrees_with_the_unit_and_is_never_wrongly_sure(
    case: str, drive: Recording, noise: Derivation, fmus: Fmus
) -> None:
    start, settings = CASES[case]
    told = {finding.name: finding.value for finding in noise.findings if finding.value is not None}
    run = sim_scenarios.replay(drive, start, filter="navigation", set={**told, **settings}, fmus=fmus)
    assert wrongly_sure(run) == 0.0
    assert run["converged"].values.astype(bool).mean() > 0.4
    late = run["time"].values > A_MINUTE_AFTER_MOVING_OFF
    error = wrap(run["heading_error"].values)[late]
    assert np.sqrt(np.mean(error**2)) < 0.6 * DEGREE
    assert np.abs(error[-1]) < 1.0 * DEGREE


@pytest.mark.parametrize("settings", [{"error_model": "loose"}, INVARIANT])
def test_told_of_a_better_sensor_it_does_not_claim_to_know(
    settings: dict[str, object], drive: Recording, fmus: Fmus
) -> None:
    """The noise of a navigation-grade IMU, which is the default, for one that is not."""
    run = sim_scenarios.replay(drive, Start(course_above=3.0), filter="navigation", set=settings, fmus=fmus)
    assert wrongly_sure(run) < 10.0


def wrongly_sure(run: xr.Dataset) -> float:
    """For how long [s]."""
    return certainty.of_run(run).wrongly
