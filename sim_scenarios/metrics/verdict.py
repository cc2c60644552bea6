"""What every verdict on a run has in common, whatever the filter was for."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
import xarray as xr

from sim_scenarios.metrics import certainty
from sim_scenarios.metrics.certainty import Certainty
from sim_scenarios.metrics.statistics import NisStatistics, is_measured, nis_statistics, tells_nis
from sim_scenarios.timeline import Window, inside

FIT: Final = ("aligning", "converged")
"""Status of a filter whose estimate may be relied on; in any other it may not, however small its error.

A filter of somebody else's that has no status is judged by its error alone.
"""


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
    status : str or None
        Status of the filter at the end, if it has one.
    nis : NisStatistics
        Over the fixes that the filter used in the evaluation window.
    used_fixes, rejected_fixes : int or None
        If the filter counts them.
    certainty : Certainty
        How long it reported convergence, and whether it was right.
    """

    ok: bool
    status: str | None
    certainty: Certainty
    nis: NisStatistics
    used_fixes: int | None
    rejected_fixes: int | None

    @property
    def fit(self) -> bool:
        """Whether the estimate of the end is to be relied on."""
        return is_fit(self.status)

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
        tells = self.nis.count > 0
        figures = {
            **self.figures(),
            "status": self.status,
            "nis_per_channel": self.nis.mean,
            "nis_interval": [self.nis.lower, self.nis.upper] if tells else None,
            "nis_consistent": self.nis.consistent if tells else None,
            "used_fixes": self.used_fixes,
            "rejected_fixes": self.rejected_fixes,
            **self.certainty.figures(),
        }
        return {name: known(value) if isinstance(value, float) else value for name, value in figures.items()}

    def __repr__(self) -> str:
        """The sentence, and a headline figure a line: people read no radians."""
        return "\n".join([self.sentence(), *(f"  {name}: {text}" for name, text in self.headline().items())])

    def _common_figures(self) -> dict[str, str]:
        fixes = {
            "Mean NIS / channels": str(self.nis),
            "Fixes used, rejected": f"{self.used_fixes}, {self.rejected_fixes}",
        }
        untold = self.used_fixes is None or self.rejected_fixes is None
        return {**self.certainty.headline(), **({} if untold else fixes)}

    def _fix_cells(self) -> dict[str, str]:
        refused = "-" if self.rejected_fixes is None else str(self.rejected_fixes)
        return {"NIS /\nchan.": cell(self.nis.mean, 2), "refused": refused}


def is_fit(status: str | None) -> bool:
    """Whether the estimate of a filter with a status may be relied on."""
    return status is None or status in FIT


def known(value: float) -> float | None:
    """A figure for machines: None where it does not exist."""
    return value if math.isfinite(value) else None


def cell(value: float, digits: int) -> str:
    """A figure in a table."""
    return "-" if known(value) is None else f"{value:.{digits}f}"


def window(run: xr.Dataset) -> Window:
    """Start and stop of the evaluation of a run [s]."""
    return float(run.attrs["evaluation.start"]), float(run.attrs["evaluation.stop"])


def own_status_at_end(run: xr.Dataset) -> str | None:
    """Name of the status of the filter at the end; None of one that has none."""
    return status_at_end(run) if "status" in run else None


def status_at_end(run: xr.Dataset, name: str = "status") -> str:
    """Name of the status of the filter at the end, or of another variable of that kind."""
    status = run[name]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    return str(names[int(status.values[-1])])


def common(run: xr.Dataset) -> dict[str, Any]:
    """What every verdict says of a run: its fixes, and whether the filter was rightly sure."""
    rejected = None
    if "rejected_fixes" in run:
        rejected = int(run["rejected_fixes"].values[-1]) if run.sizes["fix"] else 0
    return {
        "nis": _nis(run),
        "used_fixes": int(run["fix_used"].values.sum()) if "fix_used" in run else None,
        "rejected_fixes": rejected,
        "certainty": certainty.of_run(run),
    }


def _nis(run: xr.Dataset) -> NisStatistics:
    if not tells_nis(run):
        return nis_statistics(np.empty(0), 0)
    counted = run["fix_used"].values & inside(run["fix_time"].values, *window(run))
    return nis_statistics(run["nis"].values[counted], is_measured(run)[counted].sum(axis=1))
