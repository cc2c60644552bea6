"""What a paper prints beside what is measured under its conditions."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from numpy.typing import ArrayLike

from sim_scenarios.campaigns.statistics import (
    Estimate,
    mean_of,
    paired_ratio,
    ratio_of_means,
    root_mean_square,
)
from sim_scenarios.cosimulation import Progress
from sim_scenarios.ensemble import (
    FIGURES,
    Ensemble,
    Errors,
    Window,
    at_end,
    ensemble,
    largest,
    mean_rmse,
    rmse,
    run_file,
)
from sim_scenarios.fmus import Fmus
from sim_scenarios.papers import OVER, Experiment, Paper, Printed
from sim_scenarios.scenario import Scenario, load_scenario

OfOne = Callable[[ArrayLike], Estimate]
OfTwo = Callable[[ArrayLike, ArrayLike], Estimate]
INTERVALS: Final[Mapping[Callable[[Errors], float], tuple[OfOne, OfTwo]]] = {
    rmse: (root_mean_square, paired_ratio),
    mean_rmse: (mean_of, ratio_of_means),
    largest: (mean_of, ratio_of_means),
    at_end: (mean_of, ratio_of_means),
}
"""What gives the interval of a statistic of runs, and of its ratio, from the statistic of every run."""


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
    interval : tuple of float or None
        Of 95 %; None of a figure that has none, or of a single run.
    spread : tuple of float or None
        Smallest and largest of a single run.
    """

    label: str
    figure: str
    printed: float | str
    measured: float
    interval: Window | None
    spread: Window | None

    @property
    def title(self) -> str:
        """The figure with its unit."""
        figure = FIGURES[self.figure]
        return figure.title if OVER in self.label or not figure.unit else f"{figure.title} [{figure.unit}]"

    def cells(self) -> list[str]:
        """A line of the table."""
        measured = _number(self.measured)
        return [
            self.label,
            self.title,
            _number(self.printed),
            measured,
            _range(self.interval),
            _range(self.spread),
        ]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        return {
            "filter": self.label,
            "figure": self.figure,
            "unit": "1" if OVER in self.label else FIGURES[self.figure].unit,
            "printed": self.printed,
            "measured": self.measured if math.isfinite(self.measured) else None,
            "interval": self.interval,
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
        heading = ["Filter", "Figure", "Paper", "Here", "95 %", "Single runs"]
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
    scenario: Scenario
    ensemble: Ensemble
    tables: list[Reproduced]


@dataclass(frozen=True)
class Plan:
    """What is to be done for an experiment.

    Attributes
    ----------
    experiment : Experiment
    scenario : Scenario
    kept : Path
        Folder of its runs; another one for every change of scenario, filters or FMUs.
    missing : int
        Runs that are not there yet.
    """

    experiment: Experiment
    scenario: Scenario
    kept: Path
    missing: int

    @property
    def cost(self) -> float:
        """Seconds of one core that the missing runs take."""
        return self.experiment.cost * self.missing


def plans(paper: Paper, seeds: Sequence[int], folder: Path) -> list[Plan]:
    """What is to be done for a paper whose results go into a folder; makes the folders of its runs."""
    fmus = Fmus()
    result = []
    for experiment in paper.experiment:
        scenario = load_scenario(experiment.scenario, fmus, settings=experiment.set)
        kept = folder / "runs" / f"{experiment.name}-{_identity(scenario, experiment, fmus)}"
        kept.mkdir(parents=True, exist_ok=True)
        missing = sum(not run_file(kept, seed).is_file() for seed in seeds)
        result.append(Plan(experiment, scenario, kept, missing))
    return result


def reproduce(
    planned: Sequence[Plan],
    pool: ProcessPoolExecutor,
    seeds: Sequence[int],
    progress: Progress = lambda _: None,
) -> Iterator[Result]:
    """Run the experiments of a paper, one after another; each is dropped when the next begins."""
    whole = sum(plan.cost for plan in planned) or 1.0
    done = 0.0
    for plan in planned:
        experiment, before = plan.experiment, done

        def advance(share: float, before: float = before, cost: float = plan.cost) -> None:
            progress((before + share * cost) / whole)

        measured = ensemble(
            pool, experiment.scenario, seeds, experiment.labels(), experiment.set, advance, plan.kept
        )
        done += plan.cost
        yield Result(
            experiment, plan.scenario, measured, [beside(table, measured) for table in experiment.table]
        )


def _identity(scenario: Scenario, experiment: Experiment, fmus: Fmus) -> str:
    """Of all that decides what a run of an experiment is, its seed apart."""
    content = {
        "scenario": scenario.model_dump(mode="json"),
        "labels": experiment.labels(),
        "fmus": {name: fmus[name].guid for name in scenario.fmu_names()},
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:12]


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
    each = [FIGURES[name].of_each(measured.filters[which], window) for which in (one, other) if which]
    spread = None if other else (min(each[0]), max(each[0]))
    return Row(label, name, printed, value, _interval(name, each), spread)


def _interval(name: str, each: Sequence[Sequence[float]]) -> Window | None:
    """Interval of a figure, or of the ratio of two filters over the same runs, from those of single runs.

    A time of the root mean square over runs is no mean of times of runs, and has none.
    """
    if FIGURES[name].statistic not in INTERVALS:
        return None
    of_one, of_two = INTERVALS[FIGURES[name].statistic]
    estimate = of_one(each[0]) if len(each) == 1 else of_two(*each)
    return (estimate.lower, estimate.upper) if math.isfinite(estimate.lower) else None


def _range(of: Window | None) -> str:
    return " to ".join(map(_number, of)) if of else ""


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return value
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
