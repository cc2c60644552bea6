"""Cells of a text file, in all the habits of such files.

Separators are commas, semicolons, tabs or blanks; a decimal comma is known where commas do not separate.
Lines that begin with `#` or `%` are comments; the last one above the numbers is the header if it has as many
names as there are columns. Without a header the columns are called 1, 2, 3 ... Names match whatever their
case. A file may be compressed with gzip.
"""

from __future__ import annotations

import gzip
import re
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import Final, TextIO

import numpy as np
import pandas as pd

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.recordings.readers.files import BEGINNING, beginning
from sim_scenarios.recordings.tables import Array

LOOKED_AT: Final = 200
"""Lines from which the habits of a file are found."""
UTF_8: Final = "utf-8-sig"
WINDOWS: Final = "cp1252"
COMMENTS: Final = ("#", "%")
SEPARATORS: Final = {";": "semicolons", "\t": "tabs", ",": "commas", r"\s+": "blanks"}
_OLD: Final = tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1)
_EXACTLY: Final = {"float_precision": "round_trip"} if _OLD else {}
"""So that a number is read as the double nearest to it, as newer versions always do."""
_STAMP: Final = re.compile(r"\d{4}[-/]\d{1,2}[-/]\d{1,2}([T ].*)?|\d{1,2}:\d{2}:\d{2}.*")
_DECIMAL_COMMA: Final = re.compile(r"[-+]?\d+,\d+")


@dataclass(frozen=True)
class Habits:
    """How a file writes its cells."""

    separator: str
    decimal: str
    comment: str
    above: int
    """Lines above the first row of numbers."""
    names: tuple[str, ...]
    header: bool
    encoding: str


@dataclass(frozen=True)
class Sheet:
    """Cells of a file by the names of its columns."""

    path: Path
    habits: Habits
    cells: pd.DataFrame

    def line(self, row: int) -> int:
        """Number of the line in which a row stands."""
        rows = (
            number
            for number, line in enumerate(lines(self.path, self.habits.encoding), start=1)
            if number > self.habits.above and line.strip() and not line.startswith(self.habits.comment)
        )
        return next(islice(rows, row, None), self.habits.above + row + 1)

    def has(self, name: str) -> bool:
        """Whether there is a column of that name."""
        return self._name(name.removeprefix("-")) is not None

    def column(self, name: str) -> pd.Series:
        """Column as it stands in the file, by its name or its number from 1."""
        found = self._name(name)
        if found is None:
            columns = list(map(str, self.cells.columns))
            hint = did_you_mean(name, columns) or f"; there are {', '.join(columns[:20])}"
            raise InputError(f"{self.path}: there is no column {name}{hint}")
        return self.cells[found]

    def numbers(self, name: str) -> Array:
        """Numbers of a column, empty cells not a number; a minus in front of the name turns the sign.

        Raises
        ------
        InputError
            If there is no such column, or it holds something else, with the line.
        """
        if name.startswith("-") and self._name(name) is None:
            return -self.numbers(name[1:])
        column = self.column(name)
        if pd.api.types.is_bool_dtype(column) or not pd.api.types.is_numeric_dtype(column):
            values = pd.to_numeric(column.astype("string"), errors="coerce")
            wrong = np.flatnonzero((values.isna() & column.notna()).to_numpy())
            at = int(wrong[0]) if len(wrong) else 0
            raise InputError(
                f"{self.path}: line {self.line(at)}: column {name} holds '{str(column.iloc[at])[:40]}', "
                "which is not a number"
            )
        numbers: Array = column.to_numpy(dtype=np.float64)
        return numbers

    def _name(self, name: str) -> str | None:
        if name in self.cells:
            return name
        alike = [c for c in self.habits.names if c.casefold() == name.strip().casefold()]
        if not alike and name.isdecimal() and 1 <= int(name) <= len(self.habits.names):
            alike = [self.habits.names[int(name) - 1]]
        return alike[0] if len(alike) == 1 else None


