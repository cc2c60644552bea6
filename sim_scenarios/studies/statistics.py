"""What the runs of a campaign say together, with how sure it is.

Intervals are those of `metrics.folds`: of 95 %, over runs, which are independent, not over their instants.

After a fault a filter has recovered from the time on when, until the end, the error of each quantity is
within three sigmas and sigma within `RECOVERED` times that of the same filter without the fault on the same
seed. An error beyond three sigmas that, in sigmas, is within `RECOVERED` times that of the filter without
the fault at that time is due to the noise of the seed, and no want of recovery.

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
from numpy.typing import NDArray
from scipy.special import chdtri

from sim_scenarios.metrics.certainty import QUANTITIES, WRONG
from sim_scenarios.metrics.errors import that_counts
from sim_scenarios.metrics.figures import FIGURES, Figure, own
from sim_scenarios.metrics.folds import UNKNOWN, Estimate, order, share, time_share
from sim_scenarios.metrics.statistics import CONFIDENCE, chi_square_interval
from sim_scenarios.studies.plan import Plan
from sim_scenarios.studies.quantities import BOUNDED, ERRORS
from sim_scenarios.studies.store import State
from sim_scenarios.timeline import RESOLUTION

Array = NDArray[np.float64]

PERCENTILES: Final = (50.0, 90.0)
RECOVERED: Final = 1.5
"""How much more error and sigma than without its fault a filter may have that has recovered."""


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
        RMSE of the error that counts, by the bound.
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
    sure : float
        How long a run reports convergence, in the mean [s].
    wrongly_sure : Estimate
        Share of that time, of all runs, during which the error of any quantity is beyond `WRONG` sigmas.
    wrongly_sure_in : dict of str to Estimate
        The same by quantity; NaN where the filter has no sigma of it.
    longest_wrongly_sure : float
        The longest stretch of it in any run [s].
    recovered : Estimate
        Share of the runs whose fault ends that have recovered from it; NaN without such a run.
    recovery : tuple of float
        Median and 90th percentile of the time from the end of the fault to the recovery [s]; a run that does
        not recover, or stopped, counts as later than all others, and NaN as never.
    nis : Estimate
        Mean for each channel over the window of all runs; the interval is that of a consistent filter.
    nees : Estimate
        Mean of (heading error / sigma)^2 at the end of the window; interval of a consistent filter.
    nees_at : dict of float to Estimate
        The same at the instants that the campaign names [s]; NaN where nothing is kept, or the run is over.
    own : dict of str to Estimate
        Figures that other packages add, over the finished runs, by name.
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
    sure: float
    wrongly_sure: Estimate
    wrongly_sure_in: dict[str, Estimate]
    longest_wrongly_sure: float
    recovered: Estimate
    recovery: tuple[float, float]
    nis: Estimate
    nees: Estimate
    nees_at: dict[float, Estimate]
    own: dict[str, Estimate]
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
        Bound of each of `quantities.BOUNDED`, in SI units; NaN where there is none.
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


def summarise(data: xr.Dataset, plan: Plan | None = None) -> Iterator[CaseSummary]:
    """Every case of the results of a campaign (see `store`), one loaded at a time.

    `reference` and `instants` are those of a plan, without one of that with which the campaign began.
    """
    stored, about = json.loads(data.attrs["plan"]), json.loads(data.attrs["cases"])
    reference = plan.reference if plan else stored["reference"]
    instants = plan.instants if plan else stored.get("instants", ())
    for s, case in enumerate(about.values()):
        unfaulted = case.get("unfaulted")
        yield _case_summary(
            data.isel(scenario=s),
            None if unfaulted is None else data.isel(scenario=list(about).index(unfaulted)),
            case["attributes"],
            reference,
            instants,
        )


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
    """Mean over runs of (error / sigma)^2 over time, from the values of each run, shape (runs, times).

    It is infinite where an error is no number, and its sigma is one.
    """
    known = np.isfinite(sigma) & (sigma > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        nees = np.where(np.isfinite(error), (error / sigma) ** 2, np.inf)
    return consistency_course(np.where(known, nees, 0.0), known.astype(float))


def recovery_times(
    time: Array, fault_end: Array, faulted: Mapping[str, Array], unfaulted: Mapping[str, Array]
) -> Array:
    """Time from the end of the fault of each run until its filter has recovered.

    Parameters
    ----------
    time : ndarray, shape (times,)
        Up to the end of the runs [s].
    fault_end : ndarray, shape (runs,)
        [s]; NaN where no fault ends.
    faulted, unfaulted : mapping of str to ndarray, shape (runs, times)
        `heading_deviation`, `heading_sigma` and so on of the same filter, with the fault and without.

    Returns
    -------
    ndarray, shape (runs,)
        [s]; infinite where the filter does not recover, NaN where no fault ends in the run.
    """
    good = np.ones((len(fault_end), len(time)), dtype=bool)
    for name in QUANTITIES:
        (size, sigma), (size_without, sigma_without) = (
            (run[f"{name}_deviation"], run[f"{name}_sigma"]) for run in (faulted, unfaulted)
        )
        as_good = (size <= np.fmax(WRONG, RECOVERED * size_without)) & (sigma <= RECOVERED * sigma_without)
        good &= as_good | np.isnan(size_without)
    after = time >= fault_end[:, None]
    first = np.where(after & ~good, np.arange(1, len(time) + 1), 0).max(axis=1)  # from which all is good
    recovered = np.where(first > 0, np.append(time, np.inf)[first] - fault_end, 0.0)
    return np.where(after.any(axis=1), recovered, np.nan)


def _case_summary(
    case: xr.Dataset,
    unfaulted: xr.Dataset | None,
    attributes: Mapping[str, Any],
    reference: str | None,
    instants: Sequence[float],
) -> CaseSummary:
    counting = that_counts(attributes)
    figures = case.drop_dims("time").load()
    counted = figures["state"].isin([State.finished, State.failed]).any("run").values
    labels = [str(label) for label in case["filter"].values[counted]]
    base = reference if reference in labels else labels[0] if labels else ""
    errors = {name: _courses(case, labels, error_course, f"{name}_error") for name in ERRORS}
    nis = _courses(case, labels, consistency_course, "nis", "nis_channels")
    nees = _courses(case, labels, nees_course, "heading_error", "heading_sigma")
    recovery = _recoveries(case, unfaulted, labels, attributes["duration"])

    time = case["time"].values
    last = int(np.searchsorted(time, attributes["evaluation.stop"] + RESOLUTION)) - 1

    def nees_of(label: str, row: int) -> Estimate:
        return Estimate(*(float(values[row]) for values in vars(nees[label]).values()))

    def nees_at(label: str, instant: float) -> Estimate:
        row = int(np.argmin(np.abs(time - instant)))
        reached = instant <= attributes["duration"] + RESOLUTION
        return nees_of(label, row) if reached and abs(time[row] - instant) < RESOLUTION else UNKNOWN

    filters = {}
    for label in labels:
        one, other = figures.sel(filter=label), figures.sel(filter=base)
        filters[label] = Summary(
            **_of_runs(one, counting),
            ratio=_ratio(one, other, counting),
            **_of_recoveries(recovery[label]),
            nees=nees_of(label, last),
            nees_at={instant: nees_at(label, instant) for instant in instants},
            errors={name: courses[label] for name, courses in errors.items()},
            nis_course=nis[label],
            nees_course=nees[label],
        )
    return CaseSummary(
        label=str(case["scenario"].values),
        counting=counting,
        reference=base,
        filters=filters,
        time=time,
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
    claims = int((~np.isnan(deviation)).sum())  # infinite where an error is no number
    sure = one["sure_time"].values[finished]
    failed = one["success"].values[finished] != 1

    def folded(figure: Figure) -> Estimate:
        return figure.fold.estimate(one[figure.name].values[finished])

    return {
        "runs": runs,
        "stopped": stopped,
        "failures": FIGURES["success"].fold.estimate(np.append(failed, np.ones(stopped))),
        "rmse": {name: folded(FIGURES[f"{name}_rmse"]) for name in ERRORS},
        "to_bound": FIGURES[f"{counting}_rmse"].fold.estimate(each / float(one[f"{counting}_bound_rms"])),
        "convergence": (order(times, 0.5), order(times, 0.9)),
        "hand_over": (float(handed.min()), float(handed.max())) if len(handed) else (np.nan, np.nan),
        "wrong_claims": share(int((deviation > WRONG).sum()), claims),
        "claims": claims,
        "sure": folded(FIGURES["sure_time"]).value,
        "wrongly_sure": time_share(one["wrongly_sure_time"].values[finished], sure),
        "wrongly_sure_in": {
            name: time_share(one[f"wrongly_sure_{name}_time"].values[finished], sure) for name in QUANTITIES
        },
        "longest_wrongly_sure": float(np.max(one["longest_wrongly_sure"].values[finished], initial=0.0)),
        "nis": _consistency(one["nis_sum"].values[finished], one["nis_channels_sum"].values[finished]),
        "own": {name: folded(figure) for name, figure in own().items() if name in one},
        "each": each,
    }


def _ratio(one: xr.Dataset, other: xr.Dataset, counting: str) -> Estimate:
    both = ((one["state"] == State.finished) & (other["state"] == State.finished)).values
    ratio = FIGURES[f"{counting}_rmse"].fold.ratio
    assert ratio is not None
    return ratio(*(data[f"{counting}_rmse"].values[both] for data in (one, other)))


def _recoveries(
    case: xr.Dataset, unfaulted: xr.Dataset | None, labels: Sequence[str], duration: float
) -> dict[str, Array]:
    """Time to recover of every run of each filter, as `recovery_times` gives it; NaN without a fault.

    A run that stopped has not recovered; one that the filter does not finish without its fault tells nothing,
    nor does a filter without a sigma.
    """
    if unfaulted is None:
        return {label: np.full(case.sizes["run"], np.nan) for label in labels}
    rows = case["time"].values <= duration + RESOLUTION
    series = [f"{name}_{what}" for name in QUANTITIES for what in ("deviation", "sigma")]
    loaded = [data[[*series, "state"]].isel(time=rows).load() for data in (case, unfaulted)]
    end = case["fault_end"].values
    times = {}
    for label in labels:
        one, other = (data.sel(filter=label) for data in loaded)
        recovered = recovery_times(
            case["time"].values[rows],
            end,
            *({name: data[name].values for name in series} for data in (one, other)),
        )
        stopped = (one["state"].values == State.failed) & (end <= duration)
        recovered = np.where(stopped, np.inf, recovered)
        has_sigma = any(np.isfinite(other[f"{name}_sigma"].values).any() for name in QUANTITIES)
        known = (one["state"].values != State.missing) & (other["state"].values == State.finished) & has_sigma
        times[label] = np.where(known, recovered, np.nan)
    return times


def _of_recoveries(times: Array) -> dict[str, Any]:
    """What the times to recover of the runs of one filter say."""
    ordered = np.sort(times[~np.isnan(times)])
    return {
        "recovered": share(int(np.isfinite(ordered).sum()), len(ordered)),
        "recovery": (order(ordered, 0.5), order(ordered, 0.9)),
    }


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


def _consistency(total: Array, degrees: Array) -> Estimate:
    count = float(np.sum(degrees))
    if not count > 0:  # nor known
        return UNKNOWN
    lower, upper = chi_square_interval(int(count))
    return Estimate(float(np.sum(total)) / count, lower / count, upper / count)
