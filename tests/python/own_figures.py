"""Figures as a package of somebody else's would bring them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from sim_scenarios.metrics.errors import ERRORS
from sim_scenarios.metrics.figures import figure
from sim_scenarios.metrics.folds import LAST, OF_SUMS
from sim_scenarios.timeline import Window, within


@figure(title="largest size of the heading", unit="rad", fold=LAST, needs=["robust.gamma_effective"])
def heading_peak(run: xr.Dataset, window: Window) -> float:
    """The largest size of the heading error
    in the window.
    """
    return float(np.max(np.abs(within(run["time"].values, ERRORS["heading"].of(run), *window))))


@figure(title="sums", fold=OF_SUMS)
def sums(run: xr.Dataset, window: Window) -> float:  # noqa: ARG001
    """Of nothing."""
    return 0.0


@figure(title="fails")
def fails(run: xr.Dataset, window: Window) -> float:  # noqa: ARG001
    """Cannot be told."""
    raise ZeroDivisionError("of nothing")


def no_figure() -> float:
    """Is not marked."""
    return 0.0
