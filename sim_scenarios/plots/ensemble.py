"""Pictures of many runs: the error of one over time, root mean squares over time, and their distribution."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawn
from numpy.typing import NDArray

from sim_scenarios.campaigns.statistics import Estimate
from sim_scenarios.ensemble import (
    HEADING,
    HORIZONTAL,
    NOISE,
    POSITION,
    TILT_EAST,
    TILT_NORTH,
    VELOCITY,
    VERTICAL,
    Ensemble,
    Errors,
    rms_over_runs,
    rmse,
)
from sim_scenarios.plots.style import INK, figure, lines
from sim_scenarios.timeline import Window, inside
from sim_scenarios.units import ARCMIN, DEGREE

Array = NDArray[np.float64]
EAST, NORTH, UP = 0, 1, 2


@dataclass(frozen=True)
class Panel:
    """What stands on the vertical axis.

    Attributes
    ----------
    title, unit : str
    size : float
        Of the unit, in SI.
    columns : int or slice
        Of the errors.
    """

    title: str
    unit: str
    size: float
    columns: int | slice

    @property
    def label(self) -> str:
        """Title with the unit."""
        return f"{self.title} [{self.unit}]"


def _component(what: str, unit: str, columns: slice) -> dict[str, Panel]:
    axes = ("east", "north", "up")
    return {
        f"{what}_{axis}": Panel(f"{what} error {axis}", unit, 1.0, columns.start + i)
        for i, axis in enumerate(axes)
    }


PANELS: Final[Mapping[str, Panel]] = {
    "heading": Panel("heading error", "'", ARCMIN, HEADING),
    "heading_deg": Panel("heading error", "deg", DEGREE, HEADING),
    "tilt_east": Panel("tilt error about east", "'", ARCMIN, TILT_EAST),
    "tilt_north": Panel("tilt error about north", "'", ARCMIN, TILT_NORTH),
    "horizontal": Panel("horizontal error", "m", 1.0, HORIZONTAL),
    "height": Panel("height error", "m", 1.0, VERTICAL),
    **_component("velocity", "m/s", VELOCITY),
    **_component("position", "m", POSITION),
    "value_velocity_east": Panel("velocity east", "m/s", 1.0, VELOCITY.start),
    "sigma_position_east": Panel("sigma of a fix, position east", "m", 1.0, NOISE.start + EAST),
    "sigma_position_north": Panel("sigma of a fix, position north", "m", 1.0, NOISE.start + NORTH),
    "sigma_height": Panel("sigma of a fix, height", "m", 1.0, NOISE.start + UP),
    "sigma_velocity_east": Panel("sigma of a fix, velocity east", "m/s", 1.0, NOISE.start + 3 + EAST),
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
    time = runs.filters[labels[0]].time
    shown = window or ((float(time[0]), float(time[-1])) if over_time else runs.window)
    held = inside(time, *shown)
    with figure(rows=len(panels), height=1.2 + 2.2 * len(panels), sharex=over_time) as (picture, rows):
        for axes, name in zip(rows, panels, strict=True):
            panel = PANELS[name]
            truth = told(name) if over_time else None
            if truth is not None:
                axes.plot(time[held], truth[held] / panel.size, color=INK, lw=1.2, label="true")
            for label, colour, dashes in lines(labels):
                errors = runs.filters[label].part(panel.columns, shown)
                x, y = _curve(errors, kind, panel.size, None if truth is None else truth[held])
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


def _curve(errors: Errors, kind: str, size: float, truth: Array | None) -> tuple[Array, Array]:
    if kind == "rms":
        return errors.time, rms_over_runs(errors) / size
    if kind == "distribution":
        each = np.sort([rmse(run) for run in errors.runs()]) / size
        return each, np.arange(1, len(each) + 1) / len(each)
    first = errors.values[0]
    signed = first[:, 0] if first.shape[1] == 1 else np.linalg.norm(first, axis=1)
    known = np.isfinite(signed)
    upon = truth if kind == "value" and truth is not None else np.zeros(len(signed))
    return errors.time[known], (signed + upon)[known] / size
