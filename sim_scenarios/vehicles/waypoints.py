"""A way past places: straight on from one to the next at one speed, with rounded turns where it bends.

Along a turn the course changes by angle x^3 (10 - 15 x + 6 x^2), as that of the plant's ship does, so slowly
that its rate nowhere exceeds `turn_rate`; the turn cuts the corner and ends on the way to the next place.
Between places the height changes by the same polynomial of the way. The vehicle points where it goes, and
does not roll. The way begins at the first place and ends at the last.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from sim_scenarios.attitude import wrap
from sim_scenarios.earth import displaced, displacement
from sim_scenarios.errors import InputError
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles.motion import HIGHEST_LATITUDE, Points, Vehicle

Array = NDArray[np.float64]

SPACING: Final = 0.2
"""Between two points that are calculated [s]."""
SHARPEST: Final = 150 * DEGREE
PEAK: Final = 1.875
"""Largest slope of the polynomial."""
PARTS: Final = 1000
"""Of a turn, to integrate it."""


@lru_cache(maxsize=4)
def vehicle(places: tuple[tuple[float, float, float], ...], speed: float, turn_rate: float) -> Vehicle:
    """Vehicle that goes past places.

    Parameters
    ----------
    places : tuple of (float, float, float)
        Latitude [rad], longitude [rad], height [m]; two or more.
    speed : float
        [m/s]
    turn_rate : float
        Largest rate of the course [rad/s].

    Raises
    ------
    InputError
        A turn is too sharp, or two places are too near for the turns at them.
    """
    located = np.array(places)
    _check_latitudes(located[:, 0])
    origin = located[0] * [1.0, 1.0, 0.0]
    corners = displacement(located, np.broadcast_to(origin, located.shape))[:, :2]
    legs = np.diff(corners, axis=0)
    lengths, courses = np.hypot(*legs.T), np.arctan2(*legs.T)
    turns = wrap(np.diff(courses))
    turning = PEAK * np.abs(turns) * speed / turn_rate  # m
    _check_turns(turns)
    cuts = np.concatenate(([0.0], turning * [_cut(turn) for turn in turns], [0.0]))
    straight = lengths - cuts[:-1] - cuts[1:]
    _check_legs(lengths, straight)

    begins = np.cumsum(straight[:-1]) + np.concatenate(([0.0], np.cumsum(turning)[:-1]))[: len(turns)]
    whole = float(np.sum(straight) + np.sum(turning))
    along = np.linspace(0.0, whole, max(round(whole / (speed * SPACING)), 2) + 1)
    course = np.full(len(along), courses[0])
    for turn, begin, length in zip(turns, begins, turning, strict=True):
        if length > 0:
            course += turn * _gradual((along - begin) / length)
    heading = np.column_stack((np.sin(course), np.cos(course)))
    way = CubicSpline(along, heading).antiderivative()(along)
    abeam = np.concatenate(([0.0], begins + turning / 2, [whole]))
    height = np.full(len(along), located[0, 2])
    for climb, begin, end in zip(np.diff(located[:, 2]), abeam[:-1], abeam[1:], strict=True):
        height += climb * _gradual((along - begin) / (end - begin))
    position = displaced(
        np.broadcast_to(origin, (len(along), 3)), np.column_stack((way, np.zeros(len(along))))
    )
    position[:, 2] = height
    middle = (position[1:] + position[:-1]) / 2
    step = np.linalg.norm(displacement(position[1:], middle) - displacement(position[:-1], middle), axis=1)
    return Vehicle(Points(np.concatenate(([0.0], np.cumsum(step))) / speed, position))


def _gradual(x: Array) -> Array:
    """From 0 to 1, without leap in slope and curvature."""
    x = np.clip(x, 0.0, 1.0)
    gone: Array = x**3 * (10 - 15 * x + 6 * x**2)
    return gone


def _cut(turn: float) -> float:
    """How far from the corner a turn begins and ends, of the way along it."""
    x = (np.arange(PARTS) + 0.5) / PARTS
    course = turn * _gradual(x)
    return float(np.hypot(np.mean(np.sin(course)), np.mean(np.cos(course))) / (2 * np.cos(turn / 2)))


def _check_latitudes(latitudes: Array) -> None:
    if len(polar := np.flatnonzero(np.abs(latitudes) > HIGHEST_LATITUDE)):
        at = int(polar[0])
        raise InputError(
            f"waypoints.places[{at + 1}]: latitude = {latitudes[at] / DEGREE:g} deg: must be at most "
            f"{HIGHEST_LATITUDE / DEGREE:.2f} either way"
        )


def _check_turns(turns: Array) -> None:
    if len(sharp := np.flatnonzero(np.abs(turns) > SHARPEST)):
        at = int(sharp[0])
        raise InputError(
            f"waypoints.places[{at + 2}]: the course turns by {abs(turns[at]) / DEGREE:.4g} deg there: must "
            f"be at most {SHARPEST / DEGREE:g} deg"
        )


def _check_legs(lengths: Array, straight: Array) -> None:
    if len(short := np.flatnonzero((straight < 0) | (lengths == 0))):
        at = int(short[0])
        raise InputError(
            f"waypoints.places[{at + 1}] and [{at + 2}] are {lengths[at]:.4g} m apart: must be more than 0 m "
            f"and at least the {lengths[at] - straight[at]:.4g} m that the turns at them take; go slower or "
            "with a greater turn_rate"
        )
