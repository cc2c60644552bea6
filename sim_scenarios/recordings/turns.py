"""Turns of an IMU against those of the course over ground: of what unit, sign and time they are.

Between two fixes of a vehicle that moves, the course changes by what it turns to the right, which is minus
the angle about the direction of the mean specific force. That holds whatever the axes are called, and leaves
out side slip, which changes little between fixes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from sim_scenarios.attitude import wrap
from sim_scenarios.recordings import forces
from sim_scenarios.recordings.tables import FixTable, ImuTable
from sim_scenarios.units import DEGREE

MOVING: Final = 3.0  # m/s, from which on the course is that of the vehicle
LONGEST: Final = 2.5  # s between two fixes
LEAST_TURN: Final = 30.0 * DEGREE
"""Root of the sum of squared changes of course, below which nothing is concluded."""
LEAST_FIXES: Final = 20
SEARCHED: Final = 20.0  # s; the leap seconds are 18
STEP: Final = 0.1  # s
ELSEWHERE: Final = 5.0  # s
CLEARLY: Final = 0.9
"""Share of the best correlation that another one must not reach elsewhere: turns that repeat tell no lag."""


@dataclass(frozen=True)
class Turns:
    """Changes of course against angles about the vertical."""

    slope: float
    """Course over angle, at `lag`; 1 where all is right."""
    correlation: float
    """At `lag`."""
    lag: float
    """Seconds to add to the stamps of the fixes for the best agreement; 0 where turns repeat."""
    unmoved: float
    """Correlation without a lag."""


def compare(imu: ImuTable, gnss: FixTable) -> Turns | None:
    """Turns of an IMU and of the course; None where a vehicle does not turn, or does not move."""
    speed = np.hypot(gnss.velocity[:, 0], gnss.velocity[:, 1])
    course = np.arctan2(gnss.velocity[:, 0], gnss.velocity[:, 1])
    pair = (
        (speed[:-1] > MOVING)
        & (speed[1:] > MOVING)
        & (np.diff(gnss.time) < LONGEST)
        & (gnss.time[:-1] > imu.time[0] + SEARCHED)
        & (gnss.time[1:] < imu.time[-1] - SEARCHED)
    )
    change = wrap(np.diff(course))[pair]
    if np.count_nonzero(pair) < LEAST_FIXES or np.linalg.norm(change) < LEAST_TURN:
        return None
    begin, end = gnss.time[:-1][pair], gnss.time[1:][pair]
    right = -np.cumsum(np.nan_to_num(imu.delta_angle @ forces.mean_direction(imu)))

    def turned(lag: float) -> tuple[float, float]:
        """Slope and correlation."""
        angle = np.interp(end + lag, imu.time, right) - np.interp(begin + lag, imu.time, right)
        angle -= np.median(angle)
        product, power = float(angle @ change), float(angle @ angle)
        if power == 0:
            return 0.0, 0.0
        return product / power, product / float(np.sqrt(power) * np.linalg.norm(change))

    lags = STEP * np.arange(-round(SEARCHED / STEP), round(SEARCHED / STEP) + 1)
    found = [turned(float(lag)) for lag in lags]
    strength = np.abs([correlation for _, correlation in found])
    best = int(np.argmax(strength))
    elsewhere = np.abs(lags - lags[best]) > ELSEWHERE
    if strength[elsewhere].max(initial=0.0) > CLEARLY * strength[best]:
        best = len(lags) // 2
    return Turns(*found[best], float(lags[best]), found[len(lags) // 2][1])
