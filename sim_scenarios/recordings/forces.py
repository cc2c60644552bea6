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
    mean, period = mean_size(imu.delta_velocity, imu.time), stamps.period(imu.time)
    if np.isnan(mean):
        return "no sample has a delta velocity"
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


def mean_size(force: Array, time: Array) -> float:
    """Mean size of a force that vibrates: of its means over a second, shape (n, 3); nan if none is known."""
    blocks = _blocks(force, time)
    known = np.isfinite(blocks.sum(axis=2))
    count = known.sum(axis=1)
    total = np.where(known[:, :, None], blocks, 0.0).sum(axis=1)[count > 0]
    sizes = np.linalg.norm(total / count[count > 0, None], axis=1)
    return float(sizes.mean()) if len(sizes) else np.nan


def _blocks(values: Array, time: Array) -> Array:
    """Vectors by whole seconds, shape (count, rows, 3); of less than a second all."""
    rows = min(max(round(BLOCK / stamps.period(time)), 1), len(time))
    count = len(time) // rows
    return values[: rows * count].reshape(count, rows, 3)


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
    force, angle = (
        _blocks(np.nan_to_num(values), imu.time).sum(axis=1)
        for values in (imu.delta_velocity, imu.delta_angle)
    )
    if len(force) < 3:
        return Tilts(1.0, 0.0, 0.0)
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
