"""Units that a declaration may use: quantity, SI base unit and the display units people read them in.

A display value is ``factor * value``. Half-integer exponents (noise densities) have no FMI base unit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

STANDARD_GRAVITY = 9.80665
"""Metres per second squared in one g."""


@dataclass(frozen=True)
class Unit:
    """An SI unit: quantity, exponents of its base units (None: not expressible), its limit, display units.

    `most` is the largest size of a parameter that does not declare a limit of its own: beyond what any
    vehicle, sensor or simulation has, and so small that no filter loses its numbers over it.
    """

    quantity: str
    base: dict[str, int] | None
    most: float
    display: dict[str, float] = field(default_factory=dict)


_DEGREE = 180.0 / pi

UNITS: dict[str, Unit] = {
    "1": Unit("Dimensionless", {}, 1e100, {"%": 1e2, "ppm": 1e6}),
    "s": Unit("Time", {"s": 1}, 1e10, {"min": 1 / 60, "h": 1 / 3600}),
    "1/s": Unit("Rate", {"s": -1}, 1e4),
    "Hz": Unit("Frequency", {"s": -1}, 1e4),
    "m": Unit("Length", {"m": 1}, 1e9, {"mm": 1e3, "km": 1e-3, "nmi": 1 / 1852}),
    "m/s": Unit("Velocity", {"m": 1, "s": -1}, 1e5, {"km/h": 3.6, "kn": 3600 / 1852}),
    "m/s2": Unit(
        "Acceleration", {"m": 1, "s": -2}, 1e4, {"mg": 1e3 / STANDARD_GRAVITY, "ug": 1e6 / STANDARD_GRAVITY}
    ),
    "m/s3": Unit("Jerk", {"m": 1, "s": -3}, 1e4),
    "m/s^0.5": Unit("PositionRandomWalk", None, 1e5),
    "m/s^1.5": Unit(
        "VelocityRandomWalk", None, 1e4, {"ug/Hz^0.5": 1e6 / STANDARD_GRAVITY, "m/s/h^0.5": 60.0}
    ),
    "m/s^2.5": Unit("AccelerationRandomWalk", None, 1e4),
    "rad": Unit("Angle", {"rad": 1}, 1e2, {"deg": _DEGREE, "arcmin": 60 * _DEGREE, "arcsec": 3600 * _DEGREE}),
    "rad/s": Unit("AngularVelocity", {"rad": 1, "s": -1}, 1e2, {"deg/s": _DEGREE, "deg/h": 3600 * _DEGREE}),
    "rad/s2": Unit("AngularAcceleration", {"rad": 1, "s": -2}, 1e4, {"deg/s2": _DEGREE}),
    "rad/s^0.5": Unit(
        "AngleRandomWalk",
        None,
        1e2,
        {"deg/h^0.5": 60 * _DEGREE, "deg/s/Hz^0.5": _DEGREE, "deg/h/Hz^0.5": 3600 * _DEGREE},
    ),
    "rad/s^1.5": Unit("RateRandomWalk", None, 1e2),
}
