"""How sure a filter was, and whether it had reason to be.

A filter is *wrongly sure* while it reports convergence and a component of its error, of heading, velocity or
position (east, north, up), is beyond three of the sigmas that it puts out for it. What the filter does not
estimate has sigma 0 and does not count; an error that is no number is beyond any sigma.

Each component of a consistent filter is so for 0.27 % of the time, all k of them together for k times that at
most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.metrics.statistics import reports_convergence

Array = NDArray[np.float64]

WRONG: Final = 3.0
"""Sigmas of an error beyond which a report of convergence is wrong."""

QUANTITIES: Final = ("heading", "velocity", "position")

DEVIATION: Final = "_deviation"
"""End of the names of the errors in sigmas."""


@dataclass(frozen=True)
class Certainty:
    """For how long one filter of a run was sure, and wrongly so [s].

    Attributes
    ----------
    sure : float
        Time with convergence reported.
    wrongly : float
        The part of it with a component beyond `WRONG` sigmas.
    longest : float
        The longest uninterrupted stretch of it.
    wrongly_in : mapping of str to float
        The same by quantity, of which several may be wrong at once.
    """

    sure: float
    wrongly: float
    longest: float
    wrongly_in: Mapping[str, float]

    def headline(self) -> dict[str, str]:
        """What a verdict says of it: nothing where it did not happen."""
        if self.wrongly == 0:
            return {}
        where = ", ".join(name for name, time in self.wrongly_in.items() if time > 0)
        spans = f"{self.wrongly:.1f} s of {self.sure:.1f} s, longest {self.longest:.1f} s"
        return {"Wrongly sure": f"{spans}: {where} beyond {WRONG:g} of its sigmas"}

    def figures(self) -> dict[str, Any]:
        """Figures for machines."""
        return {
            "sure_for_s": self.sure,
            "wrongly_sure_for_s": self.wrongly,
            "longest_wrongly_sure_s": self.longest,
        }


def of_run(run: xr.Dataset) -> Certainty:
    """Certainty of one filter of a run; each recorded instant stands for a recording period."""
    time, sure = run["time"].values, reports_convergence(run)
    wrongly = {name: sure & (values > WRONG) for name, values in deviations(run).items()}
    somewhere = np.any([np.zeros_like(sure), *wrongly.values()], axis=0)
    period = float(time[-1] - time[-2])
    return Certainty(
        sure=period * int(sure.sum()),
        wrongly=period * int(somewhere.sum()),
        longest=period * longest_stretch(somewhere),
        wrongly_in={name: period * int(rows.sum()) for name, rows in wrongly.items()},
    )


def deviations(run: xr.Dataset) -> dict[str, Array]:
    """Size of the error in sigmas of the filter over time, by quantity that the filter has a sigma of.

    Returns
    -------
    dict of str to ndarray, shape (times,)
        The largest among the components that are states; NaN without one. The variables `<name>_deviation`
        of a run that has them.
    """
    if known := [name for name in QUANTITIES if f"{name}{DEVIATION}" in run.variables]:
        return {name: run.variables[f"{name}{DEVIATION}"].values for name in known}
    return {
        name: _deviation(
            wrap(run["heading_error"].values) if name == "heading" else run[f"{name}_error"].values,
            run[f"{name}_sigma"].values,
        )
        for name in QUANTITIES
        if f"{name}_error" in run and f"{name}_sigma" in run
    }


def with_deviations(run: xr.Dataset) -> xr.Dataset:
    """A run with the variables of `deviations`, so that every figure that asks for them finds them."""
    found: xr.Dataset = run.assign(
        {f"{name}{DEVIATION}": ("time", values) for name, values in deviations(run).items()}
    )
    return found


def longest_stretch(condition: NDArray[np.bool_]) -> int:
    """Length of the longest uninterrupted row of true elements."""
    edges = np.flatnonzero(np.diff(condition, prepend=False, append=False))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _deviation(error: Array, sigma: Array) -> Array:
    error, sigma = (values.reshape(len(values), -1) for values in (error, sigma))
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.nan_to_num(np.abs(error) / sigma, nan=np.inf, posinf=np.inf)
    is_state = sigma != 0
    largest: Array = np.max(np.where(is_state, size, 0.0), axis=1)
    return np.where(is_state.any(axis=1), largest, np.nan)
