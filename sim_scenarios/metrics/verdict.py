"""What every verdict on a run has in common, whatever the filter was for."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import xarray as xr

from sim_scenarios.metrics.certainty import Certainty
from sim_scenarios.metrics.figures import certainty_of, over_evaluation, own, window
from sim_scenarios.metrics.statistics import NisStatistics, nis_in, nis_statistics
from sim_scenarios.metrics.status import is_fit, own_status_at_end


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
    own : mapping of str to float
        Figures that other packages add (`figures.own`), by name; SI units.
    """

    ok: bool
    status: str | None
    certainty: Certainty
    nis: NisStatistics
    used_fixes: int | None
    rejected_fixes: int | None
    own: Mapping[str, float] = field(default_factory=dict)

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
        if self.own:
            units = {name: own()[name].unit for name in self.own}
            figures["figures"] = {
                name: {"value": known(value), "unit": units[name]} for name, value in self.own.items()
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
        return {**self.certainty.headline(), **({} if untold else fixes), **self._own_figures()}

    def _own_figures(self) -> dict[str, str]:
        """Those of other packages as people read them, by title."""
        return {own()[name].title: own()[name].text(value) for name, value in self.own.items()}

    def _fix_cells(self) -> dict[str, str]:
        refused = "-" if self.rejected_fixes is None else str(self.rejected_fixes)
        return {"NIS /\nchan.": cell(self.nis.mean, 2), "refused": refused}


def known(value: float) -> float | None:
    """A figure for machines: None where it does not exist."""
    return value if math.isfinite(value) else None


def given(value: float) -> float | None:
    """A figure; None where there is none."""
    return None if math.isnan(value) else value


def cell(value: float, digits: int) -> str:
    """A figure in a table."""
    return "-" if known(value) is None else f"{value:.{digits}f}"


def common(run: xr.Dataset) -> dict[str, Any]:
    """What every verdict says of a run: its status, its fixes, and whether the filter was rightly sure."""
    figure = over_evaluation(run)
    used, rejected = (given(figure(f"{what}_fixes")) for what in ("used", "rejected"))
    return {
        "ok": bool(figure("success")),
        "status": own_status_at_end(run),
        "nis": nis_statistics(*nis_in(run, window(run))),
        "used_fixes": None if used is None else int(used),
        "rejected_fixes": None if rejected is None else int(rejected),
        "certainty": certainty_of(run),
        "own": {one.name: figure(one.name) for one in own().values()},
    }
