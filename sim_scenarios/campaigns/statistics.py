"""What the runs of a campaign say together, with how sure it is.

Confidence is 95 % everywhere. With r_k the RMSE of run k, the figure of N runs is the root of the mean of
r_k^2; its logarithm has, by the delta method, the standard error s / sqrt(N) with s the standard deviation of

    d_k = r_k^2 / (2 mean(r^2))

and Student's t with N - 1 degrees of freedom gives the interval. Two filters that saw the same seeds are
compared run by run: the logarithm of the ratio of their figures has the standard error of the differences of
their d_k, which is far smaller than either's where they fail and succeed on the same signals.

Sums of NIS and of NEES over independent runs are chi-square with the sum of their degrees of freedom
(Bar-Shalom, Li and Kirubarajan 2001, sec. 5.4).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincinv, chdtri, stdtrit

from sim_scenarios.campaigns.quantities import BOUNDED, ERRORS, that_counts
from sim_scenarios.campaigns.store import State
from sim_scenarios.metrics.statistics import CONFIDENCE, chi_square_interval

Array = NDArray[np.float64]

PERCENTILES: Final = (50.0, 90.0)
WRONG: Final = 3.0
"""Sigmas of the heading error beyond which a report of convergence was wrong."""


@dataclass(frozen=True)
class Estimate:
    """A figure with its interval of 95 %; NaN where it does not exist."""

    value: float
    lower: float
    upper: float

    def __truediv__(self, unit: float) -> Estimate:
        """The same in a unit."""
        return Estimate(self.value / unit, self.lower / unit, self.upper / unit)


@dataclass(frozen=True)
class Course:
    """How an error or its consistency goes over time, over the finished runs.

    Attributes
    ----------
    middle : ndarray, shape (times,)
        Root mean square of an error; mean of NIS or NEES for each degree of freedom.
    lower, upper : ndarray, shape (times,)
        50th and 90th percentile of the size of an error; interval of a consistent filter.
    """

    middle: Array
    lower: Array
    upper: Array


@dataclass(frozen=True)
class Summary:
    """One filter in one case.

    Attributes
    ----------
    runs : int
        Those that count: finished or failed.
    failures : Estimate
        Share of the runs that stopped with an error or whose verdict is not good (Clopper-Pearson).
    stopped : int
        Runs that stopped with an error, or had no start by the window.
    rmse : dict of str to Estimate
        Over window and finished runs, by quantity of `quantities.ERRORS`.
    to_bound : Estimate
        RMSE of the error that counts, by the Cramer-Rao bound.
    ratio : Estimate
        The same by that of the reference filter of the case on the same seeds.
    convergence : tuple of float
        Median and 90th percentile of the time from which the error that counts stays within its limit [s]; a
        run that never does, or stopped, counts as later than all others, and NaN as never.
    hand_over : tuple of float
        First and last time at which an alignment handed over to the filter [s]; NaN where there is none.
    wrong_claims : Estimate
        Share of the runs that report convergence whose heading error is then beyond `WRONG` sigmas.
    claims : int
        Runs that ever report convergence.
    nis : Estimate
        Mean for each channel over the window of all runs; the interval is that of a consistent filter.
    nees : Estimate
        Mean of (heading error / sigma)^2 at the end of the window; interval of a consistent filter.
    each : ndarray, shape (finished,)
        RMSE of the error that counts of every finished run, in SI units.
    errors : dict of str to Course
        By quantity.
    nis_course, nees_course : Course
    """

    runs: int
    failures: Estimate
    stopped: int
    rmse: dict[str, Estimate]
    to_bound: Estimate
    ratio: Estimate
    convergence: tuple[float, float]
    hand_over: tuple[float, float]
    wrong_claims: Estimate
    claims: int
    nis: Estimate
    nees: Estimate
    each: Array
    errors: dict[str, Course]
    nis_course: Course
    nees_course: Course


@dataclass(frozen=True)
class CaseSummary:
    """All filters of one case.

    Attributes
    ----------
    label : str
    counting : str
        The error that the filters are judged by, of `quantities.ERRORS`.
    reference : str
        Filter that the others are compared with.
    filters : dict of str to Summary
    time : ndarray, shape (times,)
        Of the courses [s].
    bounds : dict of str to ndarray, shape (times,)
        Cramer-Rao bound of each of `quantities.BOUNDED`, in SI units; NaN where there is none.
    bound_rms : float
        Of the error that counts over the window; NaN where there is none.
    """

    label: str
    counting: str
    reference: str
    filters: dict[str, Summary]
    time: Array
    bounds: dict[str, Array]
    bound_rms: float


def summarise(data: xr.Dataset) -> Iterator[CaseSummary]:
    """Every case of the results of a campaign (see `store`), one loaded at a time."""
    reference = json.loads(data.attrs["plan"])["reference"]
    for s, about in enumerate(json.loads(data.attrs["cases"]).values()):
        yield _case_summary(data.isel(scenario=s), about["attributes"], reference)


def root_mean_square(values: ArrayLike) -> Estimate:
    """Root mean square of the RMSE of independent runs, with its interval."""
    r = np.asarray(values, dtype=float)
    if len(r) == 0:
        return _unknown()
    value = float(np.sqrt(np.mean(r**2)))
    return _log_interval(value, _influence(r))


def paired_ratio(values: ArrayLike, reference: ArrayLike) -> Estimate:
    """Ratio of the root mean squares of two filters over the same runs, with its interval."""
    a, b = np.asarray(values, dtype=float), np.asarray(reference, dtype=float)
    if len(a) == 0 or not np.any(b):
        return _unknown()
    value = float(np.sqrt(np.mean(a**2) / np.mean(b**2)))
    return _log_interval(value, _influence(a) - _influence(b))


def mean_of(values: ArrayLike) -> Estimate:
    """Mean of a figure of independent runs that is never negative, with its interval."""
    r = np.asarray(values, dtype=float)
    return _log_interval(float(np.mean(r)), r / np.mean(r)) if np.any(r) else _unknown()


def ratio_of_means(values: ArrayLike, reference: ArrayLike) -> Estimate:
    """Ratio of the means of such a figure of two filters over the same runs, with its interval."""
    a, b = np.asarray(values, dtype=float), np.asarray(reference, dtype=float)
    if not (np.any(a) and np.any(b)):
        return _unknown()
    return _log_interval(float(np.mean(a) / np.mean(b)), a / np.mean(a) - b / np.mean(b))


def share(events: int, count: int) -> Estimate:
    """Share of events with the interval of Clopper and Pearson, quantiles of beta distributions."""
    if count == 0:
        return _unknown()
    tail = (1 - CONFIDENCE) / 2
    lower = betaincinv(events, count - events + 1, tail) if events > 0 else 0.0
    upper = betaincinv(events + 1, count - events, 1 - tail) if events < count else 1.0
    return Estimate(events / count, float(lower), float(upper))


def error_course(error: Array) -> Course:
    """Size of an error over time, from its values of each run, shape (runs, times)."""
    size = np.abs(error)
    middle = np.sqrt(np.mean(size**2, axis=0))
    lower, upper = np.percentile(size, PERCENTILES, axis=0)
    return Course(middle, lower, upper)


def consistency_course(total: Array, degrees: Array) -> Course:
    """Mean of chi-square variables for each degree of freedom over time; shapes (runs, times)."""
    count = np.sum(degrees, axis=0)
    known = np.where(count > 0, count, np.nan)
    tail = (1 - CONFIDENCE) / 2
    lower, upper = (chdtri(known, p) / known for p in (1 - tail, tail))
    return Course(np.sum(total, axis=0) / known, lower, upper)


def nees_course(error: Array, sigma: Array) -> Course:
    """Mean over runs of (error / sigma)^2 over time, from the values of each run, shape (runs, times)."""
    nees = (error / sigma) ** 2
    known = np.isfinite(nees)
    return consistency_course(np.where(known, nees, 0.0), known.astype(float))


def _case_summary(case: xr.Dataset, attributes: Mapping[str, Any], reference: str | None) -> CaseSummary:
    counting = that_counts(attributes)
    figures = case.drop_dims("time").load()
    counted = figures["state"].isin([State.finished, State.failed]).any("run").values
    labels = [str(label) for label in case["filter"].values[counted]]
    base = reference if reference in labels else labels[0] if labels else ""
    errors = {name: _courses(case, labels, error_course, f"{name}_error") for name in ERRORS}
    nis = _courses(case, labels, consistency_course, "nis", "nis_channels")
    nees = _courses(case, labels, nees_course, "heading_error", "heading_sigma")
    at_stop = int(np.searchsorted(case["time"].values, attributes["evaluation.stop"] + 1e-6)) - 1
    filters = {}
    for label in labels:
        one, other = figures.sel(filter=label), figures.sel(filter=base)
        filters[label] = Summary(
            **_of_runs(one, counting),
            ratio=_ratio(one, other, counting),
            nees=Estimate(*(float(values[at_stop]) for values in vars(nees[label]).values())),
            errors={name: courses[label] for name, courses in errors.items()},
            nis_course=nis[label],
            nees_course=nees[label],
        )
    return CaseSummary(
        label=str(case["scenario"].values),
        counting=counting,
        reference=base,
        filters=filters,
        time=case["time"].values,
        bounds={name: case[f"{name}_bound"].values for name in BOUNDED},
        bound_rms=float(case[f"{counting}_bound_rms"]),
    )


def _of_runs(one: xr.Dataset, counting: str) -> dict[str, Any]:
    """What the figures of the runs of one filter say."""
    state = one["state"].values
    finished, stopped = state == State.finished, int((state == State.failed).sum())
    runs = int(finished.sum()) + stopped
    each = one[f"{counting}_rmse"].values[finished]
    handed = one["hand_over_time"].values[finished]
    settled = np.nan_to_num(one["convergence_time"].values[finished], nan=np.inf)
    times = np.sort(np.append(settled, np.full(stopped, np.inf)))
    deviation = one["claimed_deviation"].values[finished]
    claims = int(np.isfinite(deviation).sum())
    return {
        "runs": runs,
        "stopped": stopped,
        "failures": share(runs - int((one["success"].values[finished] == 1).sum()), runs),
        "rmse": {name: root_mean_square(one[f"{name}_rmse"].values[finished]) for name in ERRORS},
        "to_bound": root_mean_square(each / float(one[f"{counting}_bound_rms"])),
        "convergence": (_order(times, 0.5), _order(times, 0.9)),
        "hand_over": (float(handed.min()), float(handed.max())) if len(handed) else (np.nan, np.nan),
        "wrong_claims": share(int((deviation > WRONG).sum()), claims),
        "claims": claims,
        "nis": _consistency(one["nis_sum"].values[finished], one["nis_channels_sum"].values[finished]),
        "each": each,
    }


def _ratio(one: xr.Dataset, other: xr.Dataset, counting: str) -> Estimate:
    both = ((one["state"] == State.finished) & (other["state"] == State.finished)).values
    return paired_ratio(*(data[f"{counting}_rmse"].values[both] for data in (one, other)))


def _courses(
    case: xr.Dataset, labels: Sequence[str], make: Callable[..., Course], *names: str
) -> dict[str, Course]:
    """Course of each filter from series of its finished runs."""
    arrays = [case[name].sel(filter=labels).values for name in names]
    finished = case["state"].sel(filter=labels).values == State.finished
    nothing = np.full(case.sizes["time"], np.nan)
    return {
        label: make(*(array[f][finished[f]] for array in arrays))
        if finished[f].any()
        else Course(nothing, nothing, nothing)
        for f, label in enumerate(labels)
    }


def _unknown() -> Estimate:
    return Estimate(np.nan, np.nan, np.nan)


def _influence(r: Array) -> Array:
    """Influence of each run on the logarithm of the root mean square, d_k."""
    square = np.mean(r**2)
    return r**2 / (2 * square) if square > 0 else np.zeros(len(r))


def _log_interval(value: float, influence: Array) -> Estimate:
    count = len(influence)
    if count < 2:
        return Estimate(value, np.nan, np.nan)
    error = np.std(influence, ddof=1) / np.sqrt(count)
    reach = float(np.exp(stdtrit(count - 1, (1 + CONFIDENCE) / 2) * error))
    return Estimate(value, value / reach, value * reach)


def _order(ascending: Array, share: float) -> float:
    """Smallest value that at least a share of all values do not exceed; NaN if it is infinite."""
    if len(ascending) == 0:
        return float("nan")
    value = float(ascending[int(np.ceil(share * len(ascending))) - 1])
    return value if np.isfinite(value) else float("nan")


def _consistency(total: Array, degrees: Array) -> Estimate:
    count = float(np.sum(degrees))
    if count == 0:
        return _unknown()
    lower, upper = chi_square_interval(int(count))
    return Estimate(float(np.sum(total)) / count, lower / count, upper / count)
