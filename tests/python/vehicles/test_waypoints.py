"""Ways past places: straight on, at one speed, turning no faster than is said."""

from __future__ import annotations

import numpy as np
import pymap3d
import pytest
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.errors import InputError
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles.waypoints import vehicle

Array = NDArray[np.float64]

LATITUDE, LONGITUDE = 32 * DEGREE, 118 * DEGREE
SPEED, TURN_RATE = 8.0, 2 * DEGREE


def place(east: float, north: float, height: float = 0.0) -> tuple[float, float, float]:
    """Place [m] from the first one."""
    latitude, longitude, _ = pymap3d.enu2geodetic(east, north, 0.0, 32, 118, 0.0)
    return latitude * DEGREE, longitude * DEGREE, height


PLACES = (place(0, 0), place(0, 2000), place(1500, 2000, 50.0), place(2500, 800, 50.0))
TURNS = [90 * DEGREE, np.arctan2(1000, -1200) - 90 * DEGREE]


@pytest.fixture(scope="module")
def states() -> Array:
    way = vehicle(PLACES, SPEED, TURN_RATE)
    return way.states(np.arange(0.0, way.end, 0.37))


def seen(states: Array) -> Array:
    """East, north of the first place [m]."""
    east, north, _ = pymap3d.geodetic2enu(
        states[:, 1], states[:, 2], states[:, 3], LATITUDE, LONGITUDE, 0.0, deg=False
    )
    return np.column_stack((east, north))


def test_the_speed_is_kept(states: Array) -> None:
    np.testing.assert_allclose(np.linalg.norm(states[:, 4:7], axis=1), SPEED, rtol=1e-5)


def test_it_moves_as_its_velocity_says(states: Array) -> None:
    """The way of a step and the mean of the velocities at its ends, which differ by its cube."""
    north, east, _ = pymap3d.geodetic2ned(*states[1:, 1:4].T, *states[:-1, 1:4].T, deg=False)
    mean = (states[1:, 4:6] + states[:-1, 4:6]) / 2 * np.diff(states[:, 0])[:, None]
    np.testing.assert_allclose(np.column_stack((east, north)), mean, atol=2e-3)


def test_it_leads_past_the_places(states: Array) -> None:
    """From the first to the last, and past the others no farther off than the turn there cuts the corner."""
    way = seen(states)
    end = vehicle(PLACES, SPEED, TURN_RATE)
    np.testing.assert_allclose(
        end.states(np.array([0.0, end.end]))[:, 1:4], [PLACES[0], PLACES[-1]], atol=1e-9
    )
    corners = [(0, 2000), (1500, 2000)]
    radius = SPEED / TURN_RATE
    for corner, turn in zip(corners, TURNS, strict=True):
        off = np.linalg.norm(way - corner, axis=1).min()
        sharpest = radius * (1 / np.cos(turn / 2) - 1)  # of an arc at the full rate
        assert sharpest < off < 1.875 * sharpest


def test_between_turns_it_goes_straight(states: Array) -> None:
    way, heading = seen(states), states[:, 9]
    on_first = states[:, 0] < 1500 / SPEED
    assert on_first.sum() > 400
    np.testing.assert_allclose(way[on_first, 0], 0, atol=0.05)
    np.testing.assert_allclose(wrap(heading[on_first]), 0, atol=1e-4)
    on_second = (way[:, 0] > 500) & (way[:, 0] < 1000) & (way[:, 1] > 1500)
    np.testing.assert_allclose(way[on_second, 1], 2000, atol=0.5)
    np.testing.assert_allclose(wrap(heading[on_second]), 90 * DEGREE, atol=1e-3)


def test_turns_are_smooth_and_as_fast_as_said(states: Array) -> None:
    course_rate = -states[:, 15] / np.cos(states[:, 8])
    assert np.abs(course_rate).max() == pytest.approx(TURN_RATE, rel=2e-3)
    assert np.abs(np.diff(course_rate)).max() < 0.37 * 1.1 * 5.8 / 1.875**2 * TURN_RATE**2 / TURNS[1]
    turned = np.unwrap(states[:, 9])
    assert turned[-1] - turned[0] == pytest.approx(sum(TURNS), abs=2e-3)


def test_the_height_changes_between_places(states: Array) -> None:
    np.testing.assert_allclose(states[states[:, 0] < 1800 / SPEED, 3], 0, atol=1e-9)
    np.testing.assert_allclose(states[seen(states)[:, 0] > 1700, 3], 50, atol=1e-6)
    climbing = np.arctan2(states[:, 6], np.hypot(*states[:, 4:6].T))
    np.testing.assert_allclose(states[:, 8], climbing, atol=1e-6)
    np.testing.assert_allclose(states[:, 7], 0, atol=1e-9)
    assert climbing.max() > 1.5 * 50 / 1500


def test_a_long_way_keeps_its_speed() -> None:
    """300 km to the north-east, where degrees of longitude get shorter."""
    far = (0.9, 2.0, 0.0), (0.93, 2.05, 0.0)
    way = vehicle(far, 250.0, TURN_RATE)
    states = way.states(np.linspace(0, way.end, 50))
    np.testing.assert_allclose(np.linalg.norm(states[:, 4:7], axis=1), 250, rtol=1e-6)


@pytest.mark.parametrize(
    ("places", "says"),
    [
        (
            (place(0, 0), place(0, 500), place(20, 0)),
            r"waypoints\.places\[2\]: the course turns by 177.7 deg",
        ),
        (
            (place(0, 0), place(0, 0)),
            r"waypoints\.places\[1\] and \[2\] are 0 m apart: must be more than 0 m",
        ),
        (
            (place(0, 0), place(0, 2000), place(300, 2000), place(300, 0)),
            r"places\[2\] and \[3\] are 300\.1 m apart: .* the 794\.4 m that the turns at them take",
        ),
    ],
)
def test_what_cannot_be_sailed(places: tuple[tuple[float, float, float], ...], says: str) -> None:
    with pytest.raises(InputError, match=says):
        vehicle(places, SPEED, TURN_RATE)
