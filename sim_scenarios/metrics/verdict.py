"""What every verdict on a run has in common, whatever the filter was for."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import xarray as xr

from sim_scenarios.metrics import certainty
from sim_scenarios.metrics.certainty import Certainty
from sim_scenarios.metrics.statistics import NisStatistics, is_measured, nis_statistics
from sim_scenarios.timeline import Window, inside

FIT: Final = ("aligning", "converged")
"""Status of a filter whose estimate may be relied on; in any other it may not, however small its error."""


class Rmse(NamedTuple):
    """The error that a filter is judged by, in the unit that its title has."""

    title: str
    value: float


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(ABC):
    """How well a filter did; SI units.

    Attributes
    ----------
    ok : bool
        The filter did what it is for: exit code 0.
    status : str
        Status of the filter at the end.
    nis : NisStatistics
        Over the fixes that the filter used in the evaluation window.
    used_fixes, rejected_fixes : int
    certainty : Certainty
        How long it reported convergence, and whether it was right.
    """

    ok: bool
    status: str
    certainty: Certainty
    nis: NisStatistics
    used_fixes: int
    rejected_fixes: int

    @property
    def fit(self) -> bool:
        """Whether the estimate of the end is to be relied on."""
        return self.status in FIT

    @property
    @abstractmethod
    def rmse(self) -> Rmse:
        """Over the evaluation window."""

    @abstractmethod
    def sentence(self) -> str:
        """The verdict in a sentence."""

    @abstractmethod
    def headline(self) -> dict[str, str]:
        """Headline figures with units, by what they are."""

    @abstractmethod
    def row(self) -> dict[str, str]:
        """Figures of a line in a comparison, by column; a column may have two lines."""

    @abstractmethod
    def figures(self) -> dict[str, Any]:
        """Figures of its own under names that end in their unit, for machines."""

    def to_json(self) -> dict[str, Any]:
        """All figures for machines; None where one does not exist."""
        known = self.nis.count > 0
        return {
            **self.figures(),
            "status": self.status,
            "nis_per_channel": self.nis.mean if known else None,
            "nis_interval": [self.nis.lower, self.nis.upper] if known else None,
            "nis_consistent": self.nis.consistent if known else None,
            "used_fixes": self.used_fixes,
            "rejected_fixes": self.rejected_fixes,
            **self.certainty.figures(),
        }

    def __repr__(self) -> str:
        """The sentence, and a headline figure a line: people read no radians."""
        return "\n".join([self.sentence(), *(f"  {name}: {text}" for name, text in self.headline().items())])

    def _common_figures(self) -> dict[str, str]:
        return {
            **self.certainty.headline(),
            "Mean NIS / channels": str(self.nis),
            "Fixes used, rejected": f"{self.used_fixes}, {self.rejected_fixes}",
        }

    def _fix_cells(self) -> dict[str, str]:
        return {"NIS /\nchan.": cell(self.nis.mean, 2), "refused": str(self.rejected_fixes)}


def known(value: float) -> float | None:
    """A figure for machines: None where it does not exist."""
    return None if math.isnan(value) else value


def cell(value: float, digits: int) -> str:
    """A figure in a table."""
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def window(run: xr.Dataset) -> Window:
    """Start and stop of the evaluation of a run [s]."""
    return float(run.attrs["evaluation.start"]), float(run.attrs["evaluation.stop"])


def status_at_end(run: xr.Dataset, name: str = "status") -> str:
    """Name of the status of the filter at the end, or of another variable of that kind."""
    status = run[name]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    return str(names[int(status.values[-1])])


def common(run: xr.Dataset) -> dict[str, Any]:
    """What every verdict says of a run: its fixes, and whether the filter was rightly sure."""
    start, stop = window(run)
    time, used = run["fix_time"].values, run["fix_used"].values
    counted = used & inside(time, start, stop)
    return {
        "nis": nis_statistics(run["nis"].values[counted], is_measured(run)[counted].sum(axis=1)),
        "used_fixes": int(used.sum()),
        "rejected_fixes": int(run["rejected_fixes"].values[-1]) if run.sizes["fix"] else 0,
        "certainty": certainty.of_run(run),
    }
