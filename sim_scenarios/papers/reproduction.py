"""What a paper prints beside what is measured under its conditions."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Progress
from sim_scenarios.ensemble import Ensemble, ensemble, run_file, variables
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.figures import Figure, known
from sim_scenarios.papers import OVER, Experiment, Paper, Printed, Sweep
from sim_scenarios.recordings.folder import RECORDINGS, recording_named
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.timeline import Window

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """A figure of a paper, and the same here.

    Attributes
    ----------
    label : str
        Filter, or the two of a ratio.
    figure : str
        Name in `metrics.figures`.
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
        figure = known()[self.figure]
        return figure.title if OVER in self.label else figure.label

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
            "unit": "1" if OVER in self.label else known()[self.figure].reading.sign,
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
    seeds : sequence of int
    residuals : Path or None
        Recording whose residuals join the noise.
    kept : Path
        Folder of its runs; another one for every change of scenario, filters or FMUs.
    """

    experiment: Experiment
    scenario: Scenario
    seeds: Sequence[int]
    residuals: Path | None
    kept: Path

    @property
    def missing(self) -> int:
        """Runs that are not there yet."""
        return sum(not run_file(self.kept, seed).is_file() for seed in self.seeds)

    @property
    def cost(self) -> float:
        """Seconds of one core that the missing runs take."""
        return self.experiment.cost * self.missing


@dataclass(frozen=True)
class Plans:
    """What is to be done for a paper.

    Attributes
    ----------
    experiments : list of Plan
    sweeps : list of tuple of Sweep and list of Plan
        A plan for each value.
    left_out : list of str
        Experiments that cannot be done, and why, in a sentence each.
    """

    experiments: list[Plan]
    sweeps: list[tuple[Sweep, list[Plan]]]
    left_out: list[str]

    @property
    def all(self) -> list[Plan]:
        """All of them."""
        return [*self.experiments, *(plan for _, of_sweep in self.sweeps for plan in of_sweep)]

    def swept_by(self, plan: Plan) -> tuple[Sweep, float]:
        """Sweep that a plan belongs to, and its value there."""
        return next(
            (sweep, sweep.values[of_sweep.index(plan)]) for sweep, of_sweep in self.sweeps if plan in of_sweep
        )


def plans(paper: Paper, seeds: Sequence[int], folder: Path) -> Plans:
    """What is to be done for a paper whose results go into a folder; makes the folders of its runs.

    A sweep has as many runs at each of its values as it says, or fewer if there are fewer seeds.
    """
    fmus = Fmus()

    def plan(experiment: Experiment, seeds: Sequence[int], residuals: Path | None = None) -> Plan:
        scenario = load_scenario(experiment.scenario, fmus, settings=experiment.set)
        identity = _identity(scenario, experiment, fmus, residuals)
        kept = folder / "runs" / f"{experiment.name.replace(' ', '_')}-{identity}"
        kept.mkdir(parents=True, exist_ok=True)
        return Plan(experiment, scenario, seeds, residuals, kept)

    experiments, left_out = [], []
    for experiment in paper.experiment:
        residuals = recording_named(experiment.residuals) if experiment.residuals else None
        if experiment.residuals and residuals is None:
            left_out.append(
                f"{experiment.name}: not run, {experiment.residuals} is not in the folder that the "
                f"environment variable {RECORDINGS} names"
            )
        else:
            experiments.append(plan(experiment, seeds, residuals))
    sweeps = [(sweep, [plan(e, seeds[: sweep.runs]) for e in sweep.experiments()]) for sweep in paper.sweep]
    return Plans(experiments, sweeps, left_out)


def run_plans(
    planned: Sequence[Plan], pool: ProcessPoolExecutor, progress: Progress = lambda _: None
) -> Iterator[tuple[Plan, Ensemble]]:
    """Run the experiments of a paper, one after another; each is dropped when the next begins."""
    costs = [plan.cost for plan in planned]
    whole, done = sum(costs) or 1.0, 0.0
    for plan, cost in zip(planned, costs, strict=True):
        experiment = plan.experiment

        def advance(share: float, before: float = done, cost: float = cost) -> None:
            progress((before + share * cost) / whole)

        yield (
            plan,
            ensemble(
                pool,
                experiment.scenario,
                plan.seeds,
                experiment.labels(),
                experiment.set,
                advance,
                plan.kept,
                plan.residuals,
            ),
        )
        done += cost


def result_of(plan: Plan, measured: Ensemble) -> Result:
    """An experiment with what it measured, beside what is printed."""
    tables = [beside(table, measured) for table in plan.experiment.table]
    return Result(plan.experiment, plan.scenario, measured, tables)


def _identity(scenario: Scenario, experiment: Experiment, fmus: Fmus, residuals: Path | None) -> str:
    """Of all that decides what a run of an experiment is, its seed apart."""
    content = {
        "kept": variables(),
        "residuals": residuals and hashlib.sha256(residuals.read_bytes()).hexdigest(),
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
    differences = [f"{known()[name].title}: {why}" for name, why in table.differences.items()]
    return Reproduced(table.title, rows, differences)


def _row(label: str, name: str, printed: float | str, measured: Ensemble, window: Window) -> Row:
    one, _, other = label.partition(OVER)
    value = measured.figure(name, one, window, over=other or None)
    each = [measured.of_each(name, which, window) for which in (one, other) if which]
    spread = None if other else (float(each[0].min()), float(each[0].max()))
    return Row(label, name, printed, value, _interval(known()[name], each), spread)


def _interval(figure: Figure, each: Sequence[Array]) -> Window | None:
    """Interval of a figure, or of the ratio of two filters over the same runs, from those of single runs."""
    if len(each) == 1:
        estimate = figure.fold.estimate(each[0])
    elif figure.fold.ratio is not None:
        estimate = figure.fold.ratio(*each)
    else:
        return None
    return (estimate.lower, estimate.upper) if math.isfinite(estimate.lower) else None


def _range(of: Window | None) -> str:
    return " to ".join(map(_number, of)) if of else ""


def _number(value: float | str) -> str:
    if isinstance(value, str):
        return value
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
