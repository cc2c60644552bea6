"""The figures that come with the package, by name: errors, times, certainty, fixes, and those of papers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.metrics import certainty, hand_over
from sim_scenarios.metrics.certainty import QUANTITIES, Certainty
from sim_scenarios.metrics.errors import ERRORS, that_counts
from sim_scenarios.metrics.figures.definition import Figure, Of
from sim_scenarios.metrics.folds import COUNT, LAST, MEAN, MEDIAN, OF_ERRORS, OF_SUMS, RMS, SHARE
from sim_scenarios.metrics.statistics import (
    holds_since,
    nees_of,
    nis_in,
    nis_statistics,
    reports_convergence,
    rms,
    sigma_of_heading,
    tells_nis,
)
from sim_scenarios.metrics.status import is_fit, own_status_at_end
from sim_scenarios.timeline import Window, within

Array = NDArray[np.float64]

OUTPUTS: Final = (
    *(f"nav.{name}" for name in ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity")),
    *(f"{name}_sigma" for name in QUANTITIES),
    "status",
    "converged",
    "innovation_sigma",
    "nis",
    "used_fixes",
    "rejected_fixes",
)
"""Outputs of a filter that every figure may be made of, where the filter has them."""
COVARIANCE: Final = ("covariance", "gyro_bias", "accelerometer_bias", "clock_bias_sigma")
"""Outputs that the NEES is made of besides."""


def certainty_of(run: xr.Dataset) -> Certainty:
    """Certainty of a run since an alignment handed over in time; of the whole run otherwise."""
    handed = hand_over.of_run(run)
    return certainty.of_run(run if handed is None or not handed.in_time else recording.under_way(run))


def _held(run: xr.Dataset, values: Array, span: Window) -> Array:
    return within(run["time"].values, values, *span)


def _rmse(name: str) -> Of:
    error = ERRORS[name]
    return lambda run, span: rms(_held(run, error.of(run), span))


def _at_end(name: str) -> Of:
    error = ERRORS[name]
    return lambda run, span: float(abs(_held(run, error.size(run), span)[-1]))


def _largest(name: str) -> Of:
    error = ERRORS[name]
    return lambda run, span: float(np.max(np.abs(_held(run, error.of(run), span))))


def _heading_mean(run: xr.Dataset, span: Window) -> float:
    return float(np.mean(_held(run, ERRORS["heading"].of(run), span)))


def _heading_end(run: xr.Dataset, _: Window) -> float:
    return float(ERRORS["heading"].of(run)[-1])


def _heading_sigma(run: xr.Dataset, span: Window) -> float:
    return rms(_held(run, sigma_of_heading(run), span))


def _horizontal_sigma(run: xr.Dataset, span: Window) -> float:
    if "position_sigma" not in run:
        return np.nan
    return rms(_held(run, run["position_sigma"].values[:, :2], span))


def _limit(run: xr.Dataset, name: str) -> float:
    return float(run.attrs[f"evaluation.{name}_limit"])


def _within_limit_since(run: xr.Dataset, name: str) -> float | None:
    return holds_since(run["time"].values, np.abs(ERRORS[name].size(run)) <= _limit(run, name))


def _convergence_time(run: xr.Dataset, _: Window) -> float:
    return _or_nan(_within_limit_since(run, that_counts(run.attrs)))


def _settling(run: xr.Dataset, _: Window) -> float:
    since = _within_limit_since(run, "heading")
    return np.inf if since is None else since


def _failed(run: xr.Dataset, span: Window) -> float:
    return float(_rmse("heading")(run, span) > 2 * _limit(run, "heading"))


def _success(run: xr.Dataset, span: Window) -> float:
    counting, fit = that_counts(run.attrs), is_fit(own_status_at_end(run))
    good = fit and _rmse(counting)(run, span) <= _limit(run, counting)
    if counting == "heading":
        return float(good and abs(_heading_end(run, span)) <= _limit(run, counting))
    handed = hand_over.of_run(run)
    return float(good and (handed is None or handed.in_time))


def _hand_over_time(run: xr.Dataset, _: Window) -> float:
    handed = hand_over.of_run(run)
    return _or_nan(None if handed is None else handed.time)


def _claimed_time(run: xr.Dataset, _: Window) -> float:
    return _or_nan(holds_since(run["time"].values, reports_convergence(run)))


def _claimed(fold: Callable[[Array], float]) -> Of:
    """Of the heading errors in sigmas while convergence is reported, of which there are some."""

    def of(run: xr.Dataset, _: Window) -> float:
        deviation = certainty.deviations(run).get("heading", np.full(run.sizes["time"], np.nan))
        claimed = deviation[reports_convergence(run)]
        return float(fold(claimed)) if len(claimed) else np.nan

    return of


def _sure(part: Callable[[Certainty], float]) -> Of:
    return lambda run, _: part(certainty_of(run))


def _wrongly_sure_in(quantity: str) -> Of:
    return _sure(lambda sure: sure.wrongly_in.get(quantity, np.nan))


def _nis(run: xr.Dataset, span: Window) -> float:
    return nis_statistics(*nis_in(run, span)).mean


def _nis_sum(run: xr.Dataset, span: Window) -> float:
    return float(np.sum(nis_in(run, span)[0])) if tells_nis(run) else np.nan


def _nis_channels_sum(run: xr.Dataset, span: Window) -> float:
    return float(np.sum(nis_in(run, span)[1])) if tells_nis(run) else np.nan


def _nees(run: xr.Dataset, span: Window) -> float:
    return float(np.mean(_held(run, nees_of(run), span)))


def _nees_at_end(run: xr.Dataset, span: Window) -> float:
    return float(_held(run, nees_of(run), span)[-1])


def _used_fixes(run: xr.Dataset, _: Window) -> float:
    return float(run["fix_used"].values.sum()) if "fix_used" in run else np.nan


def _rejected_fixes(run: xr.Dataset, _: Window) -> float:
    if "rejected_fixes" not in run:
        return np.nan
    return float(run["rejected_fixes"].values[-1]) if run.sizes["fix"] else 0.0


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else value


def _figures() -> Iterator[Figure]:
    for name in ("heading", "tilt", "velocity", "horizontal", "vertical"):
        error = ERRORS[name]
        description = f"{error.description}: RMS over the window"
        yield Figure(f"{name}_rmse", f"{name} RMSE", error.unit, description, _rmse(name), RMS)
    yield Figure("heading_mean", "mean heading error", "rad", "Mean of the heading error", _heading_mean)
    yield Figure(
        "heading_largest", "largest heading error", "rad", "Largest size of the error", _largest("heading")
    )
    yield Figure("heading_end", "heading at the end", "rad", "Error of the heading at the end", _heading_end)
    yield Figure(
        "heading_sigma_rms",
        "heading sigma",
        "rad",
        "Sigma of the heading that the filter claims: RMS over the window",
        _heading_sigma,
        RMS,
    )
    yield Figure(
        "horizontal_sigma_rms",
        "horizontal sigma",
        "m",
        "Sigma of the horizontal position that the filter claims: RMS over the window",
        _horizontal_sigma,
        RMS,
    )
    yield from _times()
    yield from _of_certainty()
    yield from _of_fixes()
    yield Figure("nees", "NEES / states", "1", "Mean NEES for each state", _nees, needs=COVARIANCE)
    yield Figure("success", "verdict", "1", "1 if the verdict on the run is good, 0 if not", _success, SHARE)
    yield from _of_papers()


def _times() -> Iterator[Figure]:
    yield Figure(
        "convergence_time",
        "within the limit since",
        "s",
        "Time from which the error that counts stays within its limit",
        _convergence_time,
        MEDIAN,
    )
    yield Figure(
        "hand_over_time",
        "handed over",
        "s",
        "Time at which an alignment handed over to the filter, where there is one",
        _hand_over_time,
        LAST,
    )
    yield Figure(
        "claimed_time",
        "reports convergence since",
        "s",
        "Time from which the filter reports convergence until the end",
        _claimed_time,
        MEDIAN,
    )


def _of_certainty() -> Iterator[Figure]:
    yield Figure(
        "claimed_deviation",
        "error at the first report",
        "1",
        "Size of the heading error in sigmas of the filter when it first reports convergence",
        _claimed(lambda deviation: deviation[0]),
    )
    yield Figure(
        "largest_claimed_deviation",
        "largest error while reporting",
        "1",
        "The largest of it while the filter reports convergence",
        _claimed(np.max),
    )
    yield Figure(
        "sure_time", "sure", "s", "How long the filter reports convergence", _sure(lambda sure: sure.sure)
    )
    yield Figure(
        "wrongly_sure_time",
        "wrongly sure",
        "s",
        "How long of it a component of its error is beyond 3 sigma",
        _sure(lambda sure: sure.wrongly),
    )
    yield Figure(
        "longest_wrongly_sure",
        "longest wrongly sure",
        "s",
        "The longest uninterrupted stretch of that",
        _sure(lambda sure: sure.longest),
        LAST,
    )
    for name in QUANTITIES:
        yield Figure(
            f"wrongly_sure_{name}_time",
            f"wrongly sure of the {name}",
            "s",
            f"How long it reports convergence with its {name} beyond 3 sigma",
            _wrongly_sure_in(name),
        )


def _of_fixes() -> Iterator[Figure]:
    summed = "Normalised innovations squared of the fixes used in the window, summed"
    total = Figure("nis_sum", "sum of NIS", "1", summed, _nis_sum, COUNT)
    count = Figure("nis_channels_sum", "channels", "1", "Channels of those fixes", _nis_channels_sum, COUNT)
    yield total
    yield count
    yield Figure(
        "nis", "NIS / channels", "1", "Mean NIS for each channel", _nis, OF_SUMS, parts=(total, count)
    )
    yield Figure("used_fixes", "fixes used", "1", "Fixes that corrected the estimate", _used_fixes)
    yield Figure("rejected_fixes", "fixes refused", "1", "Fixes that were refused", _rejected_fixes)


def _of_papers() -> Iterator[Figure]:
    """RMSE of an alignment is over all runs; that of navigation is the mean of the runs' own."""
    for name, title, error, fold in (
        ("heading", "heading RMSE", "heading", RMS),
        ("tilt_east", "tilt RMSE about east", "tilt_east", RMS),
        ("tilt_north", "tilt RMSE about north", "tilt_north", RMS),
        ("horizontal", "horizontal", "horizontal", MEAN),
        ("vertical", "vertical", "vertical", MEAN),
        ("velocity", "velocity", "velocity", MEAN),
        ("velocity_east", "velocity east", "velocity_east", MEAN),
        ("tilt", "tilt", "tilt", MEAN),
        ("yaw", "yaw", "heading", MEAN),
    ):
        description = f"{ERRORS[error].description}: RMS over the window"
        yield Figure(name, title, ERRORS[error].unit, description, _rmse(error), fold)
    settled = "Time from which the heading error stays within its limit; infinite if it never does"
    yield Figure("settling", "heading settled", "s", settled, _settling, OF_ERRORS)
    yield Figure("median_settling", "median time to settle", "s", settled, _settling, MEDIAN)
    yield Figure(
        "failures",
        "failed runs",
        "1",
        "1 of a heading error whose RMS over the window is beyond twice its limit, 0 of another",
        _failed,
        COUNT,
    )
    yield Figure(
        "largest_velocity",
        "largest velocity error",
        "m/s",
        "Largest size of a horizontal component of the velocity error",
        _largest("horizontal_velocity"),
    )
    yield Figure(
        "horizontal_at_end",
        "horizontal at the end",
        "m",
        "Error of the horizontal position at the end of the window",
        _at_end("horizontal"),
    )
    yield Figure(
        "nees_at_end",
        "NEES / states at the end",
        "1",
        "NEES for each state at the end of the window",
        _nees_at_end,
        needs=COVARIANCE,
    )


FIGURES: Final[Mapping[str, Figure]] = {one.name: one for one in _figures()}
"""Those that come with the package, by name."""
