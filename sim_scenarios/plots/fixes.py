"""What each fix brought, and what the corrector did with it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from sim_scenarios.metrics.statistics import chi_square_interval, is_measured, measured_channels
from sim_scenarios.plots.style import (
    BAND,
    BLUE,
    COLOURS,
    DASHES,
    NAVIGATION_AXES,
    ORANGE,
    figure,
    largest,
    limit,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

USED: dict[str, Any] = {"color": BLUE, "ms": 3.5, "label": "used"}
REJECTED: dict[str, Any] = {"color": ORANGE, "ms": 6, "mew": 1.6, "label": "rejected"}


def innovations(run: xr.Dataset) -> Figure:
    """Innovation of each channel with its 3 sigma; fixes that were not used stand out."""
    time, used = run["fix_time"].values, run["fix_used"].values
    channels, units = measured_channels(run), run["innovation"].attrs["units"].split()
    with figure(rows=len(channels), height=2.6 * len(channels) + 0.8, sharex=True) as (drawn, axes):
        for i, panel in zip(channels, axes, strict=True):
            value, sigma = run["innovation"].values[:, i], run["innovation_sigma"].values[:, i]
            panel.fill_between(time, -3 * sigma, 3 * sigma, label="3 sigma", **BAND)
            panel.plot(time[used], value[used], ".", **USED)
            panel.plot(time[~used], value[~used], "x", **REJECTED)
            unit = units[i] if len(units) > 1 else units[0]  # one for each element, if they differ
            panel.set_ylabel(f"{_axis(i)} [{unit}]")
            settled = time >= time[0] + 0.05 * (time[-1] - time[0])
            limit(panel, largest(3.3 * sigma[settled], 1.1 * value[settled]), floor=1e-6)
        axes[0].legend(loc="upper right", ncols=3)
        axes[0].set_title("Innovations of the fixes")
        axes[-1].set_xlabel("time [s]")
        return drawn


def standardised_innovations(run: xr.Dataset) -> Figure:
    """Innovations in units of their sigma, positions or ranges above, velocities or range rates below."""
    time, used, measured = run["fix_time"].values, run["fix_used"].values, is_measured(run)
    halves = np.array_split(measured_channels(run), 2)
    sigma = np.where(measured, run["innovation_sigma"].values, np.nan)
    standardised = run["innovation"].values / sigma
    with figure(rows=2, height=6.0, sharex=True) as (drawn, axes):
        for panel, channels in zip(axes, halves, strict=True):
            values = standardised[:, channels]
            panel.axhspan(-3, 3, label="3 sigma", **BAND)
            panel.plot(time[used], values[used], ".", color=BLUE, ms=2.5)
            panel.plot(time[~used], values[~used], "x", color=ORANGE, ms=5, mew=1.4)
            reach = min(30.0, max(4.5, largest(values)))
            panel.set_ylim(-reach, reach)
            panel.set_ylabel(f"channels {channels[0] + 1} to {channels[-1] + 1}")
        axes[0].set_title("Innovations in units of their sigma; crosses belong to rejected fixes")
        axes[0].legend(loc="upper right")
        axes[-1].set_xlabel("time [s]")
        return drawn


def nis(run: xr.Dataset) -> Figure:
    """Normalised innovation squared with the chi-square limits of one fix and of the running mean."""
    time, value, used = run["fix_time"].values, run["nis"].values, run["fix_used"].values
    channels = is_measured(run).sum(axis=1)
    with figure(rows=2, height=5.6, sharex=True) as (drawn, (each, mean)):
        each.plot(time[used], value[used], ".", **USED)
        each.plot(time[~used], value[~used], "x", **REJECTED)
        limits = np.array([chi_square_interval(max(int(n), 1), 0.98) for n in channels])
        for edge, share in zip(limits.T, ("1 %", "99 %"), strict=True):
            each.plot(time, edge, color=ORANGE, ls="--", lw=1, label=f"{share} of a consistent filter")
        each.set_yscale("log")
        each.set_ylim(max(1e-3, value[value > 0].min() / 2 if (value > 0).any() else 1e-3), None)
        each.set_ylabel("NIS")
        few, many = int(channels.min()), int(channels.max())
        count = f"{many}" if few == many else f"{few} to {many}"
        each.set_title(f"Normalised innovation squared, {count} channels")
        each.legend(loc="lower right", ncols=2)
        counted = used & (channels > 0)  # a coarse stage compares a fix with nothing
        _draw_running_mean(mean, time[counted], value[counted], channels[counted])
        mean.set_xlabel("time [s]")
        return drawn


def corrections(run: xr.Dataset) -> Figure:
    """What the corrector did: weights of the channels, effective gamma, fixes that were rejected, status."""
    time = run["fix_time"].values
    with figure(rows=3, height=6.4, sharex=True) as (drawn, (weights, gamma, status)):
        _draw_weights(run, weights)
        _draw_gamma(run, gamma)
        flag = run["status"]
        names, values = flag.attrs["flag_meanings"].split(), flag.attrs["flag_values"]
        status.step(run["time"], flag.values, where="post", color=BLUE, lw=1.6)
        status.set_yticks(values, names)
        status.set_ylim(min(values) - 0.5, max(values) + 0.5)
        status.set_xlabel("time [s]")
        rejected = time[~run["fix_used"].values]
        level = np.full(len(rejected), min(values) - 0.25)
        status.plot(rejected, level, "|", color=ORANGE, ms=9, mew=1.5, label="rejected fix")
        status.legend(loc="upper right")
        return drawn


def _axis(channel: int) -> str:
    """Axis of a measured component; channels come in threes."""
    return NAVIGATION_AXES[channel % len(NAVIGATION_AXES)]


def _draw_running_mean(
    axes: Axes, time: np.ndarray[Any, Any], value: np.ndarray[Any, Any], channels: np.ndarray[Any, Any]
) -> None:
    """Mean NIS for each channel so far, and the interval that it should keep."""
    degrees = np.cumsum(channels)
    intervals = np.array([chi_square_interval(int(n)) for n in degrees]).reshape(-1, 2) / degrees[:, None]
    axes.fill_between(time, *intervals.T, color=ORANGE, alpha=0.2, lw=0, label="95 % interval")
    mean = np.cumsum(value) / degrees
    axes.plot(time, mean, color=BLUE, lw=1.3, label="mean NIS / channels so far")
    settled = mean[len(mean) // 20 :]
    axes.set_ylim(0, max(3.0, 1.1 * largest(settled)))
    axes.set_ylabel("mean NIS / channels")
    axes.legend(loc="upper right", ncols=2)


def _draw_weights(run: xr.Dataset, axes: Axes) -> None:
    """Weight of each channel; of many, the mean and the smallest."""
    time, weight, measured = run["fix_time"].values, run["measurement_weight"].values, is_measured(run)
    channels = measured_channels(run)
    if len(channels) <= len(NAVIGATION_AXES):
        for i in channels:
            label, j = _axis(i), i % len(NAVIGATION_AXES)
            axes.step(time, weight[:, i], DASHES[j], where="mid", lw=1.2, color=COLOURS[j], label=label)
    else:
        counted = np.where(measured, weight, np.nan)[measured.any(axis=1)]
        moments = time[measured.any(axis=1)]
        for (label, curve), colour, dashes in zip(
            {"mean": np.nanmean(counted, axis=1), "smallest": np.nanmin(counted, axis=1)}.items(),
            COLOURS,
            DASHES,
            strict=False,
        ):
            axes.step(moments, curve, dashes, where="mid", lw=1.2, color=colour, label=f"{label} of all")
    axes.set_ylim(-0.08, 1.12)
    axes.set_ylabel("weight")
    axes.set_title("What the corrector did with each fix")
    axes.legend(loc="center right", ncols=3)


def _draw_gamma(run: xr.Dataset, axes: Axes) -> None:
    """Effective gamma of the H-infinity update, or a note that there is none."""
    axes.set_ylabel("effective gamma")
    if "robust.gamma_effective" not in run or not (run["robust.gamma_effective"].values > 0).any():
        axes.set_yticks([])
        axes.text(0.5, 0.5, "no H-infinity corrector", transform=axes.transAxes, ha="center", va="center")
        return
    time, gamma = run["fix_time"].values, run["robust.gamma_effective"].values
    feasible, active = run["robust.feasible"].values.astype(bool), gamma > 0
    axes.plot(time[active], gamma[active], color=BLUE, lw=1.2, label="gamma in effect")
    backed = active & ~feasible
    axes.plot(time[backed], gamma[backed], ".", color=ORANGE, ms=5, label="backed off (infeasible)")
    if gamma[active].max() > 10 * gamma[active].min():
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, 1.4 * gamma[active].max())
    axes.legend(loc="upper right", ncols=2)
