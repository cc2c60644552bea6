"""What the runs of a case have measured: figures of each and of all together, of one filter or of two."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.metrics.errors import ERRORS
from sim_scenarios.metrics.figures import Figure, known
from sim_scenarios.studies.quantities import RECORDED, variable
from sim_scenarios.timeline import Window

Array = NDArray[np.float64]


class Measured(ABC):
    """Runs of the filters of a case. A figure without a window is that of the evaluation of the scenario."""

    @property
    @abstractmethod
    def window(self) -> Window:
        """That of the evaluation [s]."""

    @property
    @abstractmethod
    def count(self) -> int:
        """How many runs there are."""

    @abstractmethod
    def runs(self, label: str) -> Sequence[xr.Dataset]:
        """Those of a filter, with its errors at every recorded instant."""

    @abstractmethod
    def each(self, figure: Figure, label: str, window: Window | None) -> Array:
        """A figure of each run of a filter, in SI units, shape (runs,)."""

    def of_each(self, name: str, label: str, window: Window | None = None) -> Array:
        """A figure of each run of a filter, in the unit in which people read it, shape (runs,)."""
        figure = known()[name]
        return self.each(figure, label, window) / figure.reading.size

    def figure(self, name: str, label: str, window: Window | None = None, over: str | None = None) -> float:
        """A figure of a filter over all runs, in the unit in which people read it; over another filter's."""
        figure = known()[name]

        def of(label: str) -> float:
            return figure.folded(
                window or self.window, lambda one: self.each(one, label, window), lambda: self.runs(label)
            )

        return of(label) / (of(over) if over else figure.reading.size)

    def largest_difference(self, one: str, other: str) -> float:
        """Largest difference of any error of two filters at any time, in SI units."""
        differences = [
            np.max(np.abs(error.of(a) - error.of(b)))
            for name in ("heading", "tilt", "velocity", "position")
            for error in [ERRORS[name]]
            for a, b in zip(self.runs(one), self.runs(other), strict=True)
        ]
        return float(np.max(differences))


class Stored(Measured):
    """Those of a case of a campaign (see `store`). A run that stopped has NaN for every figure.

    Parameters
    ----------
    data : xarray.Dataset
        Results of the campaign.
    label : str
        Of the case.
    """

    def __init__(self, data: xr.Dataset, label: str) -> None:
        self._data = data.sel(scenario=label)
        self._attributes = json.loads(data.attrs["cases"])[label]["attributes"]

    @property
    def window(self) -> Window:
        """That of the evaluation [s]."""
        return self._attributes["evaluation.start"], self._attributes["evaluation.stop"]

    @property
    def count(self) -> int:
        """How many runs there are."""
        return int(self._data.sizes["run"])

    def runs(self, label: str) -> Sequence[xr.Dataset]:
        """Those of a filter, with its errors at every recorded instant."""
        time = self._data[f"{RECORDED}time"].values
        there = np.isfinite(time)
        errors = {name: self._data[f"{RECORDED}{name}"].sel(filter=label) for name in recording.ERRORS}
        loaded = {name: error.isel(instant=there).load() for name, error in errors.items()}
        return [
            xr.Dataset(
                {name: (("time", *error.dims[2:]), error.values[run]) for name, error in loaded.items()},
                coords={"time": time[there]},
                attrs=self._attributes,
            )
            for run in range(self.count)
        ]

    def each(self, figure: Figure, label: str, window: Window | None) -> Array:
        """A figure of each run of a filter, in SI units, shape (runs,)."""
        values: Array = self._data[variable(figure.name, window)].sel(filter=label).values
        return values
