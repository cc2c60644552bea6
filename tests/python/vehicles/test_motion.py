"""The ship fed from its own truth measures what it measured, as far as its points tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sailing
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Columns
from sim_scenarios.earth import displacement
from sim_scenarios.fmus import Fmus
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles import Points, Vehicle

Array = NDArray[np.float64]

RATES = ("acceleration", "rate")


@pytest.fixture(scope="module")
def alone(fmus: Fmus) -> Columns:
    """What the ship puts out that nobody drives."""
    return sailing.put_out(sailing.sailing(fmus), fmus)


@pytest.fixture(scope="module")
def told(alone: Columns) -> dict[str, Array]:
    """Columns of its trajectory."""
    return sailing.columns(alone, alone["imu.time"])


def largest(difference: list[Array]) -> float:
    return max(float(np.abs(one).max()) for one in difference)


@pytest.mark.parametrize(
    ("every", "without", "angle", "velocity"),
    [
        (1, (), 1e-9, 1e-9),  # as the issue asks
        (1, RATES, 1e-9, 1e-9),
        (2, RATES, 1e-9, 1e-9),
        (10, (), 2e-8, 4e-8),
        (10, RATES, 2e-8, 4e-8),
        (10, (*RATES, "velocity"), 2e-8, 2e-7),
        (50, (), 3e-6, 6e-6),
        (50, RATES, 1e-5, 1e-5),
    ],
)
def test_the_ship_from_its_own_truth(
    every: int,
    without: tuple[str, ...],
    angle: float,
    velocity: float,
    alone: Columns,
    told: dict[str, Array],
    fmus: Fmus,
    tmp_path: Path,
) -> None:
    """Increments [rad], [m/s] of each 0.01 s; docs/scenarios.md tells these figures."""
    path = sailing.written(told, tmp_path / "ship.csv", every, without)
    got = sailing.put_out(sailing.sailing(fmus, trajectory=str(path)), fmus)
    for name in (*sailing.COUNTS, "imu.time"):
        np.testing.assert_array_equal(got[name], alone[name])
    assert np.ptp(alone["gnss.sample"]) > 50
    for names, limit in ((sailing.DELTA_ANGLE, angle), (sailing.DELTA_VELOCITY, velocity)):
        assert largest([got[name] - alone[name] for name in names]) < limit
    positions = (np.column_stack([one[name] for name in sailing.FIX]) for one in (got, alone))
    assert np.abs(displacement(*positions)).max() < 1e-5  # m


def test_the_error_falls_with_the_cube_of_the_spacing(
    alone: Columns, told: dict[str, Array], fmus: Fmus, tmp_path: Path
) -> None:
    """As that of the derivative of a cubic."""
    errors = []
    for every in (20, 40):
        path = sailing.written(told, tmp_path / f"{every}.csv", every)
        got = sailing.put_out(sailing.sailing(fmus, trajectory=str(path)), fmus)
        errors.append(largest([got[name] - alone[name] for name in sailing.DELTA_VELOCITY]))
    assert 6 < errors[1] / errors[0] < 10


def states(points: Points, time: list[float]) -> Array:
    return Vehicle(points).states(np.array(time))


def test_every_point_is_passed() -> None:
    random = np.random.default_rng(4)
    time = 100 + np.cumsum(random.uniform(0.5, 2, 12))
    longitude = (1e-6 * (time - time[6])) % (2 * np.pi) - np.pi  # crosses the date line
    position = np.column_stack((0.5 + 1e-6 * time, longitude, 20 * np.sin(time / 5)))
    attitude = np.column_stack((0.4 * np.sin(time), 0.2 * np.cos(time), time / 3 % (2 * np.pi)))
    got = Vehicle(Points(time, position, attitude)).states(time - time[0])
    np.testing.assert_allclose(got[:, 0], time - time[0])
    np.testing.assert_allclose(np.abs(displacement(got[:, 1:4], position)), 0, atol=1e-8)
    np.testing.assert_allclose(got[:, 7:9], attitude[:, :2], atol=1e-12)
    np.testing.assert_allclose(np.cos(got[:, 9] - attitude[:, 2]), 1, atol=1e-12)


def test_position_velocity_and_acceleration_are_of_one_motion() -> None:
    """And body rates of the attitude: by differences, between points that are far apart."""
    time = np.arange(0, 60, 1.5)
    position = np.column_stack((0.5 + 1e-5 * np.sin(time / 9), 2 + 1e-5 * np.cos(time / 7), 100 + time))
    attitude = np.column_stack((0.3 * np.sin(time / 3), 0.2 * np.sin(time / 2), time / 10))
    step = 1e-3
    before, now, after = (states(Points(time, position, attitude), [29.2 + x]) for x in (-step, 0, step))
    moved = displacement(after[:, 1:4], before[:, 1:4]) / (2 * step)
    np.testing.assert_allclose(moved, now[:, 4:7], atol=2e-3)  # the residual at the next point is spread
    np.testing.assert_allclose((after - before)[:, 4:7] / (2 * step), now[:, 10:13], atol=1e-6)
    roll, pitch, _ = now[0, 7:10]
    roll_rate, pitch_rate, heading_rate = (after - before)[0, 7:10] / (2 * step)
    up = -heading_rate * np.cos(pitch)
    expected = [
        np.cos(roll) * pitch_rate - np.sin(roll) * up,
        roll_rate - np.sin(pitch) * heading_rate,
        np.sin(roll) * pitch_rate + np.cos(roll) * up,
    ]
    np.testing.assert_allclose(now[0, 13:], expected, atol=1e-7)


def test_two_points_are_a_straight_line() -> None:
    points = Points(
        np.array([5.0, 15.0]), np.array([[0.5, 2, 0], [0.5, 2, 30]]), np.array([[0, 0, 0.2], [0, 0, 0.4]])
    )
    [state] = states(points, [5.0])
    np.testing.assert_allclose(state[1:7], [0.5, 2, 15, 0, 0, 3], atol=1e-12)
    np.testing.assert_allclose(state[7:10], [0, 0, 0.3], atol=1e-12)
    np.testing.assert_allclose(
        state[10:], [0, 0, 0, 0, 0, -0.02], rtol=1e-3, atol=1e-12
    )  # a chord of the turn


def test_without_attitude_it_points_where_it_goes() -> None:
    time = np.arange(10.0)
    climbing = np.column_stack((0.5 + 1e-6 * time, np.full(10, 2.0), 6.3 * time))
    [state] = states(Points(time, climbing), [4.5])
    assert state[7] == pytest.approx(0)
    assert np.tan(state[8]) == pytest.approx(6.3 / np.hypot(*state[4:6]))
    assert state[9] / DEGREE == pytest.approx(0, abs=1e-6)
