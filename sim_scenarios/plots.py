"""Pictures of runs.

Heading error with sigma and bound, states, innovations, NIS, what the corrector did. Colours are those
of Okabe and Ito, which colour-blind readers tell apart; nothing is told by colour alone.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import cycle
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.metrics import chi_square_interval, measured_channels
from sim_scenarios.units import ARCMIN, DEGREE, HOUR, STANDARD_GRAVITY

Array = NDArray[np.float64]

WIDTH = 10.0  # inch
DEG_PER_HOUR = DEGREE / HOUR
MILLI_G = 1e-3 * STANDARD_GRAVITY


INK = "#24292f"
GRID = "#d8dee4"
BLUE, ORANGE, GREEN, YELLOW, PURPLE, SKY = "#0072b2", "#d55e00", "#009e73", "#e69f00", "#cc79a7", "#56b4e9"
COMPONENTS = ("east", "north", "up")
FILTERS = (BLUE, YELLOW, GREEN, PURPLE, SKY, ORANGE)
STYLE: dict[Any, Any] = {
    "figure.facecolor": "white",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": GRID,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 11,
    "axes.labelsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 8,
    "legend.edgecolor": GRID,
    "legend.framealpha": 0.85,
    "axes.xmargin": 0.01,
}


def png(figure: Figure) -> bytes:
    """A figure as PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def heading_error(run: xr.Dataset) -> Figure:
    """Heading error with 3 sigma and the bound: the whole run in degrees, its end in arcminutes."""
    time, error = run["time"].values, run["heading_error"].values
    sigma, bound = run["heading_sigma"].values, run["bound.heading_sigma"].values
    window = (run.attrs["evaluation.start"], run.attrs["evaluation.stop"])
    with _figure(rows=2, height=6.2, sharex=True) as (figure, (whole, end)):
        for axes, unit in ((whole, DEGREE), (end, ARCMIN)):
            axes.axvspan(*window, color=INK, alpha=0.05, lw=0, label="evaluation window")
            axes.fill_between(
                time,
                -3 * sigma / unit,
                3 * sigma / unit,
                color=BLUE,
                alpha=0.18,
                lw=0,
                label="3 sigma of the filter",
            )
            axes.plot(
                run["bound_time"],
                3 * bound / unit,
                "--",
                color=ORANGE,
                lw=1.2,
                label="3 sigma of the Cramer-Rao bound",
            )
            axes.plot(run["bound_time"], -3 * bound / unit, "--", color=ORANGE, lw=1.2)
            axes.plot(time, error / unit, color=BLUE, lw=1.3, label="heading error")
        _limit(whole, np.abs(error).max() / DEGREE, floor=1.0)
        whole.set_ylabel("deg")
        whole.set_title("Heading error: estimated minus true")
        whole.legend(loc="upper right", ncols=2)
        inside = time >= window[0]
        _limit(
            end,
            max(np.abs(error[inside]).max(), 3.3 * sigma[inside].max(), 3.3 * bound[-1]) / ARCMIN,
            floor=1.0,
        )
        end.set_ylabel("arcmin")
        end.set_xlabel("time [s]")
        return figure


def heading(run: xr.Dataset) -> Figure:
    """Heading over time with 3 sigma, for a run without truth."""
    time, estimate = run["time"].values, np.unwrap(run["nav.heading"].values) / DEGREE
    sigma = 3 * run["heading_sigma"].values / DEGREE
    final = estimate[-1]
    with _figure(rows=2, height=6.2, sharex=True) as (figure, (whole, end)):
        for axes in (whole, end):
            axes.fill_between(
                time, estimate - sigma, estimate + sigma, color=BLUE, alpha=0.18, lw=0, label="3 sigma"
            )
            axes.plot(time, estimate, color=BLUE, lw=1.3, label="heading")
            axes.set_ylabel("deg")
        whole.set_title("Heading, clockwise from north")
        whole.legend(loc="upper right")
        late = time >= (time[0] + time[-1]) / 2
        reach = max(1.2 * np.abs(estimate[late] - final).max(), 1.2 * sigma[late].max())
        end.set_ylim(final - reach, final + reach)
        end.ticklabel_format(useOffset=False)
        end.set_xlabel("time [s]")
        return figure


