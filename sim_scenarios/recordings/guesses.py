"""Clocks and axes of files that do not say them, by sizes that physics and loggers allow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from time import time as now
from typing import Any, Final

import numpy as np

from sim_scenarios.recordings import axes as of_axes
from sim_scenarios.recordings.ahead import Ahead
from sim_scenarios.recordings.clocks import Stamps
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.recordings.readers.gps_time import SINCE_1970
from sim_scenarios.recordings.tables import Array

SLOWEST_DATED: Final = 5e8  # s, a clock that counts since 1970 or 1980


@dataclass(frozen=True)
class Guess:
    """A value, and why it was taken."""

    value: Any
    why: str


def dated(path: Path, given: Stamps, name: str) -> Guess | None:
    """Clock of stamps that are dates, or as large as those since 1970 or 1980."""
    if given.clock is Clock.UNIX:
        if "gps" in name:
            return Guess(Clock.GPS.value, f"check: the dates of {name} may be GPS time (gps) or UTC (unix)")
        return Guess(Clock.UNIX.value, "check: the dates may be UTC (unix) or GPS time (gps)")
    first = given.epoch + float(given.time[0])
    if first < SLOWEST_DATED:
        return None
    if first + SINCE_1970 > now() or "unix" in name:
        return Guess(Clock.UNIX.value, f"{first:.10g} s since 1980 would be in the future")
    clock = Clock.GPS if "gps" in name or "gps" in path.name.casefold() else Clock.UNIX
    return Guess(clock.value, f"check: {first:.10g} s may count since 1970 (unix) or 1980 (gps)")


def axes(up: Array, forward: Ahead | None) -> Guess:
    """Convention of a sensor's axes.

    Parameters
    ----------
    up : ndarray, shape (3,)
        Direction of the mean specific force.
    forward : Ahead, optional
        Direction ahead; without it the first axis that is level is taken.
    """
    vertical = int(np.argmax(np.abs(up)))
    level = [axis for axis in range(3) if axis != vertical]
    why = f"the mean force is {up[vertical]:+.2f} of its size on axis {vertical + 1}"
    if forward is None:
        along, sign = level[0], 1.0
        why += "; check which axis is ahead: nothing shows it"
    else:
        along = max(level, key=lambda axis: abs(forward.direction[axis]))
        sign = math.copysign(1.0, forward.direction[along])
        why += (
            f"; speed is gained along {sign * (along + 1):+.0f} ({forward.direction[along]:+.2f}, "
            f"correlation {forward.correlation:.2f})"
        )
    upward = np.eye(3)[vertical] * math.copysign(1.0, up[vertical])
    ahead = np.eye(3)[along] * sign
    body = np.stack([np.cross(ahead, upward), ahead, upward])  # rows: right, forward, up
    directions = {tuple(direction): word for word, direction in of_axes.DIRECTIONS.items()}
    return Guess("-".join(directions[tuple(column + 0.0)] for column in body.T), why)
