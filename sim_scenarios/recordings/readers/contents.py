"""What a reader finds in a file: tables in SI units, on the file's own clock and in the IMU's own axes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from sim_scenarios.recordings.readers.gps_time import DAY, WEEK
from sim_scenarios.recordings.tables import (
    Array,
    BodyVelocityTable,
    FixTable,
    HeadingTable,
    HeightTable,
    ReferenceTable,
)


class Clock(Enum):
    """From when stamps count, as a file or its description says it."""

    GPS = "gps"
    """Seconds since 1980-01-06, without leap seconds."""
    UNIX = "unix"
    """Seconds since 1970-01-01, UTC."""
    GPS_WEEK = "gps-week"
    GPS_DAY = "gps-day"
    UTC_DAY = "utc-day"
    OWN = "own"
    """Seconds since something that the file does not say, or of a day or week that it does not name."""

    @property
    def dated(self) -> bool:
        """Whether a stamp says the date."""
        return self in (Clock.GPS, Clock.UNIX)

    @property
    def repeats(self) -> float:
        """After how many seconds a stamp comes again; 0: never."""
        return {Clock.GPS_WEEK: WEEK, Clock.GPS_DAY: DAY, Clock.UTC_DAY: DAY}.get(self, 0.0)


class Axes(Enum):
    """Which way the first, second and third axis point."""

    RIGHT_FORWARD_UP = "right-forward-up"
    FORWARD_RIGHT_DOWN = "forward-right-down"
    FORWARD_LEFT_UP = "forward-left-up"


@dataclass(frozen=True)
class Inertial:
    """IMU as it was recorded: increments over the interval that ends at the stamp, or rates."""

    time: Array
    """[s], shape (n,)"""
    angular: Array
    """Delta angle [rad] or body rate [rad/s], shape (n, 3)."""
    force: Array
    """Delta velocity [m/s] or specific force [m/s2], shape (n, 3)."""
    increments: bool
    axes: Axes | None = None
    """Where the format fixes them."""


def _row(table: str, row: int) -> str:
    return f"row {row + 1} of its {table} table"


@dataclass(frozen=True)
class Contents:
    """Tables of one file."""

    clock: Clock = Clock.OWN
    epoch: float = 0.0
    """Stamps count from so many seconds after the clock's beginning: days or weeks, so that none rounds."""
    imu: Inertial | None = None
    """Forces that stand in a file of their own are not a number here."""
    accelerometer: Inertial | None = None
    """Such forces; angles are not a number."""
    gnss: FixTable | None = None
    body_velocity: BodyVelocityTable | None = None
    heading_aid: HeadingTable | None = None
    height_aid: HeightTable | None = None
    reference: ReferenceTable | None = None
    place: Callable[[str, int], str] = _row
    """Where a row of a table stands in the file, by the table's name (`imu`, `gnss` ...) and its index."""
    remarks: tuple[str, ...] = ()
    """Sentences on what was left out."""
