"""Pictures of integrated navigation: errors of position, velocity and attitude."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from sim_scenarios.attitude import wrap
from sim_scenarios.plots.style import BLUE, ORANGE, figure, largest, lines, shade_window
from sim_scenarios.units import ARCMIN

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = np.ndarray[Any, np.dtype[np.float64]]


def navigation_error(run: xr.Dataset) -> Figure:
    """Errors of one filter, with what the filter claims."""
    with figure(rows=5, height=9.5, sharex=True) as (drawn, axes):
        for panel, (title, error, sigma) in zip(axes, magnitudes(run), strict=True):
            shade_window(panel, run)
            panel.plot(run["time"], error, color=BLUE, lw=1.0, label="error")
            if sigma is not None:
                panel.plot(run["time"], sigma, "--", color=ORANGE, lw=1.2, label="1 sigma of the filter")
            panel.set_ylabel(title)
            _from_zero(panel, run, error)
        axes[0].set_title("Magnitude of the navigation errors")
        axes[0].legend(loc="upper right", ncols=2)
        axes[-1].set_xlabel("time [s]")
        return drawn


def comparison(runs: xr.Dataset) -> Figure:
    """Errors of several filters on the same signals."""
    with figure(rows=5, height=10.5, sharex=True) as (drawn, axes):
        reaches = [0.0] * len(axes)
        for label, colour, dashes in lines(runs["filter"].values):
            for i, (title, error, _) in enumerate(magnitudes(runs.sel(filter=label))):
                axes[i].plot(runs["time"], error, dashes, color=colour, lw=1.2, label=label)
                axes[i].set_ylabel(title)
                inside = runs["time"].values >= runs.attrs["evaluation.start"]
                reaches[i] = max(reaches[i], largest(error[inside]))
        for panel, reach in zip(axes, reaches, strict=True):
            shade_window(panel, runs)
            panel.set_ylim(0, 1.1 * reach or 1.0)
        axes[0].set_title("Magnitude of the navigation errors of each filter on the same signals")
        axes[0].legend(loc="upper right", ncols=2)
        axes[-1].set_xlabel("time [s]")
        return drawn


def magnitudes(run: xr.Dataset) -> Iterator[tuple[str, Array, Array | None]]:
    """Title with unit, magnitude of the error, and its sigma where the filter has one."""
    for title, name, sigma, axes, unit in (
        ("horizontal [m]", "position_error", "position_sigma", slice(0, 2), 1.0),
        ("vertical [m]", "position_error", "position_sigma", slice(2, 3), 1.0),
        ("velocity [m/s]", "velocity_error", "velocity_sigma", slice(0, 3), 1.0),
        ("tilt [arcmin]", "attitude_error", "misalignment_sigma", slice(0, 2), ARCMIN),
        ("heading [arcmin]", "heading_error", "heading_sigma", None, ARCMIN),
    ):
        error = run[name].values if axes is not None else run[name].values[:, None]
        claimed = None
        if sigma in run:
            claimed = run[sigma].values if axes is not None else run[sigma].values[:, None]
            claimed = np.linalg.norm(claimed[:, axes or slice(None)], axis=1) / unit
        if unit == ARCMIN:
            error = wrap(error)
        yield title, np.linalg.norm(error[:, axes or slice(None)], axis=1) / unit, claimed


def _from_zero(panel: Any, run: xr.Dataset, error: Array) -> None:
    inside = run["time"].values >= run.attrs["evaluation.start"]
    panel.set_ylim(0, 1.3 * largest(error[inside]) or 1.0)
