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


def is_whole(fixes: FixTable) -> NDArray[np.bool_]:
    """Whether position and velocity of each fix were measured, all three components, shape (n,)."""
    measured = np.isfinite(np.hstack((fixes.position, fixes.velocity)))
    return np.asarray(measured.all(axis=1))


def before_the_first(fixes: FixTable) -> NDArray[np.bool_]:
    """Whether each fix is what receivers write until they have one, shape (n,).

    At latitude 0, longitude 0 exactly, before the first position elsewhere; where there is none, no fix is.
    """
    elsewhere = np.flatnonzero((np.nan_to_num(fixes.position[:, :2]) != 0).any(axis=1))
    first = elsewhere[0] if len(elsewhere) else 0
    nowhere = np.asarray((fixes.position[:, :2] == 0).all(axis=1))
    nowhere[first:] = False
    return nowhere


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
