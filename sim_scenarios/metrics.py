"""What a run was worth: heading RMSE, convergence, consistency, and one verdict.

The heading error wraps only here, where it is evaluated. A filter is consistent when its normalised
innovations squared, NIS = v' S^-1 v, are chi-square with as many degrees of freedom as a fix has channels;
the mean of N of them times N is chi-square with N m degrees of freedom (Bar-Shalom, Li and Kirubarajan 2001,
sec. 5.4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import chdtri

from sim_scenarios.attitude import wrap
from sim_scenarios.units import ARCMIN

Array = NDArray[np.float64]

CONFIDENCE = 0.95


@dataclass(frozen=True)
class NisStatistics:
    """Mean NIS of a run against its chi-square interval.

    Attributes
    ----------
    mean : float
        Mean NIS for each channel; 1 for a consistent filter.
    lower, upper : float
        Interval that holds the mean of a consistent filter with 95 % probability.
    count : int
        Fixes that count.
    """

    mean: float
    lower: float
    upper: float
    count: int

    @property
    def consistent(self) -> bool:
        """Whether the mean lies in the interval."""
        return self.lower <= self.mean <= self.upper


@dataclass(frozen=True)
class Verdict:
    """How well a filter aligned; SI units, None where a figure does not exist.

    Attributes
    ----------
    converged : bool
        The RMSE of the heading over the evaluation window and its error at the end are within the limit.
    heading_rmse, heading_mean, heading_largest : float
        Over the evaluation window [rad].
    heading_end : float
        Heading error at the end [rad].
    heading_sigma : float
        RMS of the sigma that the filter claims over the window [rad].
    convergence_time : float or None
        Time from which the heading error stays within the limit [s].
    claimed_time : float or None
        Time from which the filter itself reports "converged" until the end [s].
    bound : float
        RMS over the window of the posterior Cramer-Rao bound [rad].
    nis : NisStatistics
        Over the fixes that the filter used in the window.
    used_fixes, rejected_fixes : int
    """

    converged: bool
    heading_rmse: float
    heading_mean: float
    heading_largest: float
    heading_end: float
    heading_sigma: float
    convergence_time: float | None
    claimed_time: float | None
    bound: float
    nis: NisStatistics
    used_fixes: int
    rejected_fixes: int

    def to_json(self) -> dict[str, Any]:
        """Figures under names that end in their unit, for machines."""
        return {
            "converged": self.converged,
            "heading_rmse_arcmin": self.heading_rmse / ARCMIN,
            "heading_mean_arcmin": self.heading_mean / ARCMIN,
            "heading_largest_arcmin": self.heading_largest / ARCMIN,
            "heading_end_arcmin": self.heading_end / ARCMIN,
            "heading_sigma_arcmin": self.heading_sigma / ARCMIN,
            "bound_arcmin": self.bound / ARCMIN,
            "convergence_time_s": self.convergence_time,
            "claimed_time_s": self.claimed_time,
            "nis_per_channel": self.nis.mean,
            "nis_interval": [self.nis.lower, self.nis.upper],
            "nis_consistent": self.nis.consistent,
            "used_fixes": self.used_fixes,
            "rejected_fixes": self.rejected_fixes,
        }


def heading_rmse(time: Array, error: Array, start: float, stop: float) -> float:
    """Root mean square of a heading error, wrapped, over start..stop.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s]
    error : ndarray, shape (n,)
        [rad]
    start, stop : float
        Window, ends included [s].

    Returns
    -------
    float
        [rad]
    """
    return float(np.sqrt(np.mean(wrap(_window(time, error, start, stop)) ** 2)))


def holds_since(time: Array, condition: NDArray[np.bool_]) -> float | None:
    """Time from which a condition holds until the end; None if it does not hold there.

    Parameters
    ----------
    time : ndarray, shape (n,)
        [s]
    condition : ndarray of bool, shape (n,)
        Whether it holds at each time.

    Returns
    -------
    float or None
        [s]
    """
    broken = np.flatnonzero(~condition)
    first = broken[-1] + 1 if len(broken) else 0
    return float(time[first]) if first < len(time) else None


def nis_statistics(nis: Array, channels: int) -> NisStatistics:
    """Mean NIS for each channel, with the interval that a consistent filter keeps.

    Parameters
    ----------
    nis : ndarray, shape (n,)
        NIS of the fixes that were used.
    channels : int
        Channels of a fix.
    """
    count = len(nis)
    if count == 0:
        return NisStatistics(float("nan"), 0.0, float("inf"), 0)
    lower, upper = chi_square_interval(count * channels)
    return NisStatistics(
        float(np.mean(nis)) / channels, lower / (count * channels), upper / (count * channels), count
    )


def chi_square_interval(degrees_of_freedom: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Interval, with equal tails, that holds a chi-square variable with a given probability."""
    tail = (1 - confidence) / 2
    return float(chdtri(degrees_of_freedom, 1 - tail)), float(chdtri(degrees_of_freedom, tail))


def measured_channels(run: xr.Dataset) -> NDArray[np.intp]:
    """Channels of the innovation that the filter's model measures: those with a sigma, at any fix."""
    return np.flatnonzero((run["innovation_sigma"].values > 0).any(axis=0))


def judge(run: xr.Dataset) -> Verdict:
    """Verdict on the run of one filter (a data set of `sim_scenarios.run`)."""
    start, stop, limit = (float(run.attrs[f"evaluation.{key}"]) for key in ("start", "stop", "heading_limit"))
    time, error = run["time"].values, wrap(run["heading_error"].values)
    inside = _window(time, error, start, stop)
    rmse = heading_rmse(time, error, start, stop)
    used = run["fix_used"].values & (run["fix_time"].values >= start) & (run["fix_time"].values <= stop)
    return Verdict(
        converged=bool(rmse <= limit and abs(error[-1]) <= limit),
        heading_rmse=rmse,
        heading_mean=float(np.mean(inside)),
        heading_largest=float(np.max(np.abs(inside))),
        heading_end=float(error[-1]),
        heading_sigma=float(np.sqrt(np.mean(_window(time, run["heading_sigma"].values, start, stop) ** 2))),
        convergence_time=holds_since(time, np.abs(error) <= limit),
        claimed_time=holds_since(time, run["converged"].values),
        bound=float(run.attrs["bound.heading_rms"]),
        nis=nis_statistics(run["nis"].values[used], len(measured_channels(run))),
        used_fixes=int(run["fix_used"].sum()),
        rejected_fixes=int(run["rejected_fixes"].values[-1]) if run.sizes["fix"] else 0,
    )


def _window(time: Array, values: Array, start: float, stop: float) -> Array:
    inside = values[(time >= start) & (time <= stop)]
    if len(inside) == 0:
        raise ValueError(f"nothing is recorded between {start:g} s and {stop:g} s")
    return inside
