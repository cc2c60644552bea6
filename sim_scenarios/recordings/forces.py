"""What the specific force tells of an IMU: on Earth it is about 9.8 m/s2 and points up, over a while.

Its direction changes in body axes as the body turns about anything but the vertical, so that it also tells
the unit of the angles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.tables import Array, ImuTable
from sim_scenarios.units import DEGREE, STANDARD_GRAVITY

BLOCK: Final = 1.0  # s over which vibration is gone and a vehicle hardly tilts
DOWN: Final = -0.7
"""Least upward share of the mean force: an upside-down IMU has -1."""
UP: Final = 0.5
LEAST_TILT: Final = 2.0 * DEGREE
"""Between blocks, from which on angles are compared with the turns of the force."""


@dataclass(frozen=True)
class Tilts:
    """Turns of the specific force in body axes against those that the angles say."""

    slope: float
    """By which the angles must be multiplied."""
    correlation: float
    angles: float
    """Root mean square of what the angles say [rad]."""


def of_unit(imu: ImuTable) -> str:
    """What is wrong with the size of the increments; empty if nothing is."""
    size = np.linalg.norm(imu.delta_velocity, axis=1)
    known = np.isfinite(size)
    if not known.any():
        return "no sample has a delta velocity"
    mean, period = float(size[known].mean()), stamps.period(imu.time)
    low, high = STANDARD_GRAVITY / 2, STANDARD_GRAVITY * 2
    force = mean / period
    if low < force < high:
        return ""
    if low < mean < high:
        return (
            f"the file seems to hold rates, not increments: |delta_velocity| is {mean:.3g} in the mean, "
            'which is a specific force in m/s2; a description says so by units such as "rad/s" and "m/s2"'
        )
    for factor, unit in ((1e3, "ms"), (1e6, "us"), (1e9, "ns")):
        if low < force * factor < high:
            return (
                f"time seems to be in {unit}: |delta_velocity| / dt is {force:.3g} m/s2 with steps of "
                f"{period:g} s"
            )
    if low < force * STANDARD_GRAVITY < high:
        return f"delta velocities seem to be in g*s: |delta_velocity| / dt is {force:.3g} in the mean"
    return (
        f"|delta_velocity| / dt is {force:.3g} m/s2 in the mean, but an IMU on Earth feels about 9.8 m/s2; "
        f"delta_velocity must be an increment in m/s over {period:g} s"
    )


def mean_direction(imu: ImuTable) -> Array:
    """Direction of the mean specific force, right, forward, up, shape (3,)."""
    mean: Array = np.nanmean(imu.delta_velocity, axis=0)
    direction: Array = mean / np.linalg.norm(mean)
    return direction


def tilts(imu: ImuTable) -> Tilts:
    """Turns of the force against the angles, of blocks of a second.

    With u the direction of the force, u' = u x w where a body turns at w and does not accelerate; constant
    parts of w, as a gyro's bias, do not count.
    """
    rows = max(round(BLOCK / stamps.period(imu.time)), 1)
    count = len(imu.time) // rows
    if count < 3:
        return Tilts(1.0, 0.0, 0.0)
    blocks = slice(0, rows * count)
    force = np.nan_to_num(imu.delta_velocity[blocks]).reshape(count, rows, 3).sum(axis=1)
    angle = np.nan_to_num(imu.delta_angle[blocks]).reshape(count, rows, 3).sum(axis=1)
    angle -= np.median(angle, axis=0)
    size = np.linalg.norm(force, axis=1, keepdims=True)
    u = force / np.where(size > 0, size, 1.0)
    seen = np.diff(u, axis=0)
    said = np.cross((u[1:] + u[:-1]) / 2, (angle[1:] + angle[:-1]) / 2)
    product, power = float(np.sum(seen * said)), float(np.sum(said**2))
    both = np.sqrt(power * float(np.sum(seen**2)))
    if both == 0:
        return Tilts(1.0, 0.0, 0.0)
    return Tilts(product / power, product / both, float(np.sqrt(power / len(said))))
