"""What a campaign keeps of every run: errors over time, and figures over the evaluation window.

The figures are those of `truenorth run` and `compare` to the last bit: they are taken at the recording period
of the scenario, before the errors over time are thinned out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import NAVIGATION_FILTER
from sim_scenarios.metrics import certainty, hand_over, judge
from sim_scenarios.metrics.certainty import QUANTITIES
from sim_scenarios.metrics.statistics import (
    holds_since,
    is_measured,
    reports_convergence,
    rms,
    sigma_of_heading,
    tells_nis,
)
from sim_scenarios.timeline import RESOLUTION, inside, within

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Quantity:
    """An error, whose size over time and whose RMSE over the window are kept."""

    title: str
    unit: str
    description: str


ERRORS: Final[Mapping[str, Quantity]] = {
    "heading": Quantity("Heading", "rad", "Error of the heading, estimated minus true"),
    "tilt": Quantity("Tilt", "rad", "Misalignment about the horizontal axes, both together"),
    "velocity": Quantity("Velocity", "m/s", "Error of the velocity, all three components together"),
    "horizontal": Quantity("Horizontal position", "m", "Error of the horizontal position"),
    "vertical": Quantity("Vertical position", "m", "Error of the height, estimated minus true"),
}

BOUNDED: Final = ("heading", "horizontal")
"""Errors that a Cramer-Rao bound is known of, where the filter measures what it takes."""

SERIES: Final[Mapping[str, tuple[str, str]]] = {
    **{f"{name}_error": (q.unit, q.description) for name, q in ERRORS.items()},
    "heading_sigma": ("rad", "Sigma of the heading that the filter claims"),
    "velocity_sigma": ("m/s", "Sigma of the velocity that the filter claims, all three components together"),
    "position_sigma": ("m", "Sigma of the position that the filter claims, all three components together"),
    **{
        f"{name}_deviation": ("1", f"Error of the {name} in sigmas of the filter: the largest component")
        for name in QUANTITIES
    },
    "nis": ("1", "Normalised innovations squared of the fixes used since the time before, summed"),
    "nis_channels": ("1", "Channels of those fixes: the degrees of freedom of `nis`"),
}
"""Unit and description of what is kept over time; sigmas and deviations are NaN where the filter has none."""

FIGURES: Final[Mapping[str, tuple[str, str]]] = {
    **{f"{name}_rmse": (q.unit, f"{q.description}: RMS over the window") for name, q in ERRORS.items()},
    "heading_end": ("rad", "Error of the heading at the end"),
    "heading_sigma_rms": ("rad", "Sigma of the heading that the filter claims: RMS over the window"),
    "convergence_time": ("s", "Time from which the error that counts stays within its limit"),
    "hand_over_time": (
        "s",
        "Time at which an alignment handed over to the filter, where there is one",
    ),
    "claimed_time": ("s", "Time from which the filter reports convergence until the end"),
    "claimed_deviation": (
        "1",
        "Size of the heading error in sigmas of the filter when it first reports convergence",
    ),
    "largest_claimed_deviation": ("1", "The largest of it while the filter reports convergence"),
    "sure_time": ("s", "How long the filter reports convergence"),
    "wrongly_sure_time": ("s", "How long of it a component of its error is beyond 3 sigma"),
    "longest_wrongly_sure": ("s", "The longest uninterrupted stretch of that"),
    **{
        f"wrongly_sure_{name}_time": ("s", f"How long it reports convergence with its {name} beyond 3 sigma")
        for name in QUANTITIES
    },
    "nis_sum": ("1", "Normalised innovations squared of the fixes used in the window, summed"),
    "nis_channels_sum": ("1", "Channels of those fixes"),
    "used_fixes": ("1", "Fixes that corrected the estimate"),
    "rejected_fixes": ("1", "Fixes that were refused"),
    "success": ("1", "1 if the verdict on the run is good, 0 if not"),
}
"""Unit and description of what is kept of a run as a whole."""

OUTPUTS: Final = (
    *(f"nav.{name}" for name in ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity")),
    "heading_sigma",
    "velocity_sigma",
    "position_sigma",
    "status",
    "converged",
)
"""Outputs of a filter that `kept` needs at every recorded instant, where it has them."""

FIX_OUTPUTS: Final = ("innovation_sigma", "nis", "used_fixes", "rejected_fixes")
"""Outputs of a filter that `kept` needs at every fix."""


def that_counts(attributes: Mapping[str, Any]) -> str:
    """Error that a filter is judged by: heading of an alignment, horizontal position of navigation."""
    return "horizontal" if attributes["filter_fmu"] == NAVIGATION_FILTER else "heading"


def kept(run: xr.Dataset, period: float) -> dict[str, Array]:
    """What a campaign keeps of one filter of a run.

    Parameters
    ----------
    run : xarray.Dataset
        Of one filter, with the attributes of `sim_scenarios.run`.
    period : float
        Between the times of the series [s], a multiple of the recording period.

    Returns
    -------
    dict of str to ndarray
        Series, shape (times,), and figures, shape (); without the NIS of a filter that does not tell it.
    """
    errors = {name: np.asarray(values) for name, values in _errors(run).items()}
    stride = round(period / float(run["time"].values[1] - run["time"].values[0]))
    series = {f"{name}_error": values[::stride] for name, values in errors.items()}
    series |= {f"{name}_sigma": _sigma(run, name)[::stride] for name in QUANTITIES}
    deviations = certainty.deviations(run)
    series |= {f"{name}_deviation": values[::stride] for name, values in deviations.items()}
    if tells_nis(run):
        series["nis"], series["nis_channels"] = _nis(run, period, len(series["heading_sigma"]))
    return {**series, **_figures(run, errors)}


def _errors(run: xr.Dataset) -> dict[str, Array]:
    """Errors over time, shape (rows,): signed where they are scalars, lengths where they are vectors."""
    position, velocity = run["position_error"].values, run["velocity_error"].values
    attitude = wrap(run["attitude_error"].values)
    return {
        "heading": wrap(run["heading_error"].values),
        "tilt": np.hypot(attitude[:, 0], attitude[:, 1]),
        "velocity": np.sqrt(np.sum(velocity**2, axis=1)),
        "horizontal": np.hypot(position[:, 0], position[:, 1]),
        "vertical": position[:, 2],
    }


def _sigma(run: xr.Dataset, name: str) -> Array:
    """Sigma of a quantity over time, shape (rows,): root of the sum of the squares of its components."""
    if f"{name}_sigma" not in run:
        return np.full(run.sizes["time"], np.nan)
    sigma: Array = run[f"{name}_sigma"].values
    return sigma if sigma.ndim == 1 else np.sqrt(np.sum(sigma**2, axis=1))


def _nis(run: xr.Dataset, period: float, rows: int) -> tuple[Array, Array]:
    """NIS and channels of the fixes that were used, summed up to each row."""
    used = run["fix_used"].values
    row = np.ceil((run["fix_time"].values[used] - RESOLUTION) / period).astype(int)
    row, kept_in = np.clip(row, 0, rows - 1), row < rows
    nis, channels = run["nis"].values[used] * kept_in, is_measured(run)[used].sum(axis=1) * kept_in
    summed = np.array([np.bincount(row, weights, rows) for weights in (nis, channels)], dtype=np.float64)
    return summed[0], summed[1]


def _figures(run: xr.Dataset, errors: Mapping[str, Array]) -> dict[str, Array]:
    counting = that_counts(run.attrs)
    start, stop, limit = (
        float(run.attrs[f"evaluation.{key}"]) for key in ("start", "stop", f"{counting}_limit")
    )
    time, verdict, handed = run["time"].values, judge(run), hand_over.of_run(run)
    converged, sigma = reports_convergence(run), sigma_of_heading(run)
    deviation = certainty.deviations(run).get("heading", np.full(len(time), np.nan))[converged]
    figures = {
        **{f"{name}_rmse": rms(within(time, values, start, stop)) for name, values in errors.items()},
        "heading_end": errors["heading"][-1],
        "heading_sigma_rms": rms(within(time, sigma, start, stop)),
        "convergence_time": _time(holds_since(time, np.abs(errors[counting]) <= limit)),
        "hand_over_time": _time(handed.time if handed else None),
        "claimed_time": _time(holds_since(time, converged)),
        "claimed_deviation": deviation[0] if converged.any() else np.nan,
        "largest_claimed_deviation": deviation.max() if converged.any() else np.nan,
        "sure_time": verdict.certainty.sure,
        "wrongly_sure_time": verdict.certainty.wrongly,
        "longest_wrongly_sure": verdict.certainty.longest,
        **{f"wrongly_sure_{name}_time": span for name, span in verdict.certainty.wrongly_in.items()},
        **(_nis_sums(run, start, stop) if tells_nis(run) else {}),
        "used_fixes": verdict.used_fixes,
        "rejected_fixes": verdict.rejected_fixes,
        "success": verdict.ok,
    }
    return {name: np.asarray(value, dtype=float) for name, value in figures.items()}


def _nis_sums(run: xr.Dataset, start: float, stop: float) -> dict[str, Any]:
    """NIS and channels of the fixes that were used in the window, summed."""
    fixes = run["fix_used"].values & inside(run["fix_time"].values, start, stop)
    return {"nis_sum": run["nis"].values[fixes].sum(), "nis_channels_sum": is_measured(run)[fixes].sum()}


def _time(since: float | None) -> float:
    return float("nan") if since is None else since
