"""An IMU whose gyros and accelerometers were recorded apart, each with stamps of its own.

The stamps of the gyros are kept, so that turns stay as they were measured. The velocity that the
accelerometers gained since their first sample is straight between their stamps; over a sample of the gyros it
grows by what is the sample's. Whatever the two rates are, nothing is lost and nothing counts twice.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.readers.contents import Inertial
from sim_scenarios.recordings.tables import Array

ROUNDING: Final = 1e-6
"""Of stamps [s]."""


def joined(gyros: Inertial, accelerometers: Inertial) -> tuple[Inertial, list[str]]:
    """One IMU of its two halves.

    Parameters
    ----------
    gyros, accelerometers : Inertial
        With increasing stamps on one clock; of the first the angular part counts, of the second the forces.

    Returns
    -------
    imu : Inertial
        Increments over those samples of the gyros during which the accelerometers measured.
    remarks : list of str
        What was left out.

    Raises
    ------
    InputError
        If the accelerometers have fewer than two samples.
    """
    known = np.isfinite(accelerometers.force).all(axis=1)
    time, force = accelerometers.time[known], accelerometers.force[known]
    if len(time) < 2:
        raise InputError(f"accelerometer: has {len(time)} samples; an alignment needs many")
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
    left_out = {"gyros": np.count_nonzero(~both), "accelerometers": np.count_nonzero(outside)}
    return imu, [
        f"{count} samples of the {half} were left out: the other half of the IMU was not measured then"
        for half, count in left_out.items()
        if count
    ]


def _begin(time: Array) -> Array:
    """From when on each sample holds: its predecessor, or one period before it where that is missing."""
    first = stamps.gaps(time)
    first[:1] = True
    return np.where(first, time - stamps.period(time), np.roll(time, 1))
