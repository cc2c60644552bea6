"""What the fixes of a recording tell besides what they hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.earth import displacement
from sim_scenarios.recordings import stamps
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


def with_velocities_later(fixes: FixTable, offset: float) -> FixTable:
    """Fixes whose velocities held so many seconds after their stamps.

    They are interpolated to the stamps, each component between those that have it; where there is a gap
    between the two that a stamp lies between, it is not a number.
    """
    velocity = np.full_like(fixes.velocity, np.nan)
    for axis, said in enumerate(fixes.velocity.T):
        has = np.isfinite(said)
        if not has.any():
            continue
        held = fixes.time[has] + offset
        moved = np.interp(fixes.time, held, said[has], np.nan, np.nan)
        after = np.searchsorted(held, fixes.time)
        apart = np.append(stamps.gaps(held), True)[after]
        moved[apart & (held[np.minimum(after, len(held) - 1)] != fixes.time)] = np.nan
        velocity[:, axis] = moved
    return replace(fixes, velocity=velocity)


def no_surer_than(
    fixes: FixTable,
    *,
    position: float | None = None,
    height: float | None = None,
    velocity: float | None = None,
) -> FixTable:
    """Fixes whose sigmas are at least so large [m], [m], [m/s]; what they do not tell stays untold."""
    least = np.array([position, position, height], dtype=float), np.full(3, velocity, dtype=float)
    told = fixes.position_sigma, fixes.velocity_sigma
    raised = (np.where(s > 0, np.fmax(s, a), s) for s, a in zip(told, least, strict=True))
    return replace(fixes, **dict(zip(("position_sigma", "velocity_sigma"), raised, strict=True)))


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
