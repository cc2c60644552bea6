"""The clock of a run, and which of its instants a window has: once, for every figure of every command.

The instants of a run are multiples of its communication step, whoever steps; of them, every n-th is recorded.
A window has both its ends, and an instant that only rounding parts from an end is at that end.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError

Array = NDArray[np.float64]
Window = tuple[float, float]
"""Start and stop [s]."""

RESOLUTION: Final = 1e-6
"""Instants that are closer are one [s]: far less than any step, far more than the rounding of days."""


def whole(span: float, step: float, name: str) -> int:
    """How many steps a span has.

    Raises
    ------
    InputError
        That is not a whole number; `name` is that of the span.
    """
    steps = round(span / step)
    if steps < 1 or abs(span - steps * step) > 1e-9 * max(span, step):
        raise InputError(f"{name} = {span:g} s: must be a whole multiple of the step of {step:g} s")
    return steps


def instants(duration: float, step: float, every: int = 1) -> Array:
    """Instants of a run from 0 to its end, or every n-th of them.

    Parameters
    ----------
    duration, step : float
        Of the run, and of its communication steps [s].
    every : int
        Steps from one instant to the next.

    Returns
    -------
    ndarray, shape (n,)
        [s]; the same numbers, whatever `every` is.
    """
    return step * np.arange(0, whole(duration, step, "duration") + 1, every, dtype=np.float64)


def inside(time: Array, start: float, stop: float) -> NDArray[np.bool_]:
    """Which instants a window has, shape (n,)."""
    held: NDArray[np.bool_] = (time >= start - RESOLUTION) & (time <= stop + RESOLUTION)
    return held


def within(time: Array, values: NDArray[Any], start: float, stop: float) -> NDArray[Any]:
    """Values at the instants of a window; time is their first dimension.

    Raises
    ------
    InputError
        The window has none.
    """
    held = values[inside(time, start, stop)]
    if len(held) == 0:
        raise InputError(f"nothing is recorded between {start:g} s and {stop:g} s")
    return held
