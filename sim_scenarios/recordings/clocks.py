"""One clock for tables whose stamps count from different beginnings.

The common clock counts seconds from midnight, GPS time, of the day on which the IMU begins, where the date is
known; seconds of a day or a week count as in the file where it is not. Stamps of a clock that nobody names
stay as they are, and go together with their like alone.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import contents
from sim_scenarios.recordings.tables import Array

DAY: Final = 86400.0
WEEK: Final = 7 * DAY
GPS_BEGINS: Final = 315964800.0
"""1980-01-06 on the clock of Unix [s]."""

_LEAPS: Final = tuple(
    float(np.datetime64(day, "s").astype(np.int64))
    for day in (
        *("1981-07-01", "1982-07-01", "1983-07-01", "1985-07-01", "1988-01-01", "1990-01-01", "1991-01-01"),
        *("1992-07-01", "1993-07-01", "1994-07-01", "1996-01-01", "1997-07-01", "1999-01-01", "2006-01-01"),
        *("2009-01-01", "2012-07-01", "2015-07-01", "2017-01-01"),
    )
)
"""From when on GPS time is a second more ahead of UTC [s, Unix]."""


class Clock(Enum):
    """From when stamps count, as a description may say it."""

    GPS = "gps"
    UNIX = "unix"
    GPS_WEEK = "gps-week"
    GPS_DAY = "gps-day"
    UTC_DAY = "utc-day"
    OWN = "own"

    @property
    def dated(self) -> bool:
        """Whether a stamp says the date."""
        return self in (Clock.GPS, Clock.UNIX)

    @property
    def repeats(self) -> float:
        """After how many seconds a stamp comes again; 0: never."""
        return {Clock.GPS_WEEK: WEEK, Clock.GPS_DAY: DAY, Clock.UTC_DAY: DAY}.get(self, 0.0)


CLOCK_OF_READER: Final = {
    contents.Clock.GPS: Clock.GPS,
    contents.Clock.UNIX: Clock.UNIX,
    contents.Clock.OWN: Clock.OWN,
}


@dataclass(frozen=True)
class Stamps:
    """Stamps of a table."""

    where: str
    """File, or file and table."""
    clock: Clock
    epoch: float
    """Stamps count from so many seconds after the clock's beginning."""
    time: Array
    """[s], shape (n,)"""
    offset: float = 0.0
    """Seconds to add."""


def leap_seconds(unix: float) -> int:
    """How far GPS time is ahead of UTC at an instant [s, Unix]."""
    return bisect_right(_LEAPS, unix)


def unwrapped(time: Array, clock: Clock) -> Array:
    """Stamps that go on where those of the day or the week begin again."""
    if not clock.repeats:
        return time
    return time + clock.repeats * np.cumsum(np.diff(time, prepend=time[:1]) < -clock.repeats / 2)


def on_one_clock(tables: Sequence[Stamps]) -> list[Array]:
    """Stamps of tables on one clock, the first being that of the IMU.

    Raises
    ------
    InputError
        If a table counts from something unknown and another does not, or a table does not overlap the first.
    """
    _check_named(tables)
    ahead = next((_leap_seconds(table) for table in tables if table.clock.dated), len(_LEAPS))
    tables = [_in_gps_time(table, ahead) for table in tables]
    dated = [table for table in tables if table.clock.dated]
    if dated:
        tables = [_placed(table, dated[0]) for table in tables]
        day = np.floor((tables[0].epoch + tables[0].time[0]) / DAY) * DAY
        tables = [replace(table, epoch=table.epoch - day) for table in tables]
    else:
        longest = max(tables, key=lambda table: table.clock.repeats)
        tables = [_placed(table, longest) for table in tables]
    times = [table.time + table.epoch for table in tables]
    for table, time in zip(tables[1:], times[1:], strict=True):
        _check_overlap(tables[0].where, times[0], table.where, time)
    return times


def _check_named(tables: Sequence[Stamps]) -> None:
    unnamed = [table for table in tables if table.clock is Clock.OWN]
    named = [table for table in tables if table.clock is not Clock.OWN]
    if unnamed and named:
        one, other = unnamed[0], named[0]
        raise InputError(
            f"{one.where}: its stamps ({_span(one.epoch + one.time)}) count from something that the file "
            f"does not say, and those of {other.where} are {other.clock.value} seconds: say "
            "clock = 'gps', 'unix', 'gps-week', 'gps-day' or 'utc-day' of it"
        )


def _leap_seconds(table: Stamps) -> int:
    """How far GPS time is ahead of UTC at the first stamp of a clock that says the date."""
    first = table.epoch + float(table.time[0])
    return leap_seconds(first if table.clock is Clock.UNIX else first + GPS_BEGINS)


def _in_gps_time(table: Stamps, ahead: int) -> Stamps:
    """Stamps that count GPS time, unless they are of an unknown clock, with their offset.

    Of a clock without a date UTC is as far behind as beside a clock with one; without any, as since 2017.
    """
    table = replace(table, time=table.time + table.offset, offset=0.0)
    if table.clock is Clock.UNIX:
        return replace(table, clock=Clock.GPS, epoch=table.epoch - GPS_BEGINS + _leap_seconds(table))
    if table.clock is Clock.UTC_DAY:
        return replace(table, clock=Clock.GPS_DAY, epoch=table.epoch + ahead)
    return table


def _placed(table: Stamps, beside: Stamps) -> Stamps:
    """Stamps of a day or a week in that one which is nearest to those of another table."""
    if not table.clock.repeats:
        return table
    middle, other = (t.epoch + (t.time[0] + t.time[-1]) / 2 for t in (table, beside))
    periods = float(np.round((other - middle) / table.clock.repeats))
    return replace(table, epoch=table.epoch + periods * table.clock.repeats)


def _check_overlap(where: str, time: Array, other: str, others: Array) -> None:
    if _overlap(time, others):
        return
    raise InputError(
        f"{where} ({_span(time)}) and {other} ({_span(others)}) do not overlap on one clock"
        f"{_joined(time, others)}"
    )


_MISTAKES: Final = (
    (float(len(_LEAPS)), 1, "s, which are the leap seconds"),
    (3600.0, 14, "h"),
    (WEEK, 10_000, "weeks"),
    (DAY, 10_000, "days"),
)
"""By what clocks are apart when one is taken for another: seconds, how often at most, and their name."""


def _joined(time: Array, others: Array) -> str:
    """By which mistake two spans would be apart."""
    apart = float(np.mean(time[[0, -1]]) - np.mean(others[[0, -1]]))
    for unit, most, name in _MISTAKES:
        count = int(np.clip(round(apart / unit), -most, most))
        if count and _overlap(time, others + count * unit):
            number = len(_LEAPS) if most == 1 else abs(count)
            return f"; the latter would with offset = {count * unit:.10g}, that is {number} {name}"
    return ""


def _overlap(time: Array, others: Array) -> bool:
    return bool(time[0] <= others[-1] and others[0] <= time[-1])


def _span(time: Array) -> str:
    return f"{time[0]:.10g} to {time[-1]:.10g} s"
