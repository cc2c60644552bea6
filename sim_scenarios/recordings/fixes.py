"""What the fixes of a recording tell besides what they hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.earth import displacement
from sim_scenarios.recordings.tables import FixTable

Array = NDArray[np.float64]


def selected(fixes: FixTable, rows: NDArray[np.bool_]) -> FixTable:
    """Some of the fixes."""
    return replace(fixes, **{name: values[rows] for name, values in vars(fixes).items()})


def velocities(fixes: FixTable) -> Array:
    """Velocity at each fix, east, north, up [m/s], shape (n, 3).

    As measured; a component that no fix has measured follows from the positions. Not a number: unknown.
    """
    measured = np.isfinite(fixes.velocity).any(axis=0)
    placed = np.isfinite(fixes.position).all(axis=1)
    velocity = np.full_like(fixes.velocity, np.nan)
    if np.count_nonzero(placed) > 1:
        position, time = fixes.position[placed], fixes.time[placed]
        velocity[placed] = np.gradient(displacement(position, position[:1]), time, axis=0)
    return np.where(measured, fixes.velocity, velocity)
