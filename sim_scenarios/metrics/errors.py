"""Errors of one filter over time, by name: what figures, series and pictures are made of.

Angles wrap here, and where sigmas are held against them (`certainty`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import NAVIGATION_FILTER

Array = NDArray[np.float64]

ANGLES: Final = ("attitude_error", "heading_error")
"""Variables of a run that wrap."""


@dataclass(frozen=True)
class Error:
    """An error of what a filter puts out, estimated minus true.

    Attributes
    ----------
    title, unit, description : str
        The unit is of SI.
    variable : str
        Of a run (see `recording`).
    axes : int, slice or None
        Which of its components, east, north, up; None of a scalar.
    """

    title: str
    unit: str
    description: str
    variable: str
    axes: int | slice | None = None

    def of(self, run: xr.Dataset) -> Array:
        """Components over time, shape (times,) or (times, k); NaN of a run that does not know it."""
        if self.variable not in run:
            return np.full(run.sizes["time"], np.nan)
        values = _wrapped(run, self.variable)
        return values if self.axes is None else values[:, self.axes]

    def size(self, run: xr.Dataset) -> Array:
        """Over time, shape (times,): signed where it is a scalar, the length where it is a vector."""
        values = self.of(run)
        return values if values.ndim == 1 else np.sqrt(np.sum(values**2, axis=1))


def _components(what: str, unit: str) -> dict[str, Error]:
    return {
        f"{what}_{axis}": Error(
            f"{what.title()} {axis}", unit, f"Error of the {what} {axis}", f"{what}_error", i
        )
        for i, axis in enumerate(("east", "north", "up"))
    }


ERRORS: Final[Mapping[str, Error]] = {
    "heading": Error("Heading", "rad", "Error of the heading, estimated minus true", "heading_error"),
    "tilt": Error(
        "Tilt",
        "rad",
        "Misalignment about the horizontal axes, both together",
        "attitude_error",
        slice(2),
    ),
    "velocity": Error(
        "Velocity", "m/s", "Error of the velocity, all three components together", "velocity_error", slice(3)
    ),
    "horizontal": Error(
        "Horizontal position", "m", "Error of the horizontal position", "position_error", slice(2)
    ),
    "vertical": Error(
        "Vertical position", "m", "Error of the height, estimated minus true", "position_error", 2
    ),
    "position": Error(
        "Position", "m", "Error of the position, all three components together", "position_error", slice(3)
    ),
    "tilt_east": Error("Tilt about east", "rad", "Misalignment about east", "attitude_error", 0),
    "tilt_north": Error("Tilt about north", "rad", "Misalignment about north", "attitude_error", 1),
    "horizontal_velocity": Error(
        "Horizontal velocity", "m/s", "Error of the horizontal velocity", "velocity_error", slice(2)
    ),
    **_components("velocity", "m/s"),
    **_components("position", "m"),
}


def that_counts(attributes: Mapping[Any, Any]) -> str:
    """Error that a filter is judged by: heading of an alignment, horizontal position of navigation."""
    return "horizontal" if attributes.get("filter_fmu") == NAVIGATION_FILTER else "heading"


def root_mean_square(runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """The first of several runs with the root mean square over all of them in place of its errors."""
    first = runs[0]
    squares = {
        name: np.mean([np.square(_wrapped(run, name)) for run in runs], axis=0)
        for name in recording.ERRORS
        if name in first
    }
    made: xr.Dataset = first.assign(
        {name: (first[name].dims, np.sqrt(square)) for name, square in squares.items()}
    )
    return made


def _wrapped(run: xr.Dataset, variable: str) -> Array:
    values: Array = run[variable].values
    return wrap(values) if variable in ANGLES else values
