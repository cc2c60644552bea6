"""Runs of one filter with errors that are made up, as `sim_scenarios.run` gives them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike


def run_with(
    time: ArrayLike, *, window: tuple[float, float] | None = None, limit: float = 1.0, **errors: ArrayLike
) -> xr.Dataset:
    """A run at some instants [s] with errors by name: `heading`, and `attitude`, `velocity`, `position` with
    three components each. They are those of every instant, or of each; what is not named is 0.
    """
    instants = np.asarray(time, dtype=float)

    def course(name: str, *axes: int) -> np.ndarray:
        return np.broadcast_to(np.asarray(errors.get(name, 0.0), dtype=float), (len(instants), *axes))

    start, stop = window or (float(instants[0]), float(instants[-1]))
    vectors = {name: course(name, 3) for name in ("attitude", "velocity", "position")}
    return xr.Dataset(
        {
            "heading_error": ("time", course("heading")),
            **{f"{name}_error": (("time", "axis3"), values) for name, values in vectors.items()},
        },
        coords={"time": instants},
        attrs={
            "evaluation.start": start,
            "evaluation.stop": stop,
            "evaluation.heading_limit": limit,
            "evaluation.horizontal_limit": limit,
        },
    )
