"""Figures of a run, by name, once for all that tells figures: verdicts, campaigns, papers, bands.

A figure is a number of one filter of a run over a window, and says how that of many runs is made of it. A
package of somebody else's adds one by an entry point of the group `truenorth.figures` ::

    [project.entry-points."truenorth.figures"]
    heading_90 = "my_figures:heading_90"

whose function is marked as a figure::

    import numpy as np
    from sim_scenarios.metrics.errors import ERRORS
    from sim_scenarios.metrics.figures import figure
    from sim_scenarios.timeline import within

    @figure(title="90th percentile of the heading error", unit="rad")
    def heading_90(run, window):
        \"\"\"Size of the heading error that is not exceeded for 90 % of the window.\"\"\"
        error = within(run["time"].values, ERRORS["heading"].of(run), *window)
        return np.percentile(np.abs(error), 90)

From then on `run` and `compare` tell it, campaigns keep it, and papers and bands know its name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Final

import xarray as xr

from sim_scenarios.errors import InputError
from sim_scenarios.metrics.figures.definition import Figure, figure
from sim_scenarios.metrics.figures.shipped import FIGURES, OUTPUTS, certainty_of
from sim_scenarios.metrics.folds import OF_SUMS
from sim_scenarios.timeline import Window

__all__ = [
    "FIGURES",
    "GROUP",
    "OUTPUTS",
    "Figure",
    "certainty_of",
    "figure",
    "known",
    "over_evaluation",
    "own",
    "window",
]

GROUP: Final = "truenorth.figures"
"""Of the entry points by which somebody else adds a figure."""


def window(run: xr.Dataset) -> Window:
    """Start and stop of the evaluation of a run [s]."""
    return float(run.attrs["evaluation.start"]), float(run.attrs["evaluation.stop"])


def over_evaluation(run: xr.Dataset) -> Callable[[str], float]:
    """What gives the figures of a run over its evaluation window, by name."""
    found, evaluation = known(), window(run)
    return lambda name: found[name].of(run, evaluation)


def known() -> dict[str, Figure]:
    """All figures that there are, by name, those of entry points last."""
    return {**FIGURES, **own()}


@cache
def own() -> Mapping[str, Figure]:
    """Figures that other packages add by entry points, by name.

    Raises
    ------
    InputError
        An entry point cannot be imported, is no figure, or has the name of another one.
    """
    found: dict[str, Figure] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        where = f"figure {point.name} = {point.value} (entry point {GROUP})"
        if point.name in FIGURES or point.name in found:
            raise InputError(f"{where}: there is a figure of that name already")
        if not point.name.isidentifier():
            raise InputError(f"{where}: its name must have letters, digits and _ only")
        found[point.name] = _own(point, where)
    return found


def _own(point: EntryPoint, where: str) -> Figure:
    try:
        loaded: Any = point.load()
    except Exception as error:  # whatever an import raises
        raise InputError(f"{where}: {type(error).__name__}: {error}") from error
    if not isinstance(loaded, Figure):
        raise InputError(f"{where}: must be a function marked as a figure, not {loaded!r}")
    if loaded.fold is OF_SUMS:
        raise InputError(f"{where}: its fold is for figures that come with the package")

    def of(run: xr.Dataset, span: Window) -> float:
        try:
            return float(loaded.of(run, span))
        except InputError:
            raise
        except Exception as error:  # whatever it raises
            raise InputError(f"{where}: {type(error).__name__}: {error}") from error

    return replace(loaded, name=point.name, of=of)
