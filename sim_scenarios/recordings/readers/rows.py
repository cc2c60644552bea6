"""Text files of nothing but numbers between blanks; what follows a `#` or `%` is a comment."""

from __future__ import annotations

from collections.abc import Iterator
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.files import whole
from sim_scenarios.recordings.tables import Array

_COMMENTS: Final = ("#", "%")


def numbers(path: Path) -> Array:
    """Numbers of a file, shape (rows, columns).

    Raises
    ------
    InputError
        If there is no such file or no row in it, or if a row holds more or fewer numbers than the first, or
        something else, with its line.
    """
    text = _text(path)
    if next(_rows(text), None) is None:
        raise InputError(f"{path}: holds no row of numbers")
    try:
        table: Array = np.loadtxt(StringIO(text), comments=_COMMENTS, ndmin=2)
    except ValueError as error:
        raise InputError(f"{path}: {_fault(text) or error}") from None
    if not np.isfinite(table).all():
        raise InputError(f"{path}: {_fault(text)}")
    return table


def line(path: Path, row: int) -> int:
    """Number of the line in which a row stands."""
    number, _ = next(islice(_rows(_text(path)), row, None))
    return number


def _text(path: Path) -> str:
    return whole(path).decode("utf-8-sig", "replace")


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line and cells of each row."""
    for number, line in enumerate(StringIO(text), start=1):
        for comment in _COMMENTS:
            line = line.partition(comment)[0]
        if cells := line.split():
            yield number, cells


def _fault(text: str) -> str:
    """What is wrong with the first row that is."""
    width = 0
    for number, cells in _rows(text):
        width = width or len(cells)
        if len(cells) != width:
            return f"line {number}: has {len(cells)} numbers, where the first row has {width}"
        for cell in cells:
            try:
                finite = bool(np.isfinite(float(cell)))
            except ValueError:
                finite = False
            if not finite:
                return f"line {number}: '{cell[:40]}' is not a finite number"
    return ""
