"""Units in which people write and read, in SI: 10 * DEGREE is in rad, x / ARCMIN in minutes of arc."""

from math import pi
from typing import Final

DEGREE: Final = pi / 180  # rad
ARCMIN: Final = DEGREE / 60  # rad
HOUR: Final = 3600.0  # s
STANDARD_GRAVITY: Final = 9.80665  # m/s2
