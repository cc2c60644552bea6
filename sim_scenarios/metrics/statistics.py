"""Statistics of errors and of fixes that every verdict is made of.

A filter is consistent when its normalised innovations squared, NIS = v' S^-1 v, are chi-square with as many
degrees of freedom as a fix has channels; the sum of N of them is then chi-square with the sum of their
degrees of freedom. NEES = e' P^-1 e is the same of its errors; those of successive times are correlated, so
their mean has no such interval (Bar-Shalom, Li and Kirubarajan 2001, sec. 5.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtri

from sim_scenarios.attitude import wrap
from sim_scenarios.recording import under_way
from sim_scenarios.timeline import Window, inside

Array = NDArray[np.float64]

CONFIDENCE = 0.95


@dataclass(frozen=True)
class NisStatistics:
    """Mean NIS of a run against its chi-square interval.

    Attributes
    ----------
    mean : float
        Mean NIS for each channel; 1 for a consistent filter, NaN without a fix.
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

    def __str__(self) -> str:
        """The mean, with the interval to hold it against."""
        if self.count == 0:
            return "no fix was used"
        return f"{self.mean:.3f} ({self.lower:.2f} to {self.upper:.2f} is consistent)"


def rms(values: ArrayLike) -> float:
    """Root mean square of lengths: vectors lie along the last of two dimensions."""
    squares = np.square(np.asarray(values, dtype=float))
    return float(np.sqrt(np.mean(squares.sum(axis=-1) if squares.ndim > 1 else squares)))


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


def nis_statistics(nis: Array, channels: ArrayLike) -> NisStatistics:
    """Mean NIS for each channel, with the interval that a consistent filter keeps.

    Parameters
    ----------
    nis : ndarray, shape (n,)
        NIS of the fixes that were used.
    channels : int or ndarray, shape (n,)
        Channels of each fix.
    """
    count = len(nis)
    degrees = int(np.broadcast_to(channels, count).sum())
    if degrees == 0:
        return NisStatistics(float("nan"), 0.0, float("inf"), 0)
    lower, upper = chi_square_interval(degrees)
    return NisStatistics(float(np.sum(nis)) / degrees, lower / degrees, upper / degrees, count)


def nees(error: Array, covariance: Array) -> Array:
    """Normalised estimation error squared, divided by the number of states.

    Parameters
    ----------
    error : ndarray, shape (n, states)
        Estimated minus true.
    covariance : ndarray, shape (n, states, states)
        That the filter claims for these errors; positive definite.

    Returns
    -------
    ndarray, shape (n,)
        With mean 1 for a consistent filter.
    """
    normalised = np.linalg.solve(covariance, error[..., None])[..., 0]
    result: Array = np.sum(error * normalised, axis=-1) / error.shape[-1]
    return result


def nees_of(run: xr.Dataset) -> Array:
    """NEES for each state over time, of one filter that puts out its covariance.

    Of attitude and velocity, and of the sensor biases where the truth is known. The covariance is that of the
    states of the error models: misalignment and velocity error of the estimate, and the part of a bias that
    is left in the signals, which is the true bias minus the estimated one. Left out is what the model has no
    state for, which is correlated with nothing, and the gyro bias of the tight model, of which the covariance
    holds one of two parts only.

    Returns
    -------
    ndarray, shape (times,)
        NaN if there are no such states, of a filter that puts out no covariance, and before an alignment has
        handed over. The variable `nees` of a run that has it in place of the covariance.
    """
    if "nees" in run:
        known: Array = run["nees"].values
        return known
    found = np.full(run.sizes["time"], np.nan)
    part = under_way(run)
    if "covariance" in run and part.sizes["time"]:
        found[-part.sizes["time"] :] = _nees(part)
    return found


def _nees(run: xr.Dataset) -> Array:
    tight = "clock_bias_sigma" in run and bool(run["clock_bias_sigma"].values.any())
    names = ("accelerometer_bias",) if tight else ("gyro_bias", "accelerometer_bias")
    error = {"attitude": wrap(run["attitude_error"].values), "velocity": run["velocity_error"].values}
    error |= {
        name: run[f"truth.{name}"].values - run[name].values for name in names if f"truth.{name}" in run
    }
    first = {"attitude": 0, "velocity": 3, "gyro_bias": 6, "accelerometer_bias": 9}
    state = np.concatenate([np.arange(3) + first[name] for name in error])
    covariance = run["covariance"].values[:, state[:, None], state]
    off_diagonal = covariance * ~np.eye(len(state), dtype=bool)
    modelled = np.flatnonzero(off_diagonal.any(axis=(0, 1)))
    if not len(modelled):
        return np.full(len(covariance), np.nan)
    return nees(
        np.concatenate(list(error.values()), axis=-1)[:, modelled], covariance[:, modelled[:, None], modelled]
    )


def chi_square_interval(degrees_of_freedom: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Interval, with equal tails, that holds a chi-square variable with a given probability."""
    tail = (1 - confidence) / 2
    return float(chdtri(degrees_of_freedom, 1 - tail)), float(chdtri(degrees_of_freedom, tail))


def tells_nis(run: xr.Dataset) -> bool:
    """Whether a filter tells what each fix brought it."""
    return all(name in run for name in ("nis", "innovation_sigma", "fix_used"))


def sigma_of_heading(run: xr.Dataset) -> Array:
    """Sigma of the heading that one filter claims [rad], shape (times,); NaN of one that claims none."""
    if "heading_sigma" not in run:
        return np.full(run.sizes["time"], np.nan)
    sigma: Array = run["heading_sigma"].values
    return sigma


def reports_convergence(run: xr.Dataset) -> NDArray[np.bool_]:
    """Whether one filter reports convergence, shape (times,); one that cannot never does."""
    if "converged" not in run:
        return np.zeros(run.sizes["time"], dtype=bool)
    converged: NDArray[np.bool_] = run["converged"].values
    return converged


def nis_in(run: xr.Dataset, window: Window) -> tuple[Array, Array]:
    """NIS and channels of the fixes that a filter used in a window, shape (fixes,); none if it tells none."""
    if not tells_nis(run):
        return np.empty(0), np.empty(0)
    counted = run["fix_used"].values & inside(run["fix_time"].values, *window)
    return run["nis"].values[counted], is_measured(run)[counted].sum(axis=1)


def is_measured(run: xr.Dataset) -> NDArray[np.bool_]:
    """Which channels each fix measured, shape (fix, channel): those whose innovation has a sigma."""
    measured: NDArray[np.bool_] = run["innovation_sigma"].values > 0
    return measured


def measured_channels(run: xr.Dataset) -> NDArray[np.intp]:
    """Channels that the filter's model measures at any fix."""
    return np.flatnonzero(is_measured(run).any(axis=0))
