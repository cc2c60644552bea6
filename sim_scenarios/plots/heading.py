"""Pictures of an alignment: the heading with sigma and bound."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sim_scenarios.metrics.statistics import sigma_of_heading
from sim_scenarios.plots.style import (
    BAND,
    BLUE,
    GREEN,
    INK,
    ORANGE,
    PURPLE,
    figure,
    largest,
    limit,
    lines,
    shade_window,
)
from sim_scenarios.recording import ALIGNMENT, HAND_OVER
from sim_scenarios.units import ARCMIN, DEGREE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BOUND = "bound.heading_sigma"
BOUND_OF_ANY = "bound.heading_sigma_any"
STEADY_BOUND = "bound.heading_sigma_steady"


def heading_error(run: xr.Dataset) -> Figure:
    """Heading error with 3 sigma and the bound: the whole run in degrees, its end in arcminutes."""
    time, error, sigma = run["time"].values, run["heading_error"].values, sigma_of_heading(run)
    claims = "heading_sigma" in run
    with figure(rows=2, height=6.2, sharex=True) as (drawn, (whole, end)):
        for axes, unit in ((whole, DEGREE), (end, ARCMIN)):
            shade_window(axes, run, "evaluation window")
            if claims:
                axes.fill_between(
                    time, -3 * sigma / unit, 3 * sigma / unit, label="3 sigma of the filter", **BAND
                )
            _draw_three_sigma_of_bound(axes, run, unit)
            axes.plot(time, error / unit, color=BLUE, lw=1.3, label="heading error")
        limit(whole, largest(error) / DEGREE, floor=1.0)
        whole.set_ylabel("deg")
        whole.set_title("Heading error: estimated minus true")
        whole.legend(loc="upper right", ncols=2)
        inside = time >= run.attrs["evaluation.start"]
        reach = largest(error[inside], 3.3 * sigma[inside], 3.3 * _last_bound(run))
        limit(end, reach / ARCMIN, floor=1.0)
        end.set_ylabel("arcmin")
        end.set_xlabel("time [s]")
        return drawn


def hand_over(run: xr.Dataset) -> Figure:
    """Heading error with 3 sigma of an alignment and of the navigation that it hands over to."""
    time, start = run["time"].values, float(run[HAND_OVER])
    navigates = time >= start
    parts = [("alignment", ORANGE, ~navigates, ALIGNMENT)]
    if navigates.any():
        parts.append(("navigation", BLUE, navigates, ""))
    with figure(rows=2, height=6.2, sharex=True) as (drawn, (whole, end)):
        for axes, unit in ((whole, DEGREE), (end, ARCMIN)):
            shade_window(axes, run, "evaluation window")
            for label, colour, rows, prefix in parts:
                error, sigma = (run[f"{prefix}heading_{name}"].values[rows] for name in ("error", "sigma"))
                band = {**BAND, "color": colour, "label": f"3 sigma of the {label}"}
                axes.fill_between(time[rows], -3 * sigma / unit, 3 * sigma / unit, **band)
                axes.plot(time[rows], error / unit, color=colour, lw=1.3, label=label)
            if navigates.any():
                axes.axvline(start, color=INK, ls=":", lw=1.2, label=f"hand-over at {start:.1f} s")
        limit(whole, largest(run[f"{ALIGNMENT}heading_error"]) / DEGREE, floor=1.0)
        whole.set_ylabel("deg")
        whole.set_title("Heading error: estimated minus true, across the hand-over")
        whole.legend(loc="upper right", ncols=3)
        row = int(np.argmax(navigates)) if navigates.any() else -1
        limit(end, 4 * float(run[f"{ALIGNMENT}heading_sigma"].values[row]) / ARCMIN, floor=1.0)
        end.set_ylabel("arcmin")
        end.set_xlabel("time [s]")
        return drawn


def heading(run: xr.Dataset) -> Figure:
    """Heading over time with 3 sigma, for a run without truth; below its end, or its sigma where it turns."""
    time, estimate = run["time"].values, np.unwrap(run["nav.heading"].values) / DEGREE
    sigma = run["heading_sigma"].values / DEGREE

    def draw(axes: Axes) -> None:
        axes.fill_between(time, estimate - 3 * sigma, estimate + 3 * sigma, label="3 sigma", **BAND)
        axes.plot(time, estimate, color=BLUE, lw=1.3, label="heading")
        axes.set_ylabel("deg")

    with figure(rows=2, height=6.2, sharex=True) as (drawn, (whole, below)):
        draw(whole)
        whole.set_title("Heading, clockwise from north")
        whole.legend(loc="upper right")
        late = time >= (time[0] + time[-1]) / 2
        moved, reach = np.abs(estimate[late] - estimate[-1]).max(), 3 * sigma[late].max()
        if moved > reach:
            below.semilogy(time, sigma, color=BLUE, lw=1.3)
            below.set_ylabel("1 sigma [deg]")
        else:
            draw(below)
            below.set_ylim(estimate[-1] - 1.2 * reach, estimate[-1] + 1.2 * reach)
            below.ticklabel_format(useOffset=False)
        below.set_xlabel("time [s]")
        return drawn


def comparison(runs: xr.Dataset) -> Figure:
    """Heading errors of several filters on the same signals, and the bound."""
    time = runs["time"].values
    with figure(rows=2, height=7.0, sharex=True) as (drawn, (whole, end)):
        for axes, unit in ((whole, DEGREE), (end, ARCMIN)):
            shade_window(axes, runs)
            if BOUND in runs:
                bound = runs[BOUND].values / unit
                axes.fill_between(
                    runs["bound_time"],
                    -bound,
                    bound,
                    color=INK,
                    alpha=0.14,
                    lw=0,
                    label="1 sigma of the Cramer-Rao bound",
                )
            for label, colour, dashes in lines(runs["filter"].values):
                error = runs["heading_error"].sel(filter=label) / unit
                axes.plot(time, error, dashes, color=colour, lw=1.4, label=label)
        whole.set_ylabel("deg")
        whole.set_title("Heading error of each filter on the same signals")
        whole.legend(loc="upper right", ncols=2)
        inside = time >= runs.attrs["evaluation.start"]
        reach = 1.1 * largest(runs["heading_error"].values[:, inside]) / ARCMIN
        limit(end, reach, floor=max(1.0, 1.5 * _last_bound(runs) / ARCMIN))
        end.set_ylabel("arcmin")
        end.set_xlabel("time [s]")
        return drawn


def bound(data: xr.Dataset) -> Figure:
    """The bound of the heading along a trajectory."""
    window = (data.attrs["evaluation.start"], data.attrs["evaluation.stop"])
    rms, steady = (data.attrs[f"bound.{name}"] / ARCMIN for name in ("heading_rms", "steady_course_limit"))
    with figure(rows=1, height=3.8) as (drawn, (axes,)):
        shade_window(axes, data, "evaluation window")
        axes.plot(
            data["bound_time"], data[BOUND] / ARCMIN, color=ORANGE, lw=1.6, label="sigma of the heading"
        )
        for name, color, label in (
            (BOUND_OF_ANY, PURPLE, "errors of any size"),
            (STEADY_BOUND, GREEN, "without the manoeuvres"),
        ):
            if name in data:
                axes.plot(data["bound_time"], data[name] / ARCMIN, color=color, lw=1.2, label=label)
        axes.plot(window, (rms, rms), ":", color=INK, lw=1.2, label=f"RMS over the window: {rms:.2f} arcmin")
        axes.axhline(
            steady, color=BLUE, ls="--", lw=1.0, label=f"limit of a steady course: {steady:.2f} arcmin"
        )
        axes.set_yscale("log")
        axes.set_ylabel("arcmin")
        axes.set_xlabel("time [s]")
        axes.set_title(f"Bound of the heading: {data.attrs['scenario']}")
        axes.legend(loc="upper right")
        return drawn


def _draw_three_sigma_of_bound(axes: Axes, run: xr.Dataset, unit: float) -> None:
    if BOUND not in run:
        return
    bound = 3 * run[BOUND].values / unit
    for sign, label in ((1, "3 sigma of the Cramer-Rao bound"), (-1, None)):
        axes.plot(run["bound_time"], sign * bound, "--", color=ORANGE, lw=1.2, label=label)


def _last_bound(data: xr.Dataset) -> float:
    return float(data[BOUND].values[-1]) if BOUND in data else 0.0
