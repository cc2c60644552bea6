"""Units in which loggers write: what one of them is in SI.

A unit may have a factor in front ("0.061 mg" of a count of that size, "-1 m/s").
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from sim_scenarios.errors import InputError
from sim_scenarios.units import ARCMIN, DEGREE, HOUR, STANDARD_GRAVITY

Units = Mapping[str, float]

ANGLE: Final = {"rad": 1.0, "mrad": 1e-3, "deg": DEGREE, "arcmin": ARCMIN, "arcsec": ARCMIN / 60}
ANGULAR_RATE: Final = {
    "rad/s": 1.0,
    "mrad/s": 1e-3,
    "deg/s": DEGREE,
    "deg/h": DEGREE / HOUR,
}
SPECIFIC_FORCE: Final = {"m/s2": 1.0, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY, "ft/s2": 0.3048}
VELOCITY: Final = {
    "m/s": 1.0,
    "mm/s": 1e-3,
    "cm/s": 1e-2,
    "km/h": 1 / 3.6,
    "knot": 1852 / HOUR,
    "ft/s": 0.3048,
}
DELTA_VELOCITY: Final = {**VELOCITY, "g*s": STANDARD_GRAVITY, "mg*s": 1e-3 * STANDARD_GRAVITY}
LENGTH: Final = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048}
TIME: Final = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": HOUR}

_QUANTITY: Final = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)?\s*(\S*)\s*")


def measures(text: str, units: Units) -> bool:
    """Whether a quantity is in one of the units."""
    found = _QUANTITY.fullmatch(text)
    return found is not None and found[2] in units


def si(text: str, units: Units) -> float:
    """A quantity such as "deg/s" or "0.061 mg" in SI.

    Raises
    ------
    InputError
        If the unit is none of `units`.
    """
    found = _QUANTITY.fullmatch(text)
    if found is None or found[2] not in units:
        raise InputError(f"'{text}' is not in a unit of this quantity: {', '.join(units)}")
    value = float(found[1] or 1) * units[found[2]]
    if not math.isfinite(value) or value == 0:
        raise InputError(f"'{text}': must be finite and not 0")
    return value
