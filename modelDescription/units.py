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
    """An SI unit: quantity, exponents of its base units (None: not expressible), display units."""

    quantity: str
    base: dict[str, int] | None
    display: dict[str, float] = field(default_factory=dict)


_DEGREE = 180.0 / pi

UNITS: dict[str, Unit] = {
    "1": Unit("Dimensionless", {}, {"%": 1e2, "ppm": 1e6}),
    "s": Unit("Time", {"s": 1}, {"min": 1 / 60, "h": 1 / 3600}),
    "1/s": Unit("Rate", {"s": -1}),
    "Hz": Unit("Frequency", {"s": -1}),
    "m": Unit("Length", {"m": 1}, {"mm": 1e3, "km": 1e-3, "nmi": 1 / 1852}),
    "m/s": Unit("Velocity", {"m": 1, "s": -1}, {"km/h": 3.6, "kn": 3600 / 1852}),
    "m/s2": Unit(
        "Acceleration", {"m": 1, "s": -2}, {"mg": 1e3 / STANDARD_GRAVITY, "ug": 1e6 / STANDARD_GRAVITY}
    ),
    "m/s3": Unit("Jerk", {"m": 1, "s": -3}),
    "m/s^0.5": Unit("PositionRandomWalk", None),
    "m/s^1.5": Unit("VelocityRandomWalk", None, {"ug/Hz^0.5": 1e6 / STANDARD_GRAVITY, "m/s/h^0.5": 60.0}),
    "m/s^2.5": Unit("AccelerationRandomWalk", None),
    "rad": Unit("Angle", {"rad": 1}, {"deg": _DEGREE, "arcmin": 60 * _DEGREE, "arcsec": 3600 * _DEGREE}),
    "rad/s": Unit("AngularVelocity", {"rad": 1, "s": -1}, {"deg/s": _DEGREE, "deg/h": 3600 * _DEGREE}),
    "rad/s2": Unit("AngularAcceleration", {"rad": 1, "s": -2}, {"deg/s2": _DEGREE}),
    "rad/s^0.5": Unit(
        "AngleRandomWalk",
        None,
        {"deg/h^0.5": 60 * _DEGREE, "deg/s/Hz^0.5": _DEGREE, "deg/h/Hz^0.5": 3600 * _DEGREE},
    ),
    "rad/s^1.5": Unit("RateRandomWalk", None),
}