def states(run: xr.Dataset) -> Figure:
    """Every state: its error where the truth is known, else its estimate, with 3 sigma."""
    time = run["time"].values
    panels = list(_state_panels(run))
    with _figure(rows=5, columns=2, height=10.0, sharex=True) as (figure, axes):
        for panel, (title, unit, values, sigma) in zip(axes, panels, strict=True):
            panel.fill_between(time, -3 * sigma, 3 * sigma, color=BLUE, alpha=0.18, lw=0)
            panel.plot(time, values, color=BLUE, lw=1.0)
            panel.axhline(0, color=INK, lw=0.5, alpha=0.5)
            panel.set_title(title, fontsize=9)
            panel.set_ylabel(unit)
            settled = slice(len(time) // 5, None)
            _limit(panel, max(np.abs(values[settled]).max(), 3 * sigma[settled].max()), floor=1e-9)
        for panel in axes[-2:]:
            panel.set_xlabel("time [s]")
        what = "errors" if "truth.heading" in run else "estimates"
        figure.suptitle(f"States: {what} with 3 sigma (vertical scale from 20 % of the run on)")
        return figure


def innovations(run: xr.Dataset) -> Figure:
    """Innovation of each channel with its 3 sigma; fixes that were not used stand out."""
    time, used = run["fix_time"].values, run["fix_used"].values
    channels = measured_channels(run)
    with _figure(rows=len(channels), height=2.6 * len(channels) + 0.8, sharex=True) as (figure, axes):
        for i, panel in zip(channels, axes, strict=True):
            value, sigma = run["innovation"].values[:, i], run["innovation_sigma"].values[:, i]
            panel.fill_between(time, -3 * sigma, 3 * sigma, color=BLUE, alpha=0.18, lw=0, label="3 sigma")
            panel.plot(time[used], value[used], ".", color=BLUE, ms=3.5, label="used")
            panel.plot(time[~used], value[~used], "x", color=ORANGE, ms=6, mew=1.6, label="rejected")
            panel.set_ylabel(f"{COMPONENTS[i]} [m/s]")
            settled = time > time[0] + 0.05 * (time[-1] - time[0])
            _limit(panel, max(3.3 * sigma[settled].max(), 1.1 * np.abs(value[settled]).max()), floor=1e-6)
        axes[0].legend(loc="upper right", ncols=3)
        axes[0].set_title("Innovations of the velocity fixes")
        axes[-1].set_xlabel("time [s]")
        return figure


def nis(run: xr.Dataset) -> Figure:
    """Normalised innovation squared with the chi-square limits of one fix and of the running mean."""
    time, value, used = run["fix_time"].values, run["nis"].values, run["fix_used"].values
    channels = len(measured_channels(run))
    with _figure(rows=2, height=5.6, sharex=True) as (figure, (each, mean)):
        each.plot(time[used], value[used], ".", color=BLUE, ms=3.5, label="used")
        each.plot(time[~used], value[~used], "x", color=ORANGE, ms=6, mew=1.6, label="rejected")
        for limit, share in zip(chi_square_interval(channels, 0.98), ("1 %", "99 %"), strict=True):
            each.axhline(limit, color=ORANGE, ls="--", lw=1, label=f"{share} of a consistent filter")
        each.set_yscale("log")
        each.set_ylim(max(1e-3, value[value > 0].min() / 2 if (value > 0).any() else 1e-3), None)
        each.set_ylabel("NIS")
        each.set_title(f"Normalised innovation squared, {channels} channels")
        each.legend(loc="lower right", ncols=2)
        counted = np.arange(1, used.sum() + 1)
        intervals = np.array([chi_square_interval(int(n) * channels) for n in counted]).reshape(-1, 2)
        mean.fill_between(
            time[used],
            *(intervals / (counted[:, None] * channels)).T,
            color=ORANGE,
            alpha=0.2,
            lw=0,
            label="95 % interval",
        )
        mean.plot(
            time[used],
            np.cumsum(value[used]) / (counted * channels),
            color=BLUE,
            lw=1.3,
            label="mean NIS / channels so far",
        )
        mean.set_ylim(0, 3)
        mean.set_ylabel("mean NIS / channels")
        mean.set_xlabel("time [s]")
        mean.legend(loc="upper right", ncols=2)
        return figure


def corrections(run: xr.Dataset) -> Figure:
    """What the corrector did: weights of the channels, effective gamma, fixes that were rejected, status."""
    time = run["fix_time"].values
    with _figure(rows=3, height=6.4, sharex=True) as (figure, (weights, gamma, status)):
        for i in measured_channels(run):
            values = run["measurement_weight"].values[:, i]
            style = ("-", "--", ":")[i]
            weights.step(time, values, style, where="mid", lw=1.2, color=FILTERS[i], label=COMPONENTS[i])
        weights.set_ylim(-0.08, 1.12)
        weights.set_ylabel("weight")
        weights.set_title("What the corrector did with each fix")
        weights.legend(loc="center right", ncols=3)
        _gamma(run, gamma)
        flag = run["status"]
        names, values = flag.attrs["flag_meanings"].split(), flag.attrs["flag_values"]
        status.step(run["time"], flag.values, where="post", color=BLUE, lw=1.6)
        status.set_yticks(values, names)
        status.set_ylim(min(values) - 0.5, max(values) + 0.5)
        status.set_xlabel("time [s]")
        rejected = time[~run["fix_used"].values]
        status.plot(
            rejected,
            np.full(len(rejected), min(values) - 0.25),
            "|",
            color=ORANGE,
            ms=9,
            mew=1.5,
            label="rejected fix",
        )
        status.legend(loc="upper right")
        return figure


def comparison(runs: xr.Dataset) -> Figure:
    """Heading errors of several filters on the same signals, and the bound."""
    time = runs["time"].values
    window = (runs.attrs["evaluation.start"], runs.attrs["evaluation.stop"])
    bound = runs["bound.heading_sigma"].values
    with _figure(rows=2, height=7.0, sharex=True) as (figure, (whole, end)):
        for axes, unit in ((whole, DEGREE), (end, ARCMIN)):
            axes.axvspan(*window, color=INK, alpha=0.05, lw=0)
            axes.fill_between(
                runs["bound_time"],
                -bound / unit,
                bound / unit,
                color=INK,
                alpha=0.14,
                lw=0,
                label="1 sigma of the Cramer-Rao bound",
            )
            for label, colour, line in zip(
                runs["filter"].values, cycle(FILTERS), cycle(("-", "--", "-.", ":")), strict=False
            ):
                axes.plot(
                    time,
                    runs["heading_error"].sel(filter=label) / unit,
                    line,
                    color=colour,
                    lw=1.4,
                    label=str(label),
                )
        whole.set_ylabel("deg")
        whole.set_title("Heading error of each filter on the same signals")
        whole.legend(loc="upper right", ncols=2)
        inside = time >= window[0]
        _limit(
            end,
            1.1 * np.abs(runs["heading_error"].values[:, inside]).max() / ARCMIN,
            floor=1.5 * float(bound[-1]) / ARCMIN,
        )
        end.set_ylabel("arcmin")
        end.set_xlabel("time [s]")
        return figure


def bound(data: xr.Dataset) -> Figure:
    """The bound of the heading along a trajectory."""
    window = (data.attrs["evaluation.start"], data.attrs["evaluation.stop"])
    with _figure(rows=1, height=3.8) as (figure, (axes,)):
        axes.axvspan(*window, color=INK, alpha=0.05, lw=0, label="evaluation window")
        axes.plot(
            data["bound_time"],
            data["bound.heading_sigma"] / ARCMIN,
            color=ORANGE,
            lw=1.6,
            label="sigma of the heading",
        )
        rms = data.attrs["bound.heading_rms"] / ARCMIN
        axes.plot(window, (rms, rms), ":", color=INK, lw=1.2, label=f"RMS over the window: {rms:.2f} arcmin")
        axes.set_yscale("log")
        axes.set_ylabel("arcmin")
        axes.set_xlabel("time [s]")
        axes.set_title(f"Posterior Cramer-Rao bound: {data.attrs['scenario']}")
        axes.legend(loc="upper right")
        return figure


def _gamma(run: xr.Dataset, axes: Axes) -> None:
    """Effective gamma of the H-infinity update, or a note that there is none."""
    time, gamma = run["fix_time"].values, run["robust.gamma_effective"].values
    feasible = run["robust.feasible"].values.astype(bool)
    active = gamma > 0
    axes.set_ylabel("effective gamma")
    if not active.any():
        axes.set_yticks([])
        axes.text(
            0.5, 0.5, "no H-infinity corrector", transform=axes.transAxes, ha="center", va="center", color=INK
        )
        return
    axes.plot(time[active], gamma[active], color=BLUE, lw=1.2, label="gamma in effect")
    backed = active & ~feasible
    axes.plot(time[backed], gamma[backed], ".", color=ORANGE, ms=5, label="backed off (infeasible)")
    if gamma[active].max() > 10 * gamma[active].min():
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, 1.4 * gamma[active].max())
    axes.legend(loc="upper right", ncols=2)


