"""What an alignment handed over to navigation, and whether it did so in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from sim_scenarios.metrics.status import status_at_end
from sim_scenarios.recording import ALIGNMENT, HAND_OVER
from sim_scenarios.timeline import RESOLUTION
from sim_scenarios.units import ARCMIN


@dataclass(frozen=True)
class HandOver:
    """From alignment to navigation; SI units.

    Attributes
    ----------
    time : float or None
        First recorded time at which the filter navigates [s].
    aligned : float or None
        First recorded time at which the alignment reports convergence [s].
    due : float
        Start of the evaluation, by which the filter must navigate [s].
    heading_error, heading_sigma : float
        Of the alignment when it handed over; if it did not, at the end [rad].
    status : str
        Of the alignment at the end.
    """

    time: float | None
    aligned: float | None
    due: float
    heading_error: float
    heading_sigma: float
    status: str

    @property
    def in_time(self) -> bool:
        """Whether the filter navigates from the start of the evaluation on."""
        return self.time is not None and self.time <= self.due + RESOLUTION

    def failure(self) -> str:
        """Why there is nothing to evaluate, in a sentence."""
        if self.time is not None:
            late = f"at {self.time:.1f} s, after the evaluation began at {self.due:g} s"
            return f"the alignment handed over {late}"
        if self.aligned is not None:
            return f"the alignment converged at {self.aligned:.1f} s, but navigation did not take it over"
        sigma = f"{self.heading_sigma / ARCMIN:.2f} arcmin"
        return f"the alignment has not converged; it is {self.status} at the end, its heading sigma {sigma}"

    def headline(self) -> dict[str, str]:
        """Headline figures of a run."""
        when, then = ("never", "at the end") if self.time is None else (f"at {self.time:.1f} s", "then")
        error, sigma = self.heading_error / ARCMIN, self.heading_sigma / ARCMIN
        return {
            "Alignment handed over": when,
            f"Its heading error {then}": f"{error:+.2f} arcmin, sigma {sigma:.2f} arcmin",
        }

    def figures(self) -> dict[str, float | None]:
        """Figures for machines."""
        return {
            "hand_over_time_s": self.time,
            "hand_over_heading_error_arcmin": self.heading_error / ARCMIN,
            "hand_over_heading_sigma_arcmin": self.heading_sigma / ARCMIN,
        }


def of_run(run: xr.Dataset) -> HandOver | None:
    """Hand-over of one filter of a run; None of a run without an alignment before it."""
    if HAND_OVER not in run:
        return None
    time, start = run["time"].values, float(run[HAND_OVER])
    row = -1 if np.isnan(start) else int(np.searchsorted(time, start))
    converged = run[f"{ALIGNMENT}converged"].values
    return HandOver(
        time=None if np.isnan(start) else start,
        aligned=float(time[np.argmax(converged)]) if converged.any() else None,
        due=float(run.attrs["evaluation.start"]),
        heading_error=float(run[f"{ALIGNMENT}heading_error"].values[row]),
        heading_sigma=float(run[f"{ALIGNMENT}heading_sigma"].values[row]),
        status=status_at_end(run, f"{ALIGNMENT}status"),
    )
