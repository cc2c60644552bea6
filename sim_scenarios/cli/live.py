"""A run that is watched: on the terminal, and on a page whose address is told there."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from sim_scenarios.cli.terminal import is_quiet
from sim_scenarios.live.looks import Look, Place, watch
from sim_scenarios.live.server import Story, served
from sim_scenarios.simulation import Watch
from sim_scenarios.units import DEGREE

COLUMNS: Final = 36
ROWS: Final = 9
"""Characters of the track."""
FINEST: Final = 1e-3
"""Least size of a dot of it [m]."""
BLANK: Final = 0x2800
"""Braille without a dot (Unicode)."""
WEIGHTS: Final = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
"""What each of its dots adds, by column and row."""


@contextmanager
def watched(title: str, pace: float | None) -> Iterator[Watch]:
    """Show a run while it goes on, on standard error and on a page."""
    story = Story()
    with served(title, story) as address:
        print(f"{title}: live at {address}", file=sys.stderr, flush=True)
        with _terminal() as tell:

            def show(look: Look) -> None:
                story.tell(look)
                tell(look)

            yield watch(show, pace)


@contextmanager
def _terminal() -> Iterator[Callable[[Look], None]]:
    """What shows looks on standard error: a view on a terminal, else a line for each tenth of the run."""
    standard_error = Console(stderr=True)
    if is_quiet():
        yield lambda _: None
        return
    if not standard_error.is_terminal:
        yield _tenths()
        return
    track: list[Place] = []
    with Live(console=standard_error, transient=True, auto_refresh=False) as view:

        def tell(look: Look) -> None:
            track.append(look.place)
            view.update(_view(look, [] if standard_error.options.ascii_only else track), refresh=True)

        yield tell


def _tenths() -> Callable[[Look], None]:
    told = -1

    def tell(look: Look) -> None:
        nonlocal told
        if (tenth := int(10 * look.time / look.duration + 1e-9)) > told:
            told = tenth
            said = (f"{name.lower()} {value}" for name, value in _figures(look).items())
            print(", ".join(said), file=sys.stderr, flush=True)

    return tell


def _figures(look: Look) -> dict[str, str]:
    """What a look says, by name."""

    def degrees(angle: float) -> str:
        return f"{angle / DEGREE:.3f} deg" if math.isfinite(angle) else "-"

    return {
        "Time": f"{look.time:.1f} s of {look.duration:g} s",
        "Heading": degrees(look.heading),
        "1 sigma": degrees(look.heading_sigma),
        "Error": degrees(look.heading_error),
        "Status": look.status or "-",
        "Place": f"{look.place[0]:.1f} m east, {look.place[1]:.1f} m north",
    }


def _view(look: Look, track: Sequence[Place]) -> RenderableType:
    """Figures and, beside them, the track."""
    figures = Table.grid(padding=(0, 2))
    for name, value in _figures(look).items():
        figures.add_row(name, Text(value, style="bold"))
    lines, across = drawn(track)
    there = Table.grid()
    there.add_row(Text("\n".join(lines), style="cyan"))
    there.add_row(Text(f"track, {across:,.{0 if across > 10 else 2}f} m across", style="dim"))
    both = Table.grid(padding=(0, 4))
    both.add_row(figures, there if lines else "")
    return Group(both, ProgressBar(total=look.duration, completed=look.time))


def drawn(track: Sequence[Place]) -> tuple[list[str], float]:
    """A track in Braille, north up and east as long as north; and how wide the picture is [m].

    Places that are not known are left out; without one there are no lines.
    """
    places = np.array([place for place in track if np.isfinite(place).all()]).reshape(-1, 2)
    if len(places) == 0:
        return [], 0.0
    size = np.array([COLUMNS * len(WEIGHTS), ROWS * len(WEIGHTS[0])])
    low, high = places.min(axis=0), places.max(axis=0)
    dot = max(*(high - low) / (size - 1), FINEST)
    east, north = np.rint((places - (low + high) / 2) / dot + (size - 1) / 2).astype(int).T
    cells = np.full((ROWS, COLUMNS), BLANK)
    for column, row in {*zip(east.tolist(), (size[1] - 1 - north).tolist(), strict=True)}:
        cells[row // 4, column // 2] |= WEIGHTS[column % 2][row % 4]
    return ["".join(map(chr, line)) for line in cells.tolist()], float(dot * size[0])
