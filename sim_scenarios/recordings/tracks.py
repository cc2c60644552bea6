"""Whether positions move as velocities say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from sim_scenarios.attitude import wrap
from sim_scenarios.earth import radii
from sim_scenarios.recordings.tables import Array, FixTable
from sim_scenarios.units import DEGREE

LEAST_WAY: Final = 50.0  # m, below which nothing is concluded
LONGEST: Final = 5.0  # s between two fixes
GOOD: Final = 0.1
"""Share of the squared way that may be left unexplained: a third of the way, in noise and curves."""


@dataclass(frozen=True)
class Explanation:
    """Something that makes positions and velocities go together."""

    sentence: str
    left: float
    """Share of the squared way between fixes that it does not explain."""


SWAPPED: Final = ", or latitudes and longitudes are in each other's place"


def explanations(gnss: FixTable) -> tuple[float, list[Explanation]]:
    """What is left unexplained of the way from fix to fix, and what would explain it, the best first.

    The share is 0 where a track is too short to tell.
    """
    way, said = _steps(gnss)
    if max(np.sum(np.linalg.norm(w[:, :2], axis=1)) for w in (way, said)) < LEAST_WAY:
        return 0.0, []
    unexplained = _left(way[:, :2], said[:, :2])
    slope = float(np.sum(way[:, :2] * said[:, :2]) / max(float(np.sum(said[:, :2] ** 2)), 1e-30))
    swapped = said[:, [1, 0]]
    hypotheses = [
        ("velocities are north, east, down, and must be east, north, up" + SWAPPED, way[:, :2], swapped),
        ("latitudes and longitudes are radians read as degrees", way[:, :2] / DEGREE, said[:, :2]),
        ("latitudes and longitudes are degrees read as radians", way[:, :2] * DEGREE, said[:, :2]),
        ("velocities are km/h read as m/s", way[:, :2], said[:, :2] / 3.6),
        ("velocities are knots read as m/s", way[:, :2], said[:, :2] * (1852 / 3600)),
        ("velocities have the opposite sign", way[:, :2], -said[:, :2]),
        ("time is in ms read as s", way[:, :2], said[:, :2] / 1000),
    ]
    found = [Explanation(sentence, _left(w, s)) for sentence, w, s in hypotheses]
    good = sorted((e for e in found if e.left < GOOD), key=lambda e: e.left)
    if not good and unexplained > GOOD and slope != 0:
        scaled = _left(way[:, :2], slope * said[:, :2])
        if scaled < GOOD:
            good = [Explanation(f"positions move {slope:.3g} times as far as velocities say", scaled)]
    return unexplained, good


def turned_upside_down(gnss: FixTable) -> bool:
    """Whether heights fall where vertical velocities rise."""
    way, said = _steps(gnss)
    up, rising = way[:, 2], said[:, 2]
    if np.sum(np.abs(up)) < LEAST_WAY or np.sum(np.abs(rising)) < LEAST_WAY:
        return False
    return float(up @ rising) < -0.8 * float(np.linalg.norm(up) * np.linalg.norm(rising))


def _steps(gnss: FixTable) -> tuple[Array, Array]:
    """East, north, up from fix to fix [m]: of positions, and of velocities, shape (n, 3) each."""
    latitude, longitude, height = gnss.position.T
    meridian, prime_vertical = radii(latitude)
    step = np.diff(gnss.time)
    way = np.stack(
        [
            wrap(np.diff(longitude)) * (prime_vertical * np.cos(latitude))[:-1],
            np.diff(latitude) * meridian[:-1],
            np.diff(height),
        ],
        axis=-1,
    )
    said = (gnss.velocity[1:] + gnss.velocity[:-1]) / 2 * step[:, None]
    known = (step < LONGEST) & np.isfinite(way[:, :2]).all(axis=1) & np.isfinite(said[:, :2]).all(axis=1)
    return np.nan_to_num(way[known]), np.nan_to_num(said[known])


def _left(way: Array, said: Array) -> float:
    return float(np.sum((way - said) ** 2) / max(float(np.sum(way**2)), 1e-30))
