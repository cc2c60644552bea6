"""Rows of a table in the order of their stamps, each once.

A row that equals the one before it, stamp and all, was written twice and is left out. Any other stamp that
does not increase is refused with its line: nobody knows which of two rows is right, and what is left out of
an IMU is motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import clocks, stamps
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.recordings.readers.gps_time import DAY, WEEK
from sim_scenarios.recordings.sources import StampsAre
from sim_scenarios.recordings.tables import Array

Table = TypeVar("Table", bound=Any)
"""A dataclass with `time`, shape (n,), and other arrays of as many rows."""

NEAR: Final = 60.0
"""How far a step back may be from a day or a week to be taken for the beginning of another [s]."""


def in_order(
    table: Table, clock: Clock, stamps_are: StampsAre, place: Callable[[int], str]
) -> tuple[Table, list[str]]:
    """Rows with increasing stamps.

    Parameters
    ----------
    table : dataclass
        As it was read.
    clock : Clock
        Of its stamps; those of a day or a week go on where they begin again.
    stamps_are : StampsAre
        What is made of them.
    place : callable
        File and line of a row.

    Returns
    -------
    table : dataclass
    remarks : list of str
        What was left out or moved.

    Raises
    ------
    InputError
        If a stamp is not finite or does not increase.
    """
    unknown = np.flatnonzero(~np.isfinite(table.time))
    if len(unknown):
        raise InputError(f"{place(int(unknown[0]))}: time must be a finite number")
    time = clocks.unwrapped(table.time, clock)
    rows = np.arange(len(time))
    if stamps_are is StampsAre.SORTED:
        rows = np.argsort(time, kind="stable")
        time = time[rows]
    again = _again(_rows(table, rows))
    rows, time = rows[~again], time[~again]
    remarks = []
    if again.any():
        first = place(int(np.flatnonzero(again)[0]))
        remarks.append(f"{first}: {_count(int(np.count_nonzero(again)), 'row')} written twice, left out")
    if stamps_are is StampsAre.STEADY and not (np.diff(time) < 0).any():
        steady = stamps.on_a_steady_clock(time)
        most = float(np.abs(steady - time).max(initial=0.0))
        remarks.append(
            f"{place(0)}: from here on stamps were moved by up to {most:.2g} s onto a steady clock"
        )
        time = steady
    wrong = np.flatnonzero(np.diff(time) <= 0)
    if len(wrong):
        before, after = time[wrong[0] : wrong[0] + 2]
        raise InputError(
            f"{place(int(rows[wrong[0] + 1]))}: time must increase from each row to the next, and goes from "
            f"{before:.10g} to {after:.10g} s{_remedy(float(before - after))}"
        )
    return replace(_rows(table, rows), time=time), remarks


def _remedy(back: float) -> str:
    if back == 0:
        return "; if all rows are there and their stamps are coarse, say stamps = 'steady'"
    if abs(back - WEEK) < NEAR:
        return "; if these are seconds of the week, say clock = 'gps-week'"
    if abs(back - DAY) < NEAR:
        return "; if these are seconds of the day, say clock = 'gps-day' or 'utc-day'"
    return "; if rows were written out of order, say stamps = 'sorted'"


def _again(table: Table) -> NDArray[np.bool_]:
    """Rows that are equal to the one before them."""
    same = np.ones(len(table.time), dtype=bool)
    same[:1] = False
    for values in _arrays(table).values():
        now, before = values[1:], values[:-1]
        equal = (now == before) | (np.isnan(now) & np.isnan(before))
        same[1:] &= equal if equal.ndim == 1 else equal.all(axis=1)
    return same


def _rows(table: Table, rows: NDArray[np.intp]) -> Table:
    return replace(table, **{name: values[rows] for name, values in _arrays(table).items()})


def _arrays(table: Table) -> dict[str, Array]:
    given = {field.name: getattr(table, field.name) for field in fields(table)}
    return {name: values for name, values in given.items() if isinstance(values, np.ndarray)}


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
