"""Units in which people write and read, in SI: 10 * DEGREE is in rad, x / ARCMIN in minutes of arc."""

from dataclasses import dataclass
from math import pi
from typing import Final

DEGREE: Final = pi / 180  # rad
ARCMIN: Final = DEGREE / 60  # rad
HOUR: Final = 3600.0  # s
STANDARD_GRAVITY: Final = 9.80665  # m/s2


@dataclass(frozen=True)
class Reading:
    """A unit in which people read: its name, its sign where there is little room, and its size in SI."""

    name: str
    sign: str
    size: float


def reading(unit: str) -> Reading:
    """In which unit people read the errors that are in a unit of SI."""
    return {"rad": Reading("arcmin", "'", ARCMIN), "1": Reading("", "", 1.0)}.get(
        unit, Reading(unit, unit, 1.0)
    )
