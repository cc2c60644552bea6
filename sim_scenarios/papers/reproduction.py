"""What a paper prints beside what is measured under its conditions."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim_scenarios.cosimulation import Progress
from sim_scenarios.fmus import Fmus
from sim_scenarios.papers import Experiment, Paper, Sweep
from sim_scenarios.recordings.folder import RECORDINGS, recording_named
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.studies.ensemble import Ensemble, ensemble, run_file, variables
from sim_scenarios.studies.expectations import Expectations, Row, rows

if TYPE_CHECKING:
    from sim_scenarios.studies.execution import Workers


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
    versions : dict of str to str
        Of the FMUs.
    """

    experiment: Experiment
    scenario: Scenario
    seeds: Sequence[int]
    residuals: Path | None
    kept: Path
    versions: dict[str, str]

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
        versions = {name: fmus[name].version for name in scenario.fmu_names()}
        return Plan(experiment, scenario, seeds, residuals, kept, versions)

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
    planned: Sequence[Plan], workers: Workers, progress: Progress = lambda _: None
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
                workers,
                experiment.scenario,
                plan.seeds,
                experiment.labels(),
                experiment.set,
                advance,
                plan.kept,
                plan.residuals,
                plan.versions,
            ),
        )
        done += cost


def result_of(plan: Plan, measured: Ensemble) -> Result:
    """An experiment with what it measured, beside what is printed."""
    tables = [beside(expectations, measured) for expectations in plan.experiment.expect]
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


def beside(expectations: Expectations, measured: Ensemble) -> Reproduced:
    """A table of a paper beside what was measured."""
    return Reproduced(expectations.title, [*rows(expectations, measured)], expectations.reasons())
