"""What a paper claims beyond its figures: from how far a filter converges, and how long it takes.

Both are tables as those of `reproduction`: with a title, cells and what machines read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sim_scenarios.metrics.folds import Estimate, share
from sim_scenarios.papers import Experiment, Sweep
from sim_scenarios.studies.ensemble import Ensemble
from sim_scenarios.studies.expectations import OVER


@dataclass(frozen=True)
class Point:
    """A filter at one value of a sweep.

    Attributes
    ----------
    value : float
    label : str
    runs : int
    converged : Estimate
        Share of the runs whose heading error stays within its limit from some time on.
    settled : float
        Median time of that [s]; infinite if half of the runs never do.
    """

    value: float
    label: str
    runs: int
    converged: Estimate
    settled: float


@dataclass(frozen=True)
class Swept:
    """A sweep with its runs."""

    sweep: Sweep
    points: list[Point]
    differences: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Of the table."""
        return self.sweep.title

    def shares(self) -> dict[str, list[Estimate]]:
        """Share of the runs that converge, of each filter, value by value."""
        return {
            label: [point.converged for point in self.points if point.label == label]
            for label in self.sweep.filters
        }

    def cells(self) -> list[list[str]]:
        """The table with its heading."""
        rows = [
            [
                f"{point.value:g}",
                point.label,
                f"{round(point.converged.value * point.runs)} of {point.runs}",
                f"{point.converged.lower:.2f} to {point.converged.upper:.2f}",
                f"{point.settled:.0f}" if point.settled < float("inf") else "never",
            ]
            for point in self.points
        ]
        return [[self.sweep.axis, "Filter", "Converged", "Share, 95 %", "Median time [s]"], *rows]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        rows = [
            {
                "value": point.value,
                "filter": point.label,
                "runs": point.runs,
                "converged": point.converged.value,
                "interval": [point.converged.lower, point.converged.upper],
                "median_time_s": point.settled if point.settled < float("inf") else None,
            }
            for point in self.points
        ]
        return {"title": self.title, "axis": self.sweep.axis, "rows": rows}


def points(sweep: Sweep, value: float, runs: Ensemble) -> list[Point]:
    """Every filter of a sweep at one of its values."""
    found = []
    for label in sweep.filters:
        each = runs.of_each("settling", label)
        converged = share(int((each < float("inf")).sum()), len(each))
        found.append(Point(value, label, len(each), converged, runs.figure("median_settling", label)))
    return found


@dataclass(frozen=True)
class Timed:
    """How long the steps of the filters of an experiment take.

    Attributes
    ----------
    experiment : Experiment
    seconds : dict of str to float
        Of a step, by filter.
    """

    experiment: Experiment
    seconds: dict[str, float]
    differences: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Of the table."""
        return f"Time of one core that a step takes, {self.experiment.scenario}, on this machine"

    def cells(self) -> list[list[str]]:
        """The table with its heading."""
        rows = []
        for what, said in self.experiment.time.items():
            one, _, other = what.partition(OVER)
            here = (
                f"{self.seconds[one] / self.seconds[other]:.2f}"
                if other
                else f"{1e6 * self.seconds[one]:.1f} us"
            )
            rows.append([what, said, here])
        return [["Filter", "Paper", "Here"], *rows]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        return {"title": self.title, "seconds_a_step": self.seconds}
