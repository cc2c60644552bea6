"""What a replay was worth: against the fixes that it was given, and against a reference if there is one.

The fixes are no truth to a filter that uses them. What tells is the innovation, by which it was off before it
took a fix; and the course over ground, which a vehicle that neither drifts nor slips heads for: the mean of
heading minus course holds the mounting and the side slip, its standard deviation what the filter adds.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.metrics import certainty
from sim_scenarios.metrics.certainty import WRONG, Certainty
from sim_scenarios.metrics.figures import FIGURES
from sim_scenarios.metrics.statistics import is_measured, rms
from sim_scenarios.metrics.verdict import known
from sim_scenarios.recording import ERRORS
from sim_scenarios.recordings import track
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

MOVING: Final = 3.0
"""Horizontal speed from which the course counts [m/s]."""


@dataclass(frozen=True)
class AgainstFixes:
    """SI units; not a number of what there is none of.

    Attributes
    ----------
    fixes : int
        That were used or refused since the evaluation starts.
    horizontal, vertical : float
        RMS of the innovations of position [m].
    heading_mean, heading_deviation : float
        Mean and standard deviation of heading minus course at the fixes above `MOVING` [rad].
    sure, wrongly : int
        Fixes before which the filter reported convergence, and those of them with a component of the position
        beyond `WRONG` sigmas of its innovation. Of a consistent filter and receiver 0.8 % are so.
    """

    fixes: int
    horizontal: float
    vertical: float
    heading_mean: float
    heading_deviation: float
    sure: int
    wrongly: int

    def headline(self) -> dict[str, str]:
        """With units, by what they are."""
        found = {}
        if not np.isnan(self.horizontal):
            rms_text = f"{self.horizontal:.3f} m horizontal, {self.vertical:.3f} m vertical"
            found["RMS before each fix"] = rms_text
        if not np.isnan(self.heading_deviation):
            mean, deviation = self.heading_mean / DEGREE, self.heading_deviation / DEGREE
            found[f"Heading minus course above {MOVING:g} m/s"] = (
                f"{mean:.2f} deg, standard deviation {deviation:.2f} deg"
            )
        if self.sure:
            found[f"Fixes beyond {WRONG:g} sigma while converged"] = f"{self.wrongly} of {self.sure}"
        return found

    def figures(self) -> dict[str, Any]:
        """For machines."""
        return {
            "fixes": self.fixes,
            "horizontal_rms_m": known(self.horizontal),
            "vertical_rms_m": known(self.vertical),
            "heading_minus_course_mean_deg": known(self.heading_mean / DEGREE),
            "heading_minus_course_deviation_deg": known(self.heading_deviation / DEGREE),
            "fixes_while_converged": self.sure,
            "fixes_beyond_3_sigma_while_converged": self.wrongly,
        }


@dataclass(frozen=True)
class AgainstReference:
    """Errors over the times that the reference covers; SI units, not a number of what it does not tell.

    Attributes
    ----------
    horizontal, vertical, velocity : float
        RMSE [m], [m/s].
    tilt, heading : float
        RMSE [rad].
    nees : float
        Mean over time for each state, of a filter that puts out a covariance.
    certainty : Certainty
    """

    horizontal: float
    vertical: float
    velocity: float
    tilt: float
    heading: float
    nees: float
    certainty: Certainty

    def headline(self) -> dict[str, str]:
        """With units, by what they are."""
        found = {
            "Horizontal RMSE": (self.horizontal, "m", 1.0),
            "Vertical RMSE": (self.vertical, "m", 1.0),
            "Velocity RMSE": (self.velocity, "m/s", 1.0),
            "Tilt RMSE": (self.tilt, "deg", DEGREE),
            "Heading RMSE": (self.heading, "deg", DEGREE),
            "Mean NEES / states": (self.nees, "", 1.0),
        }
        figures = {
            name: f"{value / size:.3f} {unit}".rstrip()
            for name, (value, unit, size) in found.items()
            if not np.isnan(value)
        }
        return {**figures, **self.certainty.headline()}

    def figures(self) -> dict[str, Any]:
        """For machines."""
        return {
            "horizontal_rmse_m": known(self.horizontal),
            "vertical_rmse_m": known(self.vertical),
            "velocity_rmse_m_per_s": known(self.velocity),
            "tilt_rmse_deg": known(self.tilt / DEGREE),
            "heading_rmse_deg": known(self.heading / DEGREE),
            "nees_per_state": known(self.nees),
            **self.certainty.figures(),
        }


def evaluated(run: xr.Dataset) -> xr.Dataset:
    """The part of a replay that is judged: since the filter navigates, and the evaluation starts."""
    since = max(track.navigates_from(run), float(run.attrs["evaluation.start"]))
    times = {"time": "time", "fix": "fix_time", "receiver": "receiver_time"}
    rows = {dimension: run[time].values >= since for dimension, time in times.items() if time in run}
    part: xr.Dataset = run.isel(rows)
    return part


def against_fixes(run: xr.Dataset) -> AgainstFixes:
    """A replay against the fixes of its recording."""
    run = evaluated(run)
    off, sigma = missed(run), run["innovation_sigma"].values[:, _positions_measured(run)]
    beyond = (np.abs(off) > WRONG * sigma).any(axis=1)
    sure = _converged_before(run) & np.isfinite(off).any(axis=1)
    _, turned = heading_minus_course(run)
    mean = float(np.angle(np.mean(np.exp(1j * turned)))) if len(turned) else nan
    return AgainstFixes(
        fixes=run.sizes["fix"],
        horizontal=_rms_of_norm(off[:, :2]),
        vertical=_rms_of_norm(off[:, 2:]),
        heading_mean=mean,
        heading_deviation=rms(wrap(turned - mean)) if len(turned) else nan,
        sure=int(sure.sum()),
        wrongly=int((sure & beyond).sum()),
    )


def missed(run: xr.Dataset) -> Array:
    """Innovation of the position of each fix, east, north, up [m], shape (fixes, 3); NaN if not measured."""
    channels = _positions_measured(run)
    off: Array = np.where(is_measured(run)[:, channels], run["innovation"].values[:, channels], np.nan)
    return off


def against_reference(run: xr.Dataset) -> AgainstReference | None:
    """A replay against its reference; None without one, or where it covers no time with an estimate."""
    run = compared(run)
    if run.sizes["time"] < 2 or not any(name in run for name in ERRORS):
        return None
    whole = float(run["time"].values[0]), float(run["time"].values[-1])

    def figure(name: str) -> float:
        return FIGURES[name].of(run, whole)

    return AgainstReference(
        horizontal=figure("horizontal_rmse"),
        vertical=figure("vertical_rmse"),
        velocity=figure("velocity_rmse"),
        tilt=figure("tilt_rmse"),
        heading=figure("heading_rmse"),
        nees=figure("nees") if all(name in run for name in ERRORS) else nan,
        certainty=certainty.of_run(run),
    )


def compared(run: xr.Dataset) -> xr.Dataset:
    """The part of a replay that is judged and of which the reference tells all that it ever tells."""
    run = evaluated(run)
    told = np.ones(run.sizes["time"], dtype=bool)
    for name in ERRORS:
        if name in run:
            told &= np.isfinite(run[name].values).reshape(len(told), -1).all(axis=1)
    part: xr.Dataset = run.isel(time=told)
    return part


def heading_minus_course(run: xr.Dataset) -> tuple[Array, Array]:
    """Times [s] of the fixes of a vehicle that moves, and heading minus course then [rad]; shape (n,)."""
    if "receiver.velocity" not in run or run.sizes["time"] == 0:
        return np.empty(0), np.empty(0)
    east, north = run["receiver.velocity"].values[:, :2].T
    time, since = run["receiver_time"].values, track.navigates_from(run)
    rows = (np.hypot(east, north) > MOVING) & (time >= since)
    off = track.headings(run, time[rows]) - np.arctan2(east[rows], north[rows])
    return time[rows], wrap(off)


def _positions_measured(run: xr.Dataset) -> list[int]:
    """Channels of the innovation that are east, north and up of the position."""
    units = run["innovation"].attrs["units"].split()
    return [i for i, unit in enumerate(units) if unit == "m"][:3]


def _converged_before(run: xr.Dataset) -> NDArray[np.bool_]:
    """Whether the filter reported convergence at the recorded time before each fix."""
    if run.sizes["time"] == 0:
        return np.zeros(run.sizes["fix"], dtype=bool)
    row = np.searchsorted(run["time"].values, run["fix_time"].values) - 1
    converged: NDArray[np.bool_] = run["converged"].values[np.maximum(row, 0)] & (row >= 0)
    return converged


def _rms_of_norm(values: Array) -> float:
    """RMS of the length of vectors, those left out of which a component is not a number; NaN without any."""
    complete = values[np.isfinite(values).all(axis=1)]
    return rms(np.linalg.norm(complete, axis=1)) if len(complete) else nan
