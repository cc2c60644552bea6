"""Mechanisation of the filter FMU and increments of the plant FMU against pyins (Savage's algorithm).

The chain TruthPlant -> AlignmentFilter with perfect start, error-free IMU and no fix is pure mechanisation;
pyins integrates the same increments in its own frames (NED, forward-right-down).
"""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from pyins.strapdown import Integrator

from sim_scenarios.attitude import wrap
from sim_scenarios.connection import TRUTH, connect
from sim_scenarios.cosimulation import Table
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Port
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import ARCMIN

Array = NDArray[np.float64]
DURATION = 600.0
STEP = 0.01
ARCSEC = ARCMIN / 60
INCREMENTS = tuple(f"imu.{kind}[{i}]" for kind in ("delta_angle", "delta_velocity") for i in (1, 2, 3))
NAVIGATION = tuple(name.replace("truth.", "nav.") for name in TRUTH)
IDEAL = {
    "imu.gyro.bias_sigma": 0.0,
    "imu.gyro.white_noise": 0.0,
    "imu.accelerometer.bias_sigma": 0.0,
    "imu.accelerometer.white_noise": 0.0,
    "gnss.outage.begin": [0.0, 0.0, 0.0, 0.0],
    "gnss.outage.end": [DURATION + 1.0, 0.0, 0.0, 0.0],
    "initial_error.misalignment": [0.0, 0.0, 0.0],
    # The unscented predictor moves the mean of a wide prior even without a fix; the linearised one does not.
    "predictor": "linearised",
}


@pytest.fixture(scope="module", params=["swaying_ship", "waves", "zigzag"])
def signals(request: pytest.FixtureRequest, fmus: Fmus) -> tuple[dict[str, Array], dict[str, Array]]:
    """Increments and truth of the plant, and navigation of the filter, at every step."""
    scenario = load_scenario(request.param, fmus, settings=IDEAL)
    steps = round(DURATION / STEP)
    with ExitStack() as stack:
        source, (sink,) = connect(scenario, fmus, {"filter": scenario.filter}, stack)
        plant_table = Table(Port(source.instance, (*INCREMENTS, *TRUTH)), steps + 1)
        filter_table = Table(Port(sink.instance, (*NAVIGATION, "used_fixes")), steps + 1)
        plant_table.append()
        filter_table.append()
        for k in range(steps):
            source.advance(k * STEP, STEP)
            sink.receive()
            sink.advance(k * STEP, STEP)
            plant_table.append()
            filter_table.append()
        return plant_table.columns(), filter_table.columns()


def vectors(table: dict[str, Array], name: str) -> Array:
    """Components `name[1..3]` as rows, shape (n, 3)."""
    return np.column_stack([table[f"{name}[{i}]"] for i in (1, 2, 3)])


def test_the_filter_mechanises_as_exactly_as_the_plant_moves(
    signals: tuple[dict[str, Array], dict[str, Array]],
) -> None:
    plant, navigation = signals
    assert navigation["used_fixes"][-1] == 0
    for angle in ("roll", "pitch", "heading"):
        error = wrap(navigation[f"nav.{angle}"] - plant[f"truth.{angle}"])
        assert np.abs(error).max() < 1e-3 * ARCSEC, angle
    error = vectors(navigation, "nav.velocity") - vectors(plant, "truth.velocity")
    assert np.abs(error).max() < 1e-5


def test_pyins_agrees(signals: tuple[dict[str, Array], dict[str, Array]]) -> None:
    """Pyins omits the second-order rotation compensation, which is therefore in the increments it gets."""
    plant, _ = signals
    # Body: forward, right, down from right, forward, up.
    angle = vectors(plant, "imu.delta_angle")[:, [1, 0, 2]] * [1, 1, -1]
    velocity = vectors(plant, "imu.delta_velocity")[:, [1, 0, 2]] * [1, 1, -1]
    before_angle = np.vstack([np.zeros(3), angle[1:-1]])
    before_velocity = np.vstack([np.zeros(3), velocity[1:-1]])
    angle, velocity = angle[1:], velocity[1:]
    theta = angle + np.cross(before_angle, angle) / 12
    dv = (
        velocity
        + np.cross(angle, velocity) / 2
        + np.cross(angle, np.cross(angle, velocity)) / 6
        + (np.cross(before_angle, velocity) + np.cross(before_velocity, angle)) / 12
    )
    time = STEP * np.arange(1, len(theta) + 1)
    columns = ["dt", "theta_x", "theta_y", "theta_z", "dv_x", "dv_y", "dv_z"]
    increments = pd.DataFrame(
        np.column_stack([np.full(len(time), STEP), theta, dv]), index=time, columns=columns
    )

    east, north, up = (plant[f"truth.velocity[{i}]"] for i in (1, 2, 3))
    pva = pd.Series(
        {
            "lat": np.rad2deg(plant["truth.latitude"][0]),
            "lon": np.rad2deg(plant["truth.longitude"][0]),
            "alt": plant["truth.height"][0],
            "VN": north[0],
            "VE": east[0],
            "VD": -up[0],
            "roll": np.rad2deg(plant["truth.roll"][0]),
            "pitch": np.rad2deg(plant["truth.pitch"][0]),
            "heading": np.rad2deg(plant["truth.heading"][0]),
        },
        name=0.0,
    )
    trajectory = Integrator(pva).integrate(increments)

    for angle_name in ("roll", "pitch", "heading"):
        error = wrap(np.deg2rad(trajectory[angle_name].to_numpy()) - plant[f"truth.{angle_name}"])
        assert np.abs(error).max() < 1e-3 * ARCSEC, angle_name
    for column, expected in (("VN", north), ("VE", east), ("VD", -up)):
        assert np.abs(trajectory[column].to_numpy() - expected).max() < 1e-5, column
