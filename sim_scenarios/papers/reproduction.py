"""What a paper prints beside what is measured under its conditions."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from sim_scenarios.cosimulation import Progress, part_of
from sim_scenarios.ensemble import FIGURES, Ensemble, Window, ensemble
from sim_scenarios.papers import OVER, Experiment, Paper, Printed


@dataclass(frozen=True)
class Row:
    """A figure of a paper, and the same here.

    Attributes
    ----------
    label : str
        Filter, or the two of a ratio.
    figure : str
        Name in `ensemble.FIGURES`.
    printed : float or str
    measured : float
        Over all runs, in the unit of the figure; a ratio has none.
    spread : tuple of float or None
        Smallest and largest of a single run.
    """

    label: str
    figure: str
    printed: float | str
    measured: float
    spread: Window | None

    @property
    def title(self) -> str:
        """The figure with its unit."""
        figure = FIGURES[self.figure]
        return figure.title if OVER in self.label or not figure.unit else f"{figure.title} [{figure.unit}]"

    def cells(self) -> list[str]:
        """A line of the table."""
        spread = " to ".join(map(_number, self.spread)) if self.spread else ""
        return [self.label, self.title, _number(self.printed), _number(self.measured), spread]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        return {
            "filter": self.label,
            "figure": self.figure,
            "unit": "1" if OVER in self.label else FIGURES[self.figure].unit,
            "printed": self.printed,
            "measured": self.measured if math.isfinite(self.measured) else None,
            "smallest_and_largest_run": self.spread
            and [x if math.isfinite(x) else None for x in self.spread],
        }


@dataclass(frozen=True)
class Reproduced:
    """A table of a paper beside ours."""

    title: str
    rows: list[Row]
    differences: list[str]

    def cells(self) -> list[list[str]]:
        """The table with its heading."""
        heading = ["Filter", "Figure", "Paper", "Here", "Single runs"]
        return [heading, *(row.cells() for row in self.rows)]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        return {
            "title": self.title,
            "rows": [row.to_json() for row in self.rows],
            "differences": self.differences,
        }


@dataclass(frozen=True)
class Result:
    """An experiment of a paper with its runs."""

    experiment: Experiment
    ensemble: Ensemble
    tables: list[Reproduced]


def reproduce(
    paper: Paper, pool: ProcessPoolExecutor, runs: int, seed: int, progress: Progress = lambda _: None
) -> Iterator[Result]:
    """Run the experiments of a paper, one after another; each is dropped when the next begins."""
    seeds = range(seed, seed + runs)
    for i, experiment in enumerate(paper.experiment):
        measured = ensemble(
            pool,
            experiment.scenario,
            seeds,
            experiment.labels(),
            experiment.set,
            part_of(progress, i, len(paper.experiment)),
        )
        yield Result(experiment, measured, [beside(table, measured) for table in experiment.table])


def beside(table: Printed, measured: Ensemble) -> Reproduced:
    """A table of a paper beside what was measured."""
    rows = [
        _row(label, name, value, measured, table.window or measured.window)
        for label, figures in table.printed.items()
        for name, value in figures.items()
    ]
    differences = [f"{FIGURES[name].title}: {why}" for name, why in table.differences.items()]
    return Reproduced(table.title, rows, differences)


def _row(label: str, name: str, printed: float | str, measured: Ensemble, window: Window) -> Row:
    one, _, other = label.partition(OVER)
    value = measured.figure(name, one, window, over=other or None)
    if other:
        return Row(label, name, printed, value, None)
    each = FIGURES[name].of_each(measured.filters[one], window)
    return Row(label, name, printed, value, (min(each), max(each)))


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return value
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
