"""How a figure of many runs is made of that of each, and how sure it is.

Confidence is 95 % everywhere. With r_k the RMSE of run k, the figure of N runs is the root of the mean of
r_k^2; its logarithm has, by the delta method, the standard error s / sqrt(N) with s the standard deviation of

    d_k = r_k^2 / (2 mean(r^2))

and Student's t with N - 1 degrees of freedom gives the interval. Two filters that saw the same seeds are
compared run by run: the logarithm of the ratio of their figures has the standard error of the differences of
their d_k, which is far smaller than either's where they fail and succeed on the same signals.

A share of the time of runs is a ratio of sums over them, p = sum(w_k) / sum(c_k). Instants depend on each
other within a run, not across runs, so its interval is that of Clopper and Pearson for as many independent
instants as give the variance that the ratio has over runs (Korn and Graubard 1998). Where no run ever is in
that share, or all are always, nothing tells how dependent instants are: each run counts as one instant, and
the interval is wide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv, ndtri, stdtrit

from sim_scenarios.metrics.statistics import CONFIDENCE, rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A figure with its interval of 95 %; NaN where it does not exist."""

    value: float
    lower: float
    upper: float

    def __truediv__(self, unit: float) -> Estimate:
        """The same in a unit."""
        return Estimate(self.value / unit, self.lower / unit, self.upper / unit)


UNKNOWN: Final = Estimate(np.nan, np.nan, np.nan)


def root_mean_square(values: ArrayLike) -> Estimate:
    """Root mean square of the RMSE of independent runs, with its interval."""
    r = np.asarray(values, dtype=float)
    return _log_interval(rms(r), _influence(r)) if len(r) else UNKNOWN


def paired_ratio(values: ArrayLike, reference: ArrayLike) -> Estimate:
    """Ratio of the root mean squares of two filters over the same runs, with its interval."""
    a, b = np.asarray(values, dtype=float), np.asarray(reference, dtype=float)
    if len(a) == 0 or not np.any(b):
        return UNKNOWN
    value = float(np.sqrt(np.mean(a**2) / np.mean(b**2)))
    return _log_interval(value, _influence(a) - _influence(b))


def mean_of(values: ArrayLike) -> Estimate:
    """Mean of a figure of independent runs with its interval: of its logarithm, if it is never negative."""
    r = np.asarray(values, dtype=float)
    if not np.any(r):
        return UNKNOWN
    mean = float(np.mean(r))
    if np.all(r >= 0):
        return _log_interval(mean, r / mean)
    reach = _reach(r)
    return Estimate(mean, mean - reach, mean + reach)


def ratio_of_means(values: ArrayLike, reference: ArrayLike) -> Estimate:
    """Ratio of the means of a figure of two filters over the same runs, with its interval; never negative."""
    a, b = np.asarray(values, dtype=float), np.asarray(reference, dtype=float)
    if not (np.any(a) and np.any(b) and np.all(a >= 0) and np.all(b >= 0)):
        return UNKNOWN
    return _log_interval(float(np.mean(a) / np.mean(b)), a / np.mean(a) - b / np.mean(b))


def share(events: int, count: int) -> Estimate:
    """Share of events with the interval of Clopper and Pearson, quantiles of beta distributions."""
    return _clopper_pearson(events, count) if count else UNKNOWN


def time_share(part: ArrayLike, whole: ArrayLike) -> Estimate:
    """Share of the time of independent runs, from both times of each, with its interval."""
    w, c = np.asarray(part, dtype=float), np.asarray(whole, dtype=float)
    w, c = w[c > 0], c[c > 0]
    runs = len(c)
    if runs == 0 or np.isnan(w).any():
        return UNKNOWN
    share = float(w.sum() / c.sum())
    if runs == 1:
        return Estimate(share, np.nan, np.nan)
    variance = np.var((w - share * c) / c.mean(), ddof=1) / runs
    if variance == 0:
        return _clopper_pearson(share * runs, runs)
    few = ndtri((1 + CONFIDENCE) / 2) / stdtrit(runs - 1, (1 + CONFIDENCE) / 2)
    instants = share * (1 - share) / float(variance) * few**2
    return _clopper_pearson(share * instants, instants)


def order(values: ArrayLike, share: float) -> float:
    """Smallest value that at least a share of all values do not exceed; NaN if it is infinite, or of none."""
    ascending = np.sort(np.asarray(values, dtype=float))
    if len(ascending) == 0:
        return float("nan")
    value = float(ascending[int(np.ceil(share * len(ascending))) - 1])
    return value if np.isfinite(value) else float("nan")


def _median(values: Array) -> float:
    return float(np.median(np.where(np.isnan(values), np.inf, values)))  # NaN is never


def _mean(values: Array) -> float:
    return float(np.mean(values))


def _count(values: Array) -> float:
    return float(np.sum(values))


def _last(values: Array) -> float:
    return float(np.max(values))


def _share(values: ArrayLike) -> Estimate:
    events = np.equal(values, 1)
    return share(int(np.sum(events)), len(events))


@dataclass(frozen=True)
class Fold:
    """How the figure of many runs is made of that of each, shape (runs,), of at least one run.

    Attributes
    ----------
    name : str
    value : callable or None
        The figure of all runs; None where those of each do not make it.
    interval : callable or None
        The same with its interval, where one is known.
    ratio : callable or None
        Of two filters over the same runs, with its interval.
    """

    name: str
    value: Callable[[Array], float] | None
    interval: Callable[[ArrayLike], Estimate] | None = None
    ratio: Callable[[ArrayLike, ArrayLike], Estimate] | None = None

    def estimate(self, values: ArrayLike) -> Estimate:
        """The figure of all runs, with its interval where one is known; NaN without runs, or `value`."""
        each = np.asarray(values, dtype=float)
        if len(each) == 0 or self.value is None:
            return UNKNOWN
        if self.interval is None:
            return Estimate(self.value(each), np.nan, np.nan)
        known = self.interval(each)
        return Estimate(self.value(each), known.lower, known.upper)


RMS: Final = Fold("root mean square", rms, root_mean_square, paired_ratio)
MEAN: Final = Fold("mean", _mean, mean_of, ratio_of_means)
MEDIAN: Final = Fold("median", _median)
SHARE: Final = Fold("share", _mean, _share)
COUNT: Final = Fold("count", _count)
LAST: Final = Fold("last", _last)
"""The largest, of times the last."""
OF_ERRORS: Final = Fold("of the root mean square of the errors at each instant", None)
OF_SUMS: Final = Fold("ratio of the sums of its parts", None)


def _influence(r: Array) -> Array:
    """Influence of each run on the logarithm of the root mean square, d_k."""
    square = np.mean(r**2)
    return r**2 / (2 * square) if square > 0 else np.zeros(len(r))


def _log_interval(value: float, influence: Array) -> Estimate:
    factor = float(np.exp(_reach(influence)))
    return Estimate(value, value / factor, value * factor)


def _reach(values: Array) -> float:
    """Half the interval of the mean of independent values, by Student's t; NaN of a single one."""
    count = len(values)
    if count < 2:
        return np.nan
    error = np.std(values, ddof=1) / np.sqrt(count)
    return float(stdtrit(count - 1, (1 + CONFIDENCE) / 2) * error)


def _clopper_pearson(events: float, count: float) -> Estimate:
    """Share of events, whose numbers may be effective ones."""
    tail = (1 - CONFIDENCE) / 2
    lower = betaincinv(events, count - events + 1, tail) if events > 0 else 0.0
    upper = betaincinv(events + 1, count - events, 1 - tail) if events < count else 1.0
    return Estimate(events / count, float(lower), float(upper))
