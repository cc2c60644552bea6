"""Every state of a filter: its error where the truth is known, else its estimate, with 3 sigma."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from sim_scenarios.attitude import wrap
from sim_scenarios.plots.style import BAND, BLUE, BODY_AXES, INK, NAVIGATION_AXES, figure, largest, limit
from sim_scenarios.units import ARCMIN, DEGREE, HOUR, STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = np.ndarray[Any, np.dtype[np.float64]]


class Quantity(NamedTuple):
    """Three states of a kind: what holds error, estimate and truth, and the unit to draw them in."""

    error: str
    estimate: str
    truth: str
    axes: tuple[str, ...]
    unit: str
    size: float


QUANTITIES = {
    "misalignment": Quantity("attitude_error", "misalignment", "", NAVIGATION_AXES, "arcmin", ARCMIN),
    "velocity": Quantity("velocity_error", "nav.velocity", "", NAVIGATION_AXES, "m/s", 1.0),
    "position": Quantity("position_error", "", "", NAVIGATION_AXES, "m", 1.0),
    "gyro_bias": Quantity("", "gyro_bias", "truth.gyro_bias", BODY_AXES, "deg/h", DEGREE / HOUR),
    "accelerometer_bias": Quantity(
        "", "accelerometer_bias", "truth.accelerometer_bias", BODY_AXES, "mg", 1e-3 * STANDARD_GRAVITY
    ),
}


def states(run: xr.Dataset) -> Figure:
    """A panel for each state, three abreast."""
    time, known = run["time"].values, "attitude_error" in run
    shown = list(panels(run, known))
    rows = max(1, -(-len(shown) // 3))
    with figure(rows=rows, columns=3, height=2.1 * rows + 0.4, sharex=True) as (drawn, axes):
        for panel, (title, values, sigma) in zip(axes, shown, strict=False):
            centre = np.zeros_like(values) if known else values
            panel.fill_between(time, centre - 3 * sigma, centre + 3 * sigma, **BAND)
            panel.plot(time, values, color=BLUE, lw=1.0)
            panel.axhline(0, color=INK, lw=0.5, alpha=0.5)
            panel.set_title(title, fontsize=9)
            late = time >= time[0] + 0.2 * (time[-1] - time[0])
            limit(panel, largest(values[late], 3 * sigma[late]), floor=1e-9)
        for unused in axes[len(shown) :]:
            unused.set_axis_off()
        for lowest in axes[max(0, len(shown) - 3) : len(shown)]:
            lowest.set_xlabel("time [s]")
            lowest.tick_params(labelbottom=True)
        what = "errors" if known else "estimates"
        drawn.suptitle(f"States: {what} with 3 sigma (vertical scale from 20 % of the run on)", y=0.995)
        return drawn


def panels(run: xr.Dataset, known: bool) -> Iterator[tuple[str, Array, Array]]:
    """Title, values and sigma of each state in display units; what is no state keeps its sigma."""
    for name, quantity in QUANTITIES.items():
        values = _values(run, quantity, known)
        if values is None or f"{name}_sigma" not in run:
            continue
        sigma = run[f"{name}_sigma"].values
        for i, axis in enumerate(quantity.axes):
            if (sigma[:, i] != sigma[0, i]).any():  # also where it ceases to be a number
                title = f"{name.replace('_', ' ')} {axis} [{quantity.unit}]"
                yield title, values[:, i] / quantity.size, sigma[:, i] / quantity.size


def _values(run: xr.Dataset, quantity: Quantity, known: bool) -> Array | None:
    """Errors of three states where the truth is known, else estimates; None of what is not."""
    if known and quantity.error:
        if quantity.error not in run:  # of a reference that knows an attitude alone
            return None
        error: Array = run[quantity.error].values
        return wrap(error) if quantity.unit == "arcmin" else error
    if quantity.estimate not in run or (known and quantity.truth not in run):
        return None
    estimate: Array = run[quantity.estimate].values
    return estimate - run[quantity.truth].values if known else estimate
