"""How every picture looks.

Colours are those of Okabe and Ito, which colour-blind readers tell apart; nothing is told by colour alone.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 10.0  # inch
INK = "#24292f"
GRID = "#d8dee4"
BLUE, ORANGE, GREEN, YELLOW, PURPLE, SKY = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, YELLOW, SKY)
DASHES = ("-", "--", ":", "-.")
"""Colours and dashes of curves side by side: in the order of plots.css and plots.js, which draw them too."""
NAVIGATION_AXES = ("east", "north", "up")
BODY_AXES = ("right", "forward", "up")
BAND: dict[str, Any] = {"color": BLUE, "alpha": 0.18, "lw": 0}
"""Three sigma of a filter."""

STYLE: dict[Any, Any] = {
    "figure.facecolor": "white",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": GRID,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.titley": 1.0,
    "axes.labelsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 8,
    "legend.edgecolor": GRID,
    "legend.framealpha": 0.85,
    "axes.xmargin": 0.01,
}


def png(drawn: Figure) -> bytes:
    """A figure as PNG, drawn once; `savefig` draws it twice when it has a layout."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    buffer = io.BytesIO()
    drawn.set_dpi(110)
    FigureCanvasAgg(drawn).print_png(buffer)
    return buffer.getvalue()


@contextmanager
def figure(
    *, rows: int, height: float, columns: int = 1, sharex: bool = False
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure and its axes in reading order."""
    import matplotlib as mpl  # slow: a verdict stands before it
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import TightLayoutEngine  # half the time of the constrained one

    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, height), layout=TightLayoutEngine(pad=0.4))
        axes = drawn.subplots(rows, columns, sharex=sharex, squeeze=False)
        yield drawn, list(axes.flat)


def largest(*values: ArrayLike) -> float:
    """Largest size of finite values; 0 without one."""
    sizes = np.abs(np.concatenate([np.ravel(np.asarray(one, dtype=float)) for one in values]))
    return float(sizes[np.isfinite(sizes)].max(initial=0.0))


def limit(axes: Axes, reach: float, floor: float) -> None:
    """Symmetric limits of the vertical axis."""
    reach = max(1.08 * reach, floor)
    axes.set_ylim(-reach, reach)


def shade_window(axes: Axes, data: xr.Dataset, label: str | None = None) -> None:
    """Mark the evaluation window."""
    window = (data.attrs["evaluation.start"], data.attrs["evaluation.stop"])
    axes.axvspan(*window, color=INK, alpha=0.05, lw=0, label=label)


def lines(labels: Iterable[object]) -> Iterator[tuple[str, str, str]]:
    """Label, colour and dashes of each of several curves."""
    for label, colour, dashes in zip(labels, cycle(COLOURS), cycle(DASHES), strict=False):
        yield str(label), colour, dashes
