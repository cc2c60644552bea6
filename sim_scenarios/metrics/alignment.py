"""Verdict on an alignment: heading RMSE, convergence, consistency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import xarray as xr

from sim_scenarios.metrics.figures import over_evaluation
from sim_scenarios.metrics.verdict import Rmse, Verdict, cell, common, given, known
from sim_scenarios.units import ARCMIN


@dataclass(frozen=True, kw_only=True, repr=False)
class AlignmentVerdict(Verdict):
    """How well a filter aligned; SI units, None where a figure does not exist.

    `ok`: the RMSE of the heading over the evaluation window and its error at the end are within the limit,
    and the status of the end is one of `status.FIT`.

    Attributes
    ----------
    heading_rmse, heading_mean, heading_largest : float
        Over the evaluation window [rad].
    heading_end : float
        Heading error at the end [rad].
    heading_sigma : float
        RMS of the sigma that the filter claims over the window [rad]; NaN of one that claims none.
    convergence_time : float or None
        Time from which the heading error stays within the limit [s].
    claimed_time : float or None
        Time from which the filter itself reports "converged" until the end [s].
    bound : float or None
        RMS over the window of the posterior Cramer-Rao bound [rad]; a figure of many runs, not of this one.
    """

    heading_rmse: float
    heading_mean: float
    heading_largest: float
    heading_end: float
    heading_sigma: float
    convergence_time: float | None
    claimed_time: float | None
    bound: float | None

    @property
    def rmse(self) -> Rmse:
        """That of the heading."""
        return Rmse("heading [']", self.heading_rmse / ARCMIN)

    def sentence(self) -> str:
        """The verdict in a sentence."""
        rmse = f"heading RMSE {_arcmin(self.heading_rmse)}"
        if self.ok:
            since = f", within the limit since {self.convergence_time:.0f} s" if self.convergence_time else ""
            says_so = self.status in (None, "converged")
            what = "Converged" if says_so else f"Within the limit, but the filter is still {self.status}"
            return f"{what}: {rmse}{since}"
        if not self.fit:
            return f"Not converged: the filter is {self.status} at the end; {rmse}"
        return f"Not converged: {rmse}, {self.heading_end / ARCMIN:+.2f} arcmin at the end"

    def headline(self) -> dict[str, str]:
        """Headline figures of a run."""
        claimed = "never"
        if self.claimed_time is not None:
            claimed = f"since {self.claimed_time:.0f} s"
        elif self.certainty.sure > 0:
            claimed = f"not at the end, for {self.certainty.sure:.1f} s before"
        sigma = "none" if math.isnan(self.heading_sigma) else _arcmin(self.heading_sigma)
        return {
            "Heading RMSE of this run": _arcmin(self.heading_rmse),
            "Cramer-Rao bound": bound_in_words(self.bound),
            "Filter's own sigma": sigma,
            "Filter reports convergence": claimed,
            **self._common_figures(),
        }

    def row(self) -> dict[str, str]:
        """Figures of a line in a comparison."""
        since = f"{self.convergence_time:.0f} s" if self.ok and self.convergence_time is not None else "no"
        return {
            "RMSE\n[']": f"{self.heading_rmse / ARCMIN:.2f}",
            "/\nbound": f"{self.heading_rmse / self.bound:.2f}" if self.bound else "-",
            "largest\n[']": f"{self.heading_largest / ARCMIN:.2f}",
            "sigma\n[']": cell(self.heading_sigma / ARCMIN, 2),
            "in limit\nsince": since,
            **self._fix_cells(),
        }

    def figures(self) -> dict[str, Any]:
        """Figures for machines."""
        return {
            "converged": self.ok,
            "heading_rmse_arcmin": self.heading_rmse / ARCMIN,
            "heading_mean_arcmin": self.heading_mean / ARCMIN,
            "heading_largest_arcmin": self.heading_largest / ARCMIN,
            "heading_end_arcmin": self.heading_end / ARCMIN,
            "heading_sigma_arcmin": known(self.heading_sigma / ARCMIN),
            "bound_arcmin": None if self.bound is None else self.bound / ARCMIN,
            "convergence_time_s": self.convergence_time,
            "claimed_time_s": self.claimed_time,
            "reports_convergence": self.claimed_time is not None,
        }


def judge(run: xr.Dataset) -> AlignmentVerdict:
    """Verdict on the heading of one filter of a run (a data set of `sim_scenarios.run`)."""
    figure = over_evaluation(run)
    return AlignmentVerdict(
        heading_rmse=figure("heading_rmse"),
        heading_mean=figure("heading_mean"),
        heading_largest=figure("heading_largest"),
        heading_end=figure("heading_end"),
        heading_sigma=figure("heading_sigma_rms"),
        convergence_time=given(figure("convergence_time")),
        claimed_time=given(figure("claimed_time")),
        bound=run.attrs.get("bound.heading_rms"),
        **common(run),
    )


def bound_in_words(rms: float | None) -> str:
    """The bound of the heading [rad], and what it is a figure of."""
    return "none" if rms is None else f"{_arcmin(rms)} (RMS over many runs; one run may lie below)"


def _arcmin(angle: float) -> str:
    return f"{angle / ARCMIN:.2f} arcmin"
