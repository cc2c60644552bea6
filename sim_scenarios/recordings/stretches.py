"""Where in a recording the vehicle stands.

In windows of a second the increments scatter by the noise of the sensors and by what shakes them, and more
when the vehicle moves. It stands in windows that scatter no more than the quiet ones, and do not turn against
them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

WINDOW: Final = 1.0  # s
FEWEST: Final = 50
"""Samples of a window, which is longer where there are fewer in a second."""
QUIET: Final = 5.0
"""Percentile of the scatter over the windows that is that of the quiet ones."""
LOUDER: Final = 5.0
"""Scatter of a window in which the vehicle stands, over that of the quiet ones, at most."""
TURNING: Final = 0.2 * DEGREE
"""Mean rate of a window that turns, against the quiet ones [rad/s]."""
MOVING: Final = 0.5
"""Speed of fixes of a vehicle that moves [m/s]."""
SHORTEST: Final = 10.0
"""Of a stretch [s]."""


@dataclass(frozen=True)
class Stretch:
    """Part of an IMU table at a steady rate.

    Attributes
    ----------
    begin, end : float
        [s]
    imu : ImuTable
    period : float
        Mean interval of its samples [s].
    """

    begin: float
    end: float
    imu: ImuTable
    period: float

    @classmethod
    def of(cls, imu: ImuTable, rows: slice) -> Stretch:
        """The samples of some rows."""
        time = imu.time[rows]
        part = ImuTable(time, imu.delta_angle[rows], imu.delta_velocity[rows])
        return cls(float(time[0]), float(time[-1]), part, float(np.mean(np.diff(time))))


def between(recording: Recording, begin: float | None, end: float | None) -> Stretch:
    """The samples from one time to another [s]; InputError if they are few, have a gap or are no numbers."""
    time = recording.imu.time
    first, last = (time[0] if begin is None else begin), (time[-1] if end is None else end)
    rows = slice(int(np.searchsorted(time, first)), int(np.searchsorted(time, last, side="right")))
    span = float(np.ptp(time[rows])) if rows.stop - rows.start > 1 else 0.0
    if span < SHORTEST:
        raise InputError(
            f"{recording.name}: from {first:g} to {last:g} s there are {span:g} s of IMU samples; at least "
            f"{SHORTEST:g} s are needed"
        )
    broken = np.flatnonzero(stamps.gaps(time[rows]))
    if len(broken):
        raise InputError(
            f"{recording.name}: the IMU samples have a gap before {time[rows][broken[0]]:g} s; choose a "
            "stretch without"
        )
    stretch = Stretch.of(recording.imu, rows)
    increments = np.hstack([stretch.imu.delta_angle, stretch.imu.delta_velocity])
    unknown = np.flatnonzero(~np.isfinite(increments).all(axis=1))
    if len(unknown):
        raise InputError(
            f"{recording.name}: the IMU sample at {stretch.imu.time[unknown[0]]:g} s is not a number; choose "
            "a stretch without"
        )
    return stretch


def longest_standing(recording: Recording) -> Stretch | None:
    """The longest stretch in which the vehicle stands, a window short at either end; None: there is none."""
    imu = recording.imu
    period = stamps.period(imu.time)
    size = max(round(WINDOW / period), FEWEST)
    count = len(imu.time) // size
    if count == 0:
        return None
    rows = count * size
    rates = np.hstack([imu.delta_angle, imu.delta_velocity])[:rows].reshape(count, size, 6) / period
    whole = np.isfinite(rates).all(axis=(1, 2))
    if not whole.any():
        return None
    rates[~whole] = np.nan  # infinite values would warn
    scatter = rates.std(axis=1)
    quiet = np.percentile(scatter[whole], QUIET, axis=0)
    calm = np.all(scatter <= LOUDER * np.maximum(quiet, np.finfo(float).tiny), axis=1)
    turn = rates[:, :, :3].mean(axis=1)
    if calm.any():
        calm &= np.all(np.abs(turn - np.median(turn[calm], axis=0)) < TURNING, axis=1)
    calm &= ~stamps.gaps(imu.time)[:rows].reshape(count, size).any(axis=1)
    if recording.gnss is not None:
        calm &= ~_moving(recording.gnss, imu.time[:rows].reshape(count, size))
    begin, end = _longest_run(calm)
    if (end - begin - 2) * size * period < SHORTEST:
        return None
    return Stretch.of(imu, slice((begin + 1) * size, (end - 1) * size))


def _moving(gnss: FixTable, windows: Array) -> NDArray[np.bool_]:
    """Windows with a fix that moves."""
    speed = np.linalg.norm(gnss.velocity[:, :2], axis=1)
    moves = gnss.time[speed > MOVING]  # what has not been measured does not
    edges = np.concatenate([windows[:, 0], [np.inf]])
    counts, _ = np.histogram(moves, edges)
    moving: NDArray[np.bool_] = counts > 0
    return moving


def _longest_run(true: NDArray[np.bool_]) -> tuple[int, int]:
    """Begin and end of the longest run of true values."""
    steps = np.diff(np.concatenate([[0], true.astype(int), [0]]))
    begins, ends = np.flatnonzero(steps > 0), np.flatnonzero(steps < 0)
    if not len(begins):
        return 0, 0
    longest = int(np.argmax(ends - begins))
    return int(begins[longest]), int(ends[longest])