def read(path: Path) -> Sheet:
    """Cells of a text file.

    Raises
    ------
    InputError
        If there is no such file, or it is no table of cells.
    """
    if path.is_dir():
        raise InputError(f"{path}: it is a folder, and must be a file")
    try:
        habits = habits_of(path)
        with warnings.catch_warnings():
            warnings.simplefilter("error", pd.errors.ParserWarning)  # of cells that would be dropped
            cells = pd.read_csv(
                path,
                sep=habits.separator,
                decimal=habits.decimal,
                comment=habits.comment,
                skiprows=habits.above,
                header=None,
                names=list(habits.names),
                index_col=False,
                skipinitialspace=True,
                low_memory=False,
                encoding=habits.encoding,
                **_EXACTLY,
            )
    except InputError:
        raise
    except (OSError, ValueError, EOFError, zlib.error, pd.errors.ParserWarning) as error:
        raise InputError(f"{path}: cannot be read as a CSV file: {str(error).strip()}") from None
    if cells.empty:
        raise InputError(f"{path}: has no row of cells below its header")
    return Sheet(path, habits, cells)


def habits_of(path: Path) -> Habits:
    """How a file writes its cells, by its beginning.

    Raises
    ------
    InputError
        If there is no such file, or its beginning is no table of cells.
    """
    try:
        encoding = _encoding(path)
        return _habits(list(islice(lines(path, encoding), LOOKED_AT)), encoding)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{path}: cannot be read as a CSV file: {str(error).strip()}") from None


def _encoding(path: Path) -> str:
    """UTF-8, or Windows-1252 where the beginning is text in that alone, as a degree sign may be."""
    try:
        beginning(path).decode("utf-8")
    except UnicodeDecodeError as error:
        cut = error.end == len(error.object) == BEGINNING
        return UTF_8 if cut or b"\0" in error.object else WINDOWS
    return UTF_8


def lines(path: Path, encoding: str = UTF_8) -> Iterator[str]:
    """Lines of a text file, which may be compressed with gzip.

    Raises
    ------
    InputError
        If there is no such file, or it is no text.
    """
    opened: Callable[..., TextIO] = gzip.open if path.suffix == ".gz" else open
    try:
        with opened(path, "rt", encoding=encoding) as file:
            yield from file
    except FileNotFoundError:
        raise InputError(f"there is no recording {path}") from None
    except (OSError, ValueError, EOFError, zlib.error) as error:  # the last two of a damaged archive
        raise InputError(f"{path}: cannot be read as a text file: {error}") from None


def _habits(first: list[str], encoding: str) -> Habits:
    """Habits of a file from its first lines; ValueError if they hold no cells."""
    full = [(number, line.strip("\r\n")) for number, line in enumerate(first, start=1) if line.strip()]
    comments = [(n, line) for n, line in full if line.startswith(COMMENTS)]
    rows = [(n, line) for n, line in full if not line.startswith(COMMENTS)]
    if not rows:
        raise ValueError("there is no row of cells")
    comment = comments[0][1][0] if comments else COMMENTS[0]
    separator = _separator([line for _, line in rows])
    headed = not any(map(_is_value, split(rows[0][1], separator)))
    body = [split(line, separator) for _, line in rows[headed:]]
    width = Counter(map(len, body)).most_common(1)[0][0] if body else 0
    above = rows[0][0] if headed else rows[0][0] - 1
    names = split(rows[0][1], separator) if headed else []
    if not headed:
        over = [line.lstrip("#% \t") for n, line in comments if n <= above][-1:]
        titles = [split(line, separator) for line in over]
        names = next((t for t in titles if len(t) == width and not any(map(_is_value, t))), [])
    decimal = "," if separator != "," and any(map(_DECIMAL_COMMA.fullmatch, chain(*body))) else "."
    columns = [name or str(i) for i, name in enumerate(names, start=1)]
    columns += [str(i) for i in range(len(columns) + 1, width + 1)]
    if twice := [name for i, name in enumerate(columns) if name in columns[:i]]:
        raise ValueError(f"column {twice[0]} stands twice in the header")
    return Habits(separator, decimal, comment, above, tuple(columns), bool(names), encoding)


def split(line: str, separator: str) -> list[str]:
    """Cells of a line, without blanks and quotes round them."""
    parts = line.split() if separator == r"\s+" else line.split(separator)
    return [part.strip().strip("\"'") for part in parts]


def _separator(rows: list[str]) -> str:
    """The first separator that most rows have, equally often; blanks otherwise."""
    for separator in (";", "\t", ","):
        if Counter(row.count(separator) for row in rows).most_common(1)[0][0]:
            return separator
    return r"\s+" if len(rows[0].split()) > 1 else ","


def _is_value(cell: str) -> bool:
    """Whether a cell is a number, a date or a time of day."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return _STAMP.fullmatch(cell) is not None
    return True
