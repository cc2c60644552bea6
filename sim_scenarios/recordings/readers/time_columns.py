"""Time columns of a text file: seconds, parts of seconds, dates, times of day.

Whole seconds since a clock's beginning are kept apart where they are many, so that stamps since 1970 are read
to the nanosecond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import units as of
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.recordings.readers.sheets import Sheet
from sim_scenarios.recordings.tables import Array

ISO: Final = "iso"
"""Stamps such as 2025-01-01T19:34:18.499, in one column or two."""
TIME_OF_DAY: Final = "h:m:s"
"""Stamps such as 19:34:18.499."""

_EXAMPLES: Final = {ISO: "2025-01-01T19:34:18.499", TIME_OF_DAY: "19:34:18.499"}
_MANY: Final = 1e6
"""Seconds from which a float64 holds less than a tenth of a nanosecond."""


@dataclass(frozen=True)
class Stamped:
    """Stamps of rows."""

    epoch: float
    time: Array
    clock: Clock = Clock.OWN


def stamps(sheet: Sheet, columns: Sequence[str], unit: str, rows: NDArray[np.intp] | None = None) -> Stamped:
    """Stamps of the rows: whole seconds since the clock's beginning apart where they are many."""
    cells = [sheet.column(name) for name in columns]
    if unit in (ISO, TIME_OF_DAY):
        text = cells[0].astype("string")
        for other in cells[1:]:
            text = text + " " + other.astype("string")
        stamped = _calendar(text) if unit == ISO else Stamped(0.0, _hours(text))
    else:
        if len(cells) != 1:
            raise InputError(f"{sheet.path}: time must be in one column, but for the unit '{ISO}'")
        stamped = _counted(sheet.numbers(columns[0]), cells[0], of.si(unit, of.TIME))
    time = stamped.time if rows is None else stamped.time[rows]
    unknown = np.flatnonzero(~np.isfinite(time))
    if len(unknown):
        row = int(unknown[0]) if rows is None else int(rows[unknown[0]])
        number = "a finite number" if unit in of.TIME else f"such as {_EXAMPLES.get(unit, 'a number')}"
        raise InputError(
            f"{sheet.path}: line {sheet.line(row)}: {' '.join(columns)} must be {number}, and is "
            f"'{' '.join(str(cell.iloc[row]) for cell in cells)}'"
        )
    return replace(stamped, time=time)


def _counted(numbers: Array, cells: pd.Series, unit: float) -> Stamped:
    known = numbers[np.isfinite(numbers)]
    first = float(known[0]) * unit if len(known) else 0.0
    if abs(first) < _MANY:
        return Stamped(0.0, numbers * unit)
    epoch = float(np.floor(first))
    counts = round(epoch / unit)
    if pd.api.types.is_integer_dtype(cells):
        return Stamped(epoch, (cells.to_numpy(dtype=np.int64) - counts) * unit)
    return Stamped(epoch, (numbers - counts) * unit)


def _calendar(text: pd.Series) -> Stamped:
    """Dates, the first day apart; taken for UTC where nothing else is said."""
    dates = pd.to_datetime(text.str.replace("/", "-"), format="ISO8601", utc=True, errors="coerce")
    known = dates.notna()
    day = dates[known].iloc[0].floor("D") if known.any() else pd.Timestamp(0, tz="UTC")
    return Stamped(day.timestamp(), (dates - day).dt.total_seconds().to_numpy(dtype=np.float64), Clock.UNIX)


def _hours(text: pd.Series) -> Array:
    times: Array = pd.to_timedelta(text, errors="coerce").dt.total_seconds().to_numpy(dtype=np.float64)
    return times
