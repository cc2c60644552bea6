"""Pictures of many runs: the error of one over time, root mean squares over time, and their distribution."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawn
from numpy.typing import NDArray

from sim_scenarios.metrics.errors import ERRORS, root_mean_square
from sim_scenarios.metrics.folds import Estimate
from sim_scenarios.metrics.statistics import rms
from sim_scenarios.plots.style import INK, figure, lines
from sim_scenarios.studies.ensemble import ESTIMATED_NOISE, Ensemble
from sim_scenarios.timeline import Window, inside
from sim_scenarios.units import ARCMIN, DEGREE

Array = NDArray[np.float64]
EAST, NORTH, UP = 0, 1, 2


Course = Callable[[xr.Dataset], tuple[Array, Array]]
"""Times [s] and values [SI] of one filter of a run, shapes (n,) and (n,) or (n, k)."""


@dataclass(frozen=True)
class Panel:
    """What stands on the vertical axis.

    Attributes
    ----------
    title, unit : str
    size : float
        Of the unit, in SI.
    of : callable
        The course of one filter of a run.
    is_value : bool
        Whether the course is an error that is shown upon what is true.
    """

    title: str
    unit: str
    size: float
    of: Course
    is_value: bool = False

    @property
    def label(self) -> str:
        """Title with the unit."""
        return f"{self.title} [{self.unit}]"


def _error(name: str) -> Course:
    error = ERRORS[name]
    return lambda run: (run["time"].values, error.of(run))


def _sigma_of_fixes(unit: str, axis: int) -> Course:
    """Sigma of an axis of the fixes that were used, as the filter has estimated it."""

    def of(run: xr.Dataset) -> tuple[Array, Array]:
        used, estimate = run["fix_used"].values, run[ESTIMATED_NOISE]
        channel = np.flatnonzero(np.array(estimate.attrs["units"].split()) == unit)[axis]
        return run["fix_time"].values[used], estimate.values[used][:, channel]

    return of


def _components(what: str, unit: str) -> dict[str, Panel]:
    return {
        f"{what}_{axis}": Panel(f"{what} error {axis}", unit, 1.0, _error(f"{what}_{axis}"))
        for axis in ("east", "north", "up")
    }


PANELS: Final[Mapping[str, Panel]] = {
    "heading": Panel("heading error", "'", ARCMIN, _error("heading")),
    "heading_deg": Panel("heading error", "deg", DEGREE, _error("heading")),
    "tilt_east": Panel("tilt error about east", "'", ARCMIN, _error("tilt_east")),
    "tilt_north": Panel("tilt error about north", "'", ARCMIN, _error("tilt_north")),
    "horizontal": Panel("horizontal error", "m", 1.0, _error("horizontal")),
    "height": Panel("height error", "m", 1.0, _error("vertical")),
    **_components("velocity", "m/s"),
    **_components("position", "m"),
    "value_velocity_east": Panel("velocity east", "m/s", 1.0, _error("velocity_east"), is_value=True),
    "sigma_position_east": Panel("sigma of a fix, position east", "m", 1.0, _sigma_of_fixes("m", EAST)),
    "sigma_position_north": Panel("sigma of a fix, position north", "m", 1.0, _sigma_of_fixes("m", NORTH)),
    "sigma_height": Panel("sigma of a fix, height", "m", 1.0, _sigma_of_fixes("m", UP)),
    "sigma_velocity_east": Panel("sigma of a fix, velocity east", "m/s", 1.0, _sigma_of_fixes("m/s", EAST)),
}
"""Panels by name."""

Told = Callable[[str], Array | None]
"""What is true of a panel at every recorded time [SI], where there is such a thing."""


def drawn(
    runs: Ensemble,
    kind: str,
    panels: Sequence[str],
    labels: Sequence[str],
    window: Window | None = None,
    told: Told = lambda _: None,
) -> Drawn:
    """A picture of an ensemble.

    Parameters
    ----------
    runs : Ensemble
        What is drawn.
    kind : str
        `run`: the errors of the first run over time; `value`: the same upon what is true; `rms`: root mean
        square over the runs over time; `distribution`: share of the runs whose root mean square over the
        window is no larger.
    panels : sequence of str
        Names in `PANELS`, one below the other.
    labels : sequence of str
        Filters.
    window : tuple of float, optional
        What of the runs is drawn; all of it if left out, of a distribution the window of the scenario.
    told : callable
        What is true of a panel; drawn in ink where there is such a thing.
    """
    over_time = kind != "distribution"
    time = runs.first["time"].values
    shown = window or ((float(time[0]), float(time[-1])) if over_time else runs.window)
    held = inside(time, *shown)
    with figure(rows=len(panels), height=1.2 + 2.2 * len(panels), sharex=over_time) as (picture, rows):
        for axes, name in zip(rows, panels, strict=True):
            panel = PANELS[name]
            truth = told(name) if over_time else None
            if truth is not None:
                axes.plot(time[held], truth[held] / panel.size, color=INK, lw=1.2, label="true")
            for label, colour, dashes in lines(labels):
                upon = truth[held] if truth is not None and kind == "value" and panel.is_value else None
                x, y = _curve(runs.filters[label], panel, kind, shown, upon)
                style = "default" if over_time else "steps-post"
                axes.plot(x, y, dashes, color=colour, lw=1.2, label=label, drawstyle=style)
            if kind == "rms":
                axes.set_yscale("log")
            if kind == "run":
                _spread(axes)
            axes.set_ylabel(panel.label if over_time else "share of runs")
            axes.set_xlabel("" if over_time else f"RMSE, {panel.label}")
        if over_time:
            rows[-1].set_xlabel("time [s]")
        rows[0].legend(loc="best", ncols=3)
        return picture


def _spread(axes: Axes) -> None:
    """Let a large error at the start not hide what is left of it: linear near zero, logarithmic beyond."""
    curves = [np.abs(line.get_ydata()) for line in axes.get_lines()]
    usual = max(float(np.median(curve[len(curve) // 2 :])) for curve in curves)
    if usual > 0 and max(float(np.max(curve)) for curve in curves) > 30 * usual:
        axes.set_yscale("symlog", linthresh=10 ** np.ceil(np.log10(usual)))
        axes.axhline(0.0, color=INK, lw=0.6)


def converged(axis: str, values: Sequence[float], shares: Mapping[str, Sequence[Estimate]]) -> Drawn:
    """Share of the runs of each filter that converge, with its interval, over what is changed."""
    with figure(rows=1, height=3.6) as (picture, (axes,)):
        for label, colour, dashes in lines(shares):
            of = shares[label]
            axes.plot(values, [e.value for e in of], f"o{dashes}", color=colour, lw=1.2, label=label)
            axes.fill_between(values, [e.lower for e in of], [e.upper for e in of], color=colour, alpha=0.12)
        axes.set_ylabel("share of runs that converge")
        axes.set_ylim(-0.03, 1.03)
        axes.set_xlabel(axis)
        axes.legend(loc="best")
        return picture


def _curve(
    runs: Sequence[xr.Dataset], panel: Panel, kind: str, window: Window, truth: Array | None
) -> tuple[Array, Array]:
    if kind == "distribution":
        each = np.sort([rms(_shown(run, panel, window)[1]) for run in runs]) / panel.size
        return each, np.arange(1, len(each) + 1) / len(each)
    time, values = _shown(root_mean_square(runs) if kind == "rms" else runs[0], panel, window)
    signed = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
    known = np.isfinite(signed)
    upon = np.zeros(len(signed)) if truth is None else truth
    return time[known], (signed + upon)[known] / panel.size


def _shown(run: xr.Dataset, panel: Panel, window: Window) -> tuple[Array, Array]:
    time, values = panel.of(run)
    held = inside(time, *window)
    return time[held], values[held]
