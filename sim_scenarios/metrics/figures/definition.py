"""What a figure is: a number of one filter of a run over a window, and how many runs make one of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.metrics.errors import root_mean_square
from sim_scenarios.metrics.folds import MEAN, OF_ERRORS, OF_SUMS, Fold
from sim_scenarios.timeline import Window
from sim_scenarios.units import Reading, reading

Array = NDArray[np.float64]
Of = Callable[[xr.Dataset, Window], float]
"""Figure of one filter of a run (a data set of `sim_scenarios.run`) over a window; NaN if there is none."""


@dataclass(frozen=True)
class Figure:
    """A figure of one filter of a run.

    Attributes
    ----------
    name : str
        That of its variable in the data set of a campaign, and in papers and bands.
    title, unit, description : str
        The unit is of SI, "1" of a number.
    of : callable
        The figure of a run over a window.
    fold : Fold
        How that of many runs is made of it.
    needs : tuple of str
        Outputs of the filter besides `OUTPUTS`, arrays by their base name.
    parts : tuple of Figure
        Those that it is the ratio of, whose sums over runs make that of many, with the fold `OF_SUMS`.
    """

    name: str
    title: str
    unit: str
    description: str
    of: Of
    fold: Fold = MEAN
    needs: tuple[str, ...] = ()
    parts: tuple[Figure, ...] = ()

    @property
    def reading(self) -> Reading:
        """Unit in which people read it."""
        return reading(self.unit)

    @property
    def label(self) -> str:
        """Title with the unit in which people read it."""
        sign = self.reading.sign
        return f"{self.title} [{sign}]" if sign else self.title

    def text(self, value: float) -> str:
        """A value as people read it."""
        return f"{value / self.reading.size:.4g} {self.reading.name}".rstrip()

    def of_each(self, runs: Sequence[xr.Dataset], window: Window) -> Array:
        """That of each run, shape (runs,)."""
        return np.array([self.of(run, window) for run in runs], dtype=float)

    def of_runs(self, runs: Sequence[xr.Dataset], window: Window) -> float:
        """That of all runs together."""
        return self.folded(window, lambda one: one.of_each(runs, window), lambda: runs)

    def folded(
        self,
        window: Window,
        of_each: Callable[[Figure], Array],
        runs: Callable[[], Sequence[xr.Dataset]],
    ) -> float:
        """That of all runs together, from what gives a figure of each, and their errors where those count."""
        if self.fold is OF_ERRORS:
            return self.of(root_mean_square(runs()), window)
        if self.fold is OF_SUMS:
            over, under = (np.sum(of_each(part)) for part in self.parts)
            return float(over / under) if under > 0 else np.nan
        return self.fold.estimate(of_each(self)).value


def figure(
    *, title: str, unit: str = "1", fold: Fold = MEAN, needs: Sequence[str] = ()
) -> Callable[[Of], Figure]:
    """Mark a function of a run and a window as a figure of its name, described by its docstring.

    Parameters as the attributes of `Figure`.
    """

    def made(of: Of) -> Figure:
        description = " ".join((of.__doc__ or title).split()).rstrip(".")
        return Figure(of.__name__, title, unit, description, of, fold, tuple(needs))

    return made
