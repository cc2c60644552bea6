"""What a campaign keeps of every run: errors over time, and figures over the evaluation window.

The figures are those of `truenorth run` and `compare` (`metrics.figures`) to the last bit: they are taken at
the recording period of the scenario, before the errors over time are thinned out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.errors import InputError
from sim_scenarios.metrics import certainty
from sim_scenarios.metrics.certainty import DEVIATION, QUANTITIES
from sim_scenarios.metrics.errors import ERRORS as ALL_ERRORS
from sim_scenarios.metrics.errors import Error
from sim_scenarios.metrics.figures import FIGURES, GROUP, OUTPUTS, Figure, known, own
from sim_scenarios.metrics.figures import window as evaluation
from sim_scenarios.metrics.statistics import is_measured, tells_nis
from sim_scenarios.timeline import RESOLUTION, Window

Array = NDArray[np.float64]

ERRORS: Final[Mapping[str, Error]] = {
    name: ALL_ERRORS[name] for name in ("heading", "tilt", "velocity", "horizontal", "vertical")
}
"""Errors whose size over time and whose RMSE over the window are kept."""

BOUNDED: Final = ("heading", "horizontal")
"""Errors that a Cramer-Rao bound is known of, where the filter measures what it takes."""

SERIES: Final[Mapping[str, tuple[str, str]]] = {
    **{f"{name}_error": (error.unit, error.description) for name, error in ERRORS.items()},
    "heading_sigma": ("rad", "Sigma of the heading that the filter claims"),
    "velocity_sigma": ("m/s", "Sigma of the velocity that the filter claims, all three components together"),
    "position_sigma": ("m", "Sigma of the position that the filter claims, all three components together"),
    **{
        f"{name}{DEVIATION}": ("1", f"Error of the {name} in sigmas of the filter: the largest component")
        for name in QUANTITIES
    },
    "nis": ("1", "Normalised innovations squared of the fixes used since the time before, summed"),
    "nis_channels": ("1", "Channels of those fixes: the degrees of freedom of `nis`"),
}
"""Unit and description of what is kept over time; sigmas and deviations are NaN where the filter has none."""

OTHERS: Final = (
    *("scenario", "filter", "run", "seed", "time", "state", "seal", "fault_end"),
    *(f"{name}_bound{what}" for name in BOUNDED for what in ("", "_rms")),
)
"""Other variables of a campaign (see `store`), whose names no figure can have."""

KEPT: Final = (
    *(f"{name}_rmse" for name in ERRORS),
    "heading_end",
    "heading_sigma_rms",
    "convergence_time",
    "hand_over_time",
    "claimed_time",
    "claimed_deviation",
    "largest_claimed_deviation",
    "sure_time",
    "wrongly_sure_time",
    "longest_wrongly_sure",
    *(f"wrongly_sure_{name}_time" for name in QUANTITIES),
    "nis_sum",
    "nis_channels_sum",
    "used_fixes",
    "rejected_fixes",
    "success",
)
"""Figures that every campaign keeps, besides those that other packages add."""

RECORDED: Final = "recorded."
"""Beginning of the names of the errors at every recorded instant."""


@dataclass(frozen=True)
class Kept:
    """A figure that is kept of every run, over a window [s], or over that of the evaluation."""

    figure: Figure
    window: Window | None = None

    @property
    def name(self) -> str:
        """Of its variable."""
        return variable(self.figure.name, self.window)

    @property
    def description(self) -> str:
        """What it is, and when."""
        if self.window is None:
            return self.figure.description
        return "{}, {:g} to {:g} s".format(self.figure.description, *self.window)

    def of(self, run: xr.Dataset) -> float:
        """The figure of a run."""
        return self.figure.of(run, self.window or evaluation(run))


@dataclass(frozen=True)
class Asked:
    """What is kept of the runs of a campaign because something is expected of it.

    Attributes
    ----------
    figures : tuple of tuple of str and Window or None
        Names of figures, each with its window.
    errors : bool
        Whether the errors at every recorded instant are kept.
    """

    figures: tuple[tuple[str, Window | None], ...] = ()
    errors: bool = False

    def __iter__(self) -> Iterator[Kept]:
        """The figures, and those that they are made of over many runs."""
        for name, window in self.figures:
            one = known()[name]
            yield from (Kept(each, window) for each in (one, *one.parts))


NOTHING: Final = Asked()


def variable(figure: str, window: Window | None) -> str:
    """Name of the variable of a figure over a window."""
    return figure if window is None else "{}.{:g}-{:g}".format(figure, *window)


def figures(asked: Asked = NOTHING) -> dict[str, Kept]:
    """Figures that are kept of every run, by the names of their variables.

    Raises
    ------
    InputError
        One of another package has the name of another variable of a campaign.
    """
    if taken := [name for name in own() if name in (*SERIES, *OTHERS)]:
        raise InputError(
            f"figure {taken[0]} (entry point {GROUP}): a campaign has another variable of that name"
        )
    every = {**{name: Kept(FIGURES[name]) for name in KEPT}, **{n: Kept(one) for n, one in own().items()}}
    return {**every, **{one.name: one for one in asked}}


def outputs(asked: Asked = NOTHING) -> tuple[str, ...]:
    """Outputs of a filter that `kept` needs at every recorded instant or fix, where it has them."""
    needs = (name for one in figures(asked).values() for name in one.figure.needs)
    return tuple(dict.fromkeys((*OUTPUTS, *needs)))


def kept(run: xr.Dataset, period: float, asked: Asked = NOTHING) -> dict[str, Array]:
    """What a campaign keeps of one filter of a run.

    Parameters
    ----------
    run : xarray.Dataset
        Of one filter, with the attributes of `sim_scenarios.run`.
    period : float
        Between the times of the series [s], a multiple of the recording period.
    asked : Asked
        What is expected of the campaign.

    Returns
    -------
    dict of str to ndarray
        Series, shape (times,), figures, shape (), and errors, shape (instants[, 3]); without the series of
        NIS of a filter that does not tell it.
    """
    run = certainty.with_deviations(run)
    stride = round(period / float(run["time"].values[1] - run["time"].values[0]))
    series = {f"{name}_error": error.size(run)[::stride] for name, error in ERRORS.items()}
    series |= {f"{name}_sigma": _sigma(run, name)[::stride] for name in QUANTITIES}
    deviations = certainty.deviations(run)
    series |= {f"{name}{DEVIATION}": values[::stride] for name, values in deviations.items()}
    if tells_nis(run):
        series["nis"], series["nis_channels"] = _nis(run, period, len(series["heading_sigma"]))
    errors = {f"{RECORDED}{name}": run[name].values for name in recording.ERRORS} if asked.errors else {}
    return {**series, **{name: np.asarray(one.of(run)) for name, one in figures(asked).items()}, **errors}


def _sigma(run: xr.Dataset, name: str) -> Array:
    """Sigma of a quantity over time, shape (rows,): root of the sum of the squares of its components."""
    if f"{name}_sigma" not in run:
        return np.full(run.sizes["time"], np.nan)
    sigma: Array = run[f"{name}_sigma"].values
    return sigma if sigma.ndim == 1 else np.sqrt(np.sum(sigma**2, axis=1))


def _nis(run: xr.Dataset, period: float, rows: int) -> tuple[Array, Array]:
    """NIS and channels of the fixes that were used, summed up to each row."""
    used = run["fix_used"].values
    row = np.ceil((run["fix_time"].values[used] - RESOLUTION) / period).astype(int)
    row, kept_in = np.clip(row, 0, rows - 1), row < rows
    nis, channels = run["nis"].values[used] * kept_in, is_measured(run)[used].sum(axis=1) * kept_in
    summed = np.array([np.bincount(row, weights, rows) for weights in (nis, channels)], dtype=np.float64)
    return summed[0], summed[1]
