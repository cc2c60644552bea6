"""Which way of an IMU is ahead: that in which the specific force grows as the vehicle gains speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from sim_scenarios.recordings import forces
from sim_scenarios.recordings.tables import Array, FixTable, ImuTable

APART: Final = 1.0  # s between speeds
MOVING: Final = 1.0  # m/s; what stands has no way ahead
LEAST_STEPS: Final = 20
LEAST_CHANGE: Final = 0.2  # m/s in a second, root mean square
SURE: Final = 0.6


@dataclass(frozen=True)
class Ahead:
    """Direction ahead."""

    direction: Array
    """In the axes of the IMU, at right angles to the mean specific force, shape (3,)."""
    correlation: float
    """Of speeds gained with delta velocities in that direction."""


def find(imu: ImuTable, gnss: FixTable) -> Ahead | None:
    """Direction ahead; None where the speed does not change enough, or nothing goes with it."""
    if len(gnss.time) < LEAST_STEPS:
        return None
    rows = slice(None, None, max(round(APART / float(np.median(np.diff(gnss.time)))), 1))
    time = gnss.time[rows]
    speed = np.hypot(gnss.velocity[rows, 0], gnss.velocity[rows, 1])
    pair = (
        (speed[:-1] > MOVING)
        & (speed[1:] > MOVING)
        & (np.diff(time) < 2 * APART)
        & (time[:-1] >= imu.time[0])
        & (time[1:] <= imu.time[-1])
    )
    gained = np.diff(speed)[pair] / np.diff(time)[pair]
    if len(gained) < LEAST_STEPS or np.sqrt(np.mean(gained**2)) < LEAST_CHANGE:
        return None
    velocity = np.cumsum(np.nan_to_num(imu.delta_velocity), axis=0)
    at_fix = np.stack([np.interp(time, imu.time, v) for v in velocity.T], axis=-1)
    felt = np.diff(at_fix, axis=0)[pair] / np.diff(time)[pair, None]
    up = forces.mean_direction(imu)
    level = np.linalg.svd(up[None, :])[2][1:]  # two directions at right angles to it
    regressors = np.column_stack([felt @ level.T, np.ones(len(felt))])
    weights = np.linalg.lstsq(regressors, gained, rcond=None)[0]
    correlation = float(np.corrcoef(regressors @ weights, gained)[0, 1])
    if correlation < SURE:
        return None
    direction = weights[:2] @ level
    return Ahead(direction / np.linalg.norm(direction), correlation)
