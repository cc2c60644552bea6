"""Solutions of RTKLIB (`.pos`): positions, velocities and their standard deviations.

The last comment line above the solutions names the fields, in whatever order they stand. Time is a date or a
week and a time of the week, in GPS time, UTC or Japan's time; positions are latitude, longitude and height,
in degrees or in degrees, minutes and seconds. Heights are taken as those above the ellipsoid, which is
RTKLIB's default. Rows without a solution (Q = 0) are left out. A file may be compressed with gzip.

Source: RTKLIB 2.4.2 manual, appendix B.1; `outsolhead` and `outpos` of its solution.c.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import sheets
from sim_scenarios.recordings.readers.contents import Clock, Contents
from sim_scenarios.recordings.readers.gps_time import SINCE_1970, WEEK
from sim_scenarios.recordings.tables import Array, FixTable
from sim_scenarios.units import DEGREE, HOUR

_HEADER: Final = re.compile(r"%\s*(GPST|UTC|JST)[\s,;]+(latitude|x-ecef|e-baseline)\(", re.IGNORECASE)
_BETWEEN: Final = re.compile(r"[\s,;]+")
_AHEAD_OF_UTC: Final = {"utc": 0.0, "jst": 9 * HOUR}
_NO_SOLUTION: Final = 0


@dataclass(frozen=True)
class _Solutions:
    """Cells of rows by the name of their field, and the lines in which they stand."""

    scale: str
    fields: dict[str, int]
    sexagesimal: bool
    rows: list[list[str]]
    lines: list[int]


def recognises(path: Path) -> bool:
    """Whether a comment line names the fields of solutions."""
    try:
        return any(map(_HEADER.match, islice(sheets.lines(path), sheets.LOOKED_AT)))
    except InputError:
        return False


def read(path: Path) -> Contents:
    """Fixes of a solution file.

    Raises
    ------
    InputError
        If no header names the fields, positions are not latitude, longitude and height, or a line holds
        something else than the header says; the last one may be cut short.
    """
    solutions, values = _solved(path, _rows(path))
    fields = solutions.fields

    def columns(*names: str, otherwise: float) -> Array:
        missing = np.full(len(values), otherwise)
        return np.stack([values[:, fields[n]] if n in fields else missing for n in names], axis=-1)

    clock, epoch, time = _time(path, solutions)
    if solutions.sexagesimal:
        latitude, longitude = (
            _degrees(values[:, fields[n] : fields[n] + 3]) for n in ("latitude", "longitude")
        )
    else:
        latitude, longitude = columns("latitude", "longitude", otherwise=np.nan).T
    height = columns("height", otherwise=np.nan)[:, 0]
    table = FixTable(
        time,
        np.stack([latitude * DEGREE, longitude * DEGREE, height], axis=-1),
        columns("ve", "vn", "vu", otherwise=np.nan),
        columns("sde", "sdn", "sdu", otherwise=0.0),
        columns("sdve", "sdvn", "sdvu", otherwise=0.0),
    )
    return Contents(clock=clock, epoch=epoch, gnss=table, place=lambda _, row: f"line {solutions.lines[row]}")


def _rows(path: Path) -> _Solutions:
    header, rows, lines = "", [], []
    for number, line in enumerate(sheets.lines(path), start=1):
        if line.startswith("%"):
            header = line if _HEADER.match(line) else header
        elif line.strip():
            rows.append([cell for cell in _BETWEEN.split(line) if cell])
            lines.append(number)
    found = _HEADER.match(header)
    if found is None:
        raise InputError(f"{path}: no line such as '%  GPST latitude(deg) ...' names the fields")
    if found[2].lower() != "latitude":
        raise InputError(f"{path}: positions must be latitude, longitude, height, and are {found[2]} ...")
    scale, *names = (cell for cell in _BETWEEN.split(header.lstrip("% ")) if cell)
    sexagesimal = "'" in names[0]
    fields: dict[str, int] = {}
    at = 2
    for name in names:
        key = name.partition("(")[0].lower()
        fields[key] = at
        at += 3 if sexagesimal and key in ("latitude", "longitude") else 1
    if "longitude" not in fields:
        raise InputError(f"{path}: the line that names the fields names a latitude and no longitude")
    if rows and len(rows[-1]) < at:
        del rows[-1], lines[-1]
    for cells, number in zip(rows, lines, strict=True):
        if len(cells) != at:
            raise InputError(f"{path}: line {number}: has {len(cells)} cells, and the header names {at}")
    if not rows:
        raise InputError(f"{path}: has no solution")
    return _Solutions(scale.lower(), fields, sexagesimal, rows, lines)


def _solved(path: Path, every: _Solutions) -> tuple[_Solutions, Array]:
    """Rows that are solutions, and their cells behind the time as numbers."""
    values = _numbers(path, every)
    if "q" not in every.fields:
        return every, values
    solved = np.flatnonzero(values[:, every.fields["q"]] != _NO_SOLUTION)
    if not len(solved):
        raise InputError(f"{path}: has no solution")
    rows, lines = [every.rows[i] for i in solved], [every.lines[i] for i in solved]
    return replace(every, rows=rows, lines=lines), values[solved]


def _numbers(path: Path, solutions: _Solutions) -> Array:
    """Cells behind the time as numbers, in their columns."""
    values = np.full((len(solutions.rows), len(solutions.rows[0])), np.nan)
    row = 0
    try:
        for row, cells in enumerate(solutions.rows):
            values[row, 2:] = cells[2:]
    except ValueError as error:
        raise InputError(f"{path}: line {solutions.lines[row]}: {error}") from None
    return values


def _time(path: Path, solutions: _Solutions) -> tuple[Clock, float, Array]:
    """Clock, its seconds at the first day or week, and stamps from there."""
    dated = "/" in solutions.rows[0][0]
    stamps = np.empty(len(solutions.rows))
    first = 0.0
    for i, (one, other, *_) in enumerate(solutions.rows):
        try:
            if dated:
                begin = float(np.datetime64(one.replace("/", "-"), "s").astype(np.int64)) - SINCE_1970
                hours, minutes, seconds = map(float, other.split(":"))
                within = 3600 * hours + 60 * minutes + seconds
            else:
                begin, within = float(one) * WEEK, float(other)
        except ValueError:
            raise InputError(
                f"{path}: line {solutions.lines[i]}: '{one} {other}' is no time such as "
                f"{'2025/01/01 19:34:18.499' if dated else '2347 329658.499'}"
            ) from None
        first = first if i else begin
        stamps[i] = begin - first + within
    if solutions.scale == "gpst":
        return Clock.GPS, first, stamps
    return Clock.UNIX, first + SINCE_1970 - _AHEAD_OF_UTC[solutions.scale], stamps


def _degrees(parts: Array) -> Array:
    """Degrees of degrees, minutes, seconds, the sign in front."""
    sign = np.where(np.signbit(parts[:, 0]), -1.0, 1.0)
    degrees: Array = sign * (np.abs(parts[:, 0]) + parts[:, 1] / 60 + parts[:, 2] / 3600)
    return degrees
