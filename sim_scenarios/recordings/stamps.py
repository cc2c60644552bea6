"""Time stamps as loggers write them: coarse, jittered, with gaps, twice.

A step between stamps is a gap if it is far beyond its neighbours: longer than one and a half times the steps
near it, of which one in twenty may be a gap itself. Where more steps are long, that is how the logger stamps,
and nothing is missing. Stamps of a host scatter by milliseconds about the sensor's own steady clock and do
not wander from it, so nothing is concluded from a count of periods since the start.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, rank_filter

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.tables import Array

NEIGHBOURS: Final = 101
"""Steps among which one is judged."""
FAR: Final = 1.5
"""How many times as long as its neighbours a gap is."""
SMOOTHED_OVER: Final = 10.0  # s; in it a sensor's quartz keeps its rate to better than the stamps are


def gaps(time: Array) -> NDArray[np.bool_]:
    """Whether samples are missing before each sample.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Increasing stamps [s].

    Returns
    -------
    ndarray of bool, shape (n,)
        The first is False.
    """
    steps = np.diff(time)
    if len(steps) == 0:
        return np.zeros(len(time), dtype=bool)
    near = min(NEIGHBOURS, len(steps))
    rank = max(near - 1 - -(-near // 20), 0)  # the longest of the steps that are not among the twentieth
    ordinary = (
        np.full(len(steps), np.sort(steps)[rank])
        if near < NEIGHBOURS
        else rank_filter(steps, rank, size=near, mode="mirror")
    )
    return np.concatenate(([False], steps > FAR * ordinary))


def period(time: Array) -> float:
    """Mean step between stamps [s], gaps left out."""
    return float(np.mean(np.diff(time)[~gaps(time)[1:]]))


def missed(time: Array) -> NDArray[np.int64]:
    """How many samples are missing before each sample, shape (n,)."""
    steps = np.diff(time, prepend=time[:1])
    count = np.rint(steps / period(time)).astype(np.int64) - 1
    return np.where(gaps(time), count, 0)


def intervals(time: Array) -> Array:
    """What each sample covers [s], shape (n,).

    The step that ends at it; at the start and after a gap, of which nothing is known, one period.
    """
    steps = np.diff(time, prepend=time[:1])
    unknown = gaps(time)
    unknown[:1] = True
    return np.where(unknown, period(time), steps)


def on_a_steady_clock(time: Array) -> Array:
    """Stamps of a host moved onto the clock of a sensor that samples steadily.

    Between gaps, the stamps follow a line over 10 s about each sample; stamps that are off the median of
    these 10 s by more than three times what is usual do not count. Right for a sensor with a quartz of its
    own of which every sample was recorded; wrong where samples were lost without a gap in the stamps.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Stamps [s], which may repeat but not go back.

    Returns
    -------
    ndarray, shape (n,)

    Raises
    ------
    InputError
        If the stamps are not those of a steady sensor: the line does not increase, or leaves a stamp by
        more than ten periods.
    """
    steady = np.array(time)
    begins = np.concatenate(([0], np.flatnonzero(gaps(time)), [len(time)]))
    for begin, end in pairwise(begins):
        if end - begin > 3:
            steady[begin:end] = _line(time[begin:end])
    back = np.flatnonzero(np.diff(steady) <= 0)
    far = np.flatnonzero(np.abs(steady - time) > 10 * np.ptp(time) / max(len(time) - 1, 1))
    if len(back) or len(far):
        at = int((back if len(back) else far)[0])
        raise InputError(f"stamps near {time[at]:.6g} s are not those of a sensor that samples steadily")
    return steady


def _line(time: Array) -> Array:
    """Stamps on a local line over the count of samples."""
    count, half = np.arange(len(time)), len(time) // 2
    step = float(np.median(time[half:] - time[: len(time) - half])) / half
    if step <= 0:
        return time
    late = time - step * count
    window = min(round(SMOOTHED_OVER / step), len(time))
    window -= 1 - window % 2
    if window < 3:
        return time
    from scipy.signal import savgol_filter  # imports that every other command does without

    first: Array = median_filter(late, window, mode="mirror")
    off = np.abs(late - first)
    trusted = np.where(off <= 3 * 1.4826 * np.median(off), late, first)
    smooth: Array = savgol_filter(trusted, window, 1)
    return step * count + smooth
