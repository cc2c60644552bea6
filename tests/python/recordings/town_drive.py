"""A drive on a plane in closed form: what an IMU and a receiver of a car measure, without noise.

Heading psi(t) = sum of a / 2 tanh((t - t_corner) / 2), clockwise from north; speed v(t) = 12 + 5 sin(t / 7).
So the body turns at -psi' about up, and feels v' ahead, v psi' to the right and gravity upwards.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim_scenarios.earth import radii
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

G = 9.80665
CORNERS = (
    (9, 1.5),
    (21, -1.2),
    (33, 1.6),
    (38, 1.4),
    (57, -1.5),
    (81, 1.5),
    (90, -0.8),
    (104, -1.6),
    (127, 1.2),
)
"""When [s], and by how much the drive turns to the right [rad]."""
SITE = (48.0 * DEGREE, 11.0 * DEGREE, 500.0)


@dataclass(frozen=True)
class TownDrive:
    """Rates at an instant, increments over a step, position and velocity."""

    climb: float = 1.0
    """Of the vertical velocity [m/s]."""

    def heading(self, t: Array) -> Array:
        return sum(angle / 2 * np.tanh((t - at) / 2) for at, angle in CORNERS)

    def turn(self, t: Array) -> Array:
        """Rate of the heading [rad/s]."""
        return sum(angle / 4 / np.cosh((t - at) / 2) ** 2 for at, angle in CORNERS)

    def speed(self, t: Array) -> Array:
        return 12 + 5 * np.sin(t / 7)

    def rate(self, t: Array) -> Array:
        """Body rate, right, forward, up [rad/s]."""
        zero = np.zeros_like(t)
        return np.stack([zero, zero, -self.turn(t)], axis=-1)

    def force(self, t: Array) -> Array:
        """Specific force, right, forward, up [m/s2]."""
        up = G - self.climb / 11 * np.sin(t / 11)
        return np.stack([self.speed(t) * self.turn(t), 5 / 7 * np.cos(t / 7), up], axis=-1)

    def imu(self, time: Array) -> ImuTable:
        """Increments over the steps that end at the stamps, by the rates in their middle."""
        steps = np.diff(time, prepend=2 * time[0] - time[1])
        middle = time - steps / 2
        return ImuTable(time, self.rate(middle) * steps[:, None], self.force(middle) * steps[:, None])

    def fixes(self, time: Array) -> FixTable:
        fine = np.arange(0.0, time[-1] + 0.01, 0.005)
        velocity = self.velocity(fine)
        way = np.concatenate(([np.zeros(3)], np.cumsum((velocity[1:] + velocity[:-1]) / 2 * 0.005, axis=0)))
        east, north, up = (np.interp(time, fine, part) for part in way.T)
        meridian, prime_vertical = radii(SITE[0])
        position = np.stack(
            [
                SITE[0] + north / meridian,
                SITE[1] + east / (prime_vertical * np.cos(SITE[0])),
                SITE[2] + up,
            ],
            axis=-1,
        )
        return FixTable(
            time, position, self.velocity(time), np.zeros((len(time), 3)), np.zeros((len(time), 3))
        )

    def velocity(self, t: Array) -> Array:
        """East, north, up [m/s]."""
        level = [self.speed(t) * np.sin(self.heading(t)), self.speed(t) * np.cos(self.heading(t))]
        return np.stack([*level, self.climb * np.cos(t / 11)], axis=-1)

    def recording(self, seconds: float = 150.0) -> Recording:
        return Recording(
            "town",
            self.imu(0.01 * np.arange(1, round(100 * seconds) + 1)),
            self.fixes(0.5 * np.arange(1, round(2 * seconds) + 1)),
        )


def imu_cells(imu: ImuTable) -> pd.DataFrame:
    """IMU in the columns of the plain form."""
    names = [f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz"]
    cells = pd.DataFrame(np.hstack([imu.delta_angle, imu.delta_velocity]), columns=names)
    cells.insert(0, "time", imu.time)
    return cells


def fix_cells(fixes: FixTable) -> pd.DataFrame:
    """Fixes with angles in degrees."""
    cells = pd.DataFrame(
        np.hstack([fixes.position / [DEGREE, DEGREE, 1.0], fixes.velocity]),
        columns=["lat", "lon", "height", "ve", "vn", "vu"],
    )
    cells.insert(0, "time", fixes.time)
    return cells
