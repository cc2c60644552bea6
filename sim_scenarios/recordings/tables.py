"""What a recording holds, in this product's units and axes: an IMU, aids and perhaps a reference.

Every table has its own time stamps [s], increasing, all on one clock. Body axes are right, forward, up;
navigation axes east, north, up. A component that is not a number has not been measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def doubles(values: NDArray[Any]) -> Array:
    """Numbers of any kind as doubles, of the same shape; what is none is the NaN that arithmetic makes.

    Damaged bytes are other ones too, some of which are errors as soon as anything is done with them.
    """
    return np.where(np.isnan(values), np.nan, values).astype(np.float64)


@dataclass(frozen=True)
class ImuTable:
    """Increments over the intervals that end at the stamps."""

    time: Array
    """[s], shape (n,)"""
    delta_angle: Array
    """Integral of the body rate [rad], shape (n, 3)."""
    delta_velocity: Array
    """Integral of the specific force [m/s], shape (n, 3)."""


@dataclass(frozen=True)
class FixTable:
    """Position and velocity of the antenna."""

    time: Array
    """[s], shape (n,)"""
    position: Array
    """Latitude [rad], longitude [rad], height above the ellipsoid [m], shape (n, 3)."""
    velocity: Array
    """[m/s], shape (n, 3)"""
    position_sigma: Array
    """East, north, up [m], shape (n, 3); 0: not told."""
    velocity_sigma: Array
    """East, north, up [m/s], shape (n, 3); 0: not told."""


@dataclass(frozen=True)
class BodyVelocityTable:
    """Velocity in body axes: a log, an odometer."""

    time: Array
    """[s], shape (n,)"""
    velocity: Array
    """[m/s], shape (n, 3)"""
    sigma: Array
    """[m/s], shape (n, 3); 0: not told."""


@dataclass(frozen=True)
class HeadingTable:
    """Heading of the forward axis."""

    time: Array
    """[s], shape (n,)"""
    heading: Array
    """[rad], shape (n,)"""
    sigma: Array
    """[rad], shape (n,); 0: not told."""


@dataclass(frozen=True)
class HeightTable:
    """Height of the IMU above the ellipsoid."""

    time: Array
    """[s], shape (n,)"""
    height: Array
    """[m], shape (n,)"""
    sigma: Array
    """[m], shape (n,); 0: not told."""


@dataclass(frozen=True)
class ReferenceTable:
    """What somebody else's solution says of the IMU; whatever it does not say is not a number."""

    time: Array
    """[s], shape (n,)"""
    attitude: Array
    """Roll, pitch, heading [rad], shape (n, 3)."""
    position: Array
    """Latitude [rad], longitude [rad], height [m], shape (n, 3)."""
    velocity: Array
    """[m/s], shape (n, 3)"""


@dataclass(frozen=True)
class LeverArms:
    """From the IMU to what measures, body axes right, forward, up [m]."""

    gnss: tuple[float, float, float] = (0.0, 0.0, 0.0)
    body_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Recording:
    """Tables of one drive, voyage or flight; all stamps on one clock."""

    name: str
    imu: ImuTable
    gnss: FixTable | None = None
    body_velocity: BodyVelocityTable | None = None
    heading_aid: HeadingTable | None = None
    height_aid: HeightTable | None = None
    reference: ReferenceTable | None = None
    lever_arms: LeverArms = field(default_factory=LeverArms)
    epoch: float | None = None
    """GPS time from which all stamps count [s since 1980-01-06]; None: no table tells the date."""
    remarks: tuple[str, ...] = ()
    """Sentences on what was left out or changed when it was read."""


def finite(values: Array) -> Array:
    """Values of which what is infinite is not a number, as what was not measured."""
    return np.where(np.isfinite(values), values, np.nan)