def _state_panels(run: xr.Dataset) -> Iterator[tuple[str, str, Array, Array]]:
    """Title, unit, values and sigma of each state, in display units; pairs stand side by side."""
    known = "truth.heading" in run
    sources = {
        "misalignment": (wrap(run["attitude_error" if known else "misalignment"].values), "arcmin", ARCMIN),
        "velocity": (run["nav.velocity"].values - (run["truth.velocity"].values if known else 0), "m/s", 1.0),
        "gyro_bias": (
            run["gyro_bias"].values - (run["truth.gyro_bias"].values if known else 0),
            "deg/h",
            DEG_PER_HOUR,
        ),
        "accelerometer_bias": (
            run["accelerometer_bias"].values - (run["truth.accelerometer_bias"].values if known else 0),
            "mg",
            MILLI_G,
        ),
    }
    for name, axis, index in (
        *(("misalignment", axis, i) for i, axis in enumerate(("east", "north"))),
        *(("velocity", axis, i) for i, axis in enumerate(("east", "north"))),
        *(("accelerometer_bias", axis, i) for i, axis in enumerate(("right", "forward"))),
        *(("gyro_bias", axis, i) for i, axis in enumerate(("right", "forward"))),
        ("misalignment", "up", 2),
        ("gyro_bias", "up", 2),
    ):
        values, unit, size = sources[name]
        sigma = run[f"{name}_sigma"].values[:, index]
        yield f"{name.replace('_', ' ')} {axis}", unit, values[:, index] / size, sigma / size


def _limit(axes: Axes, reach: float, floor: float) -> None:
    """Symmetric limits of the vertical axis."""
    reach = max(1.08 * reach, floor)
    axes.set_ylim(-reach, reach)


@contextmanager
def _figure(
    *, rows: int, height: float, columns: int = 1, sharex: bool = False
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure and its axes in reading order."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, height), layout="constrained")
        axes = figure.subplots(rows, columns, sharex=sharex, squeeze=False)
        yield figure, list(axes.flat)
