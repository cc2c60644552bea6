"""One clock for tables whose stamps count from different beginnings.

The common clock counts seconds from midnight, GPS time, of the day on which the IMU begins, where the date is
known; seconds of a day or a week count as in the file where it is not. Stamps of a clock that nobody names
stay as they are, and go together with their like alone.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.recordings.readers.gps_time import DAY, SINCE_1970, WEEK
from sim_scenarios.recordings.tables import Array

_LEAPS: Final = tuple(
    float(np.datetime64(day, "s").astype(np.int64))
    for day in (
        *("1981-07-01", "1982-07-01", "1983-07-01", "1985-07-01", "1988-01-01", "1990-01-01", "1991-01-01"),
        *("1992-07-01", "1993-07-01", "1994-07-01", "1996-01-01", "1997-07-01", "1999-01-01", "2006-01-01"),
        *("2009-01-01", "2012-07-01", "2015-07-01", "2017-01-01"),
    )
)
"""From when on GPS time is a second more ahead of UTC [s, Unix]."""


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


def begins(epoch: float, known: Clock, said: Clock) -> float:
    """Epoch on a clock that is said, of stamps that a file counts on another one.

    What a file dates keeps its date: dates that are said to be GPS time are counted since 1980.
    """
    since = {Clock.GPS: SINCE_1970, Clock.UNIX: 0.0}
    return epoch + since[known] - since[said] if known.dated and said.dated else epoch


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
    tables, begin = _beside_one_another(tables)
    times = [table.time + (table.epoch - (begin or 0.0)) for table in tables]
    for table, time in zip(tables[1:], times[1:], strict=True):
        _check_overlap(tables[0].where, times[0], table.where, time)
    return times


def common_epoch(tables: Sequence[Stamps]) -> float | None:
    """GPS time from which stamps on the one clock of tables count [s]; None: no table tells the date."""
    return _beside_one_another(tables)[1]


def _beside_one_another(tables: Sequence[Stamps]) -> tuple[list[Stamps], float | None]:
    """Tables in GPS time, and the midnight before the first where there is a date."""
    _check_named(tables)
    ahead = next((_leap_seconds(table) for table in tables if table.clock.dated), len(_LEAPS))
    tables = [_in_gps_time(table, ahead) for table in tables]
    dated = [table for table in tables if table.clock.dated]
    if dated:
        tables = [_placed(table, dated[0]) for table in tables]
        return tables, float(np.floor((tables[0].epoch + tables[0].time[0]) / DAY) * DAY)
    longest = max(tables, key=lambda table: table.clock.repeats)
    return [_placed(table, longest) for table in tables], None


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
    return leap_seconds(first if table.clock is Clock.UNIX else first + SINCE_1970)


def _in_gps_time(table: Stamps, ahead: int) -> Stamps:
    """Stamps that count GPS time, unless they are of an unknown clock, with their offset.

    Of a clock without a date UTC is as far behind as beside a clock with one; without any, as since 2017.
    """
    table = replace(table, time=table.time + table.offset, offset=0.0)
    if table.clock is Clock.UNIX:
        return replace(table, clock=Clock.GPS, epoch=table.epoch - SINCE_1970 + _leap_seconds(table))
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
