"""An IMU whose gyros and accelerometers were recorded apart, each with stamps of its own.

The stamps of the gyros are kept, so that turns stay as they were measured. The velocity that the
accelerometers gained since their first sample is straight between their stamps; over a sample of the gyros it
grows by what is the sample's. Whatever the two rates are, nothing is lost and nothing counts twice.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.readers.contents import Inertial
from sim_scenarios.recordings.tables import Array

Flags = NDArray[np.bool_]

ROUNDING: Final = 1e-6
"""Of stamps [s]."""
HARDLY: Final = 0.01
"""Share of the samples of a half that must have been measured with the other: a wrong unit leaves less."""


def joined(
    gyros: Inertial, accelerometers: Inertial, where: tuple[str, str] = ("imu", "accelerometer")
) -> tuple[Inertial, list[str]]:
    """One IMU of its two halves.

    Parameters
    ----------
    gyros, accelerometers : Inertial
        With increasing stamps on one clock; of the first the angular part counts, of the second the forces.
    where : tuple of str
        From where they are, for sentences on what is wrong.

    Returns
    -------
    imu : Inertial
        Increments over those samples of the gyros during which the accelerometers measured.
    remarks : list of str
        What was left out.

    Raises
    ------
    InputError
        If one of them has fewer than two samples, or they were hardly measured together.
    """
    known = np.isfinite(accelerometers.force).all(axis=1)
    time, force = accelerometers.time[known], accelerometers.force[known]
    for half, of_half in zip(where, (gyros.time, time), strict=True):
        if len(of_half) < 2:
            raise InputError(f"{half}: has {len(of_half)} samples; an alignment needs many")
    begin, gyros_begin = _begin(time), _begin(gyros.time)
    covers, gyros_cover = (time - begin)[:, None], gyros.time - gyros_begin
    parts = np.hstack((force if accelerometers.increments else force * covers, covers))
    sums = np.cumsum(parts, axis=0)
    knots, at = np.unique(np.concatenate((time, begin)), return_index=True)
    sums = np.concatenate((sums, sums - parts))[at]
    grown = np.stack(
        [np.interp(gyros.time, knots, s) - np.interp(gyros_begin, knots, s) for s in sums.T], axis=-1
    )
    both = grown[:, 3] > gyros_cover - ROUNDING
    angle = gyros.angular if gyros.increments else gyros.angular * gyros_cover[:, None]
    imu = replace(gyros, time=gyros.time[both], angular=angle[both], force=grown[both, :3], increments=True)
    outside = (time <= gyros_begin[0] + ROUNDING) | (begin >= gyros.time[-1] - ROUNDING)
    if np.count_nonzero(both) < 2 or min(both.mean(), 1 - outside.mean()) < HARDLY:
        raise InputError(_hardly_together(where, (gyros.time, time), (both, ~outside)))
    left_out = {"gyros": ~both, "accelerometers": outside}
    return imu, [
        f"{np.count_nonzero(out)} samples of the {half}{_most(out)} were left out: the other half of the IMU "
        "was not measured then"
        for half, out in left_out.items()
        if out.any()
    ]


def _hardly_together(
    where: tuple[str, str], times: tuple[Array, Array], together: tuple[Flags, Flags]
) -> str:
    """What is wrong with two halves of which one, named first, is too short or of another time."""
    short, long = sorted(zip(where, times, together, strict=True), key=lambda half: float(np.ptp(half[1])))
    measured = [f"{time[0]:.10g} to {time[-1]:.10g} s" for _, time, _ in (short, long)]
    kept = [f"{np.count_nonzero(both)} of {len(both)} samples" for *_, both in (short, long)]
    return (
        f"{short[0]}: was measured from {measured[0]}, and {long[0]} from {measured[1]}: {kept[0]} and "
        f"{kept[1]} were measured together, and an alignment needs many; is the file too short, or the "
        "unit of its time another?"
    )


def _most(out: Flags) -> str:
    return f", {out.mean():.0%} of them all," if out.mean() > 0.5 else ""


def _begin(time: Array) -> Array:
    """From when on each sample holds: its predecessor, or one period before it where that is missing."""
    first = stamps.gaps(time)
    first[:1] = True
    return np.where(first, time - stamps.period(time), np.roll(time, 1))
