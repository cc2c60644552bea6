"""Tables put together from messages that each say a part of a row: position here, velocity or sigma there.

Parts with the same stamp make one row, and rows come out in the order of their stamps; what is said twice is
as said last. Nothing is carried from one row to another.
"""

from __future__ import annotations

from array import array
from collections import defaultdict

import numpy as np

from sim_scenarios.recordings.tables import (
    Array,
    BodyVelocityTable,
    FixTable,
    HeadingTable,
    ReferenceTable,
)

NOT_MEASURED = float("nan")
NOT_TOLD = 0.0


class _Epochs:
    """Rows that begin as `unsaid` and are said part by part."""

    def __init__(self, *unsaid: float):
        self._unsaid = unsaid
        self._parts: dict[tuple[int, int], array[float]] = defaultdict(lambda: array("d"))

    def say(self, time: float, column: int, *values: float) -> None:
        """Values of a row, beginning at a column."""
        self._parts[column, len(values)].extend((time, *values))

    def rows(self, measured: slice) -> tuple[Array, Array]:
        """Stamps and rows; not those in which none of the measured columns was said."""
        parts = {place: np.array(said).reshape(-1, place[1] + 1) for place, said in self._parts.items()}
        time = np.unique(np.concatenate([np.empty(0), *(said[:, 0] for said in parts.values())]))
        rows = np.tile(np.array(self._unsaid), (len(time), 1))
        for (column, width), said in parts.items():
            rows[np.searchsorted(time, said[:, 0]), column : column + width] = said[:, 1:]
        kept = ~np.isnan(rows[:, measured]).all(axis=1)
        return time[kept], rows[kept]


class Fixes:
    """Fixes of a receiver, east, north, up."""

    def __init__(self) -> None:
        self._epochs = _Epochs(*[NOT_MEASURED] * 6, *[NOT_TOLD] * 6)

    def position(self, time: float, latitude: float, longitude: float, height: float) -> None:
        """Latitude and longitude [rad], height [m]."""
        self._epochs.say(time, 0, latitude, longitude, height)

    def velocity(self, time: float, east: float, north: float, up: float = NOT_MEASURED) -> None:
        """Velocity [m/s]."""
        self._epochs.say(time, 3, east, north, up)

    def position_sigma(self, time: float, east: float, north: float, up: float) -> None:
        """Standard deviations of a position [m]."""
        self._epochs.say(time, 6, east, north, up)

    def velocity_sigma(self, time: float, east: float, north: float, up: float) -> None:
        """Standard deviations of a velocity [m/s]."""
        self._epochs.say(time, 9, east, north, up)

    def table(self) -> FixTable | None:
        """Table, if there is a fix."""
        time, rows = self._epochs.rows(slice(0, 6))
        return FixTable(time, rows[:, 0:3], rows[:, 3:6], rows[:, 6:9], rows[:, 9:12]) if len(time) else None


class BodyVelocities:
    """Velocities in body axes, right, forward, up."""

    def __init__(self) -> None:
        self._epochs = _Epochs(*[NOT_MEASURED] * 3, *[NOT_TOLD] * 3)

    def velocity(self, time: float, right: float, forward: float, up: float) -> None:
        """Velocity [m/s]."""
        self._epochs.say(time, 0, right, forward, up)

    def sigma(self, time: float, right: float, forward: float, up: float) -> None:
        """Standard deviations [m/s]."""
        self._epochs.say(time, 3, right, forward, up)

    def table(self) -> BodyVelocityTable | None:
        """Table, if there is a velocity."""
        time, rows = self._epochs.rows(slice(0, 3))
        return BodyVelocityTable(time, rows[:, 0:3], rows[:, 3:6]) if len(time) else None


class Headings:
    """Headings of an aid."""

    def __init__(self) -> None:
        self._epochs = _Epochs(NOT_MEASURED, NOT_TOLD)

    def heading(self, time: float, heading: float, sigma: float = NOT_TOLD) -> None:
        """Heading and its standard deviation [rad]."""
        self._epochs.say(time, 0, heading, sigma)

    def table(self) -> HeadingTable | None:
        """Table, if there is a heading."""
        time, rows = self._epochs.rows(slice(0, 1))
        return HeadingTable(time, rows[:, 0], rows[:, 1]) if len(time) else None


class References:
    """Rows of somebody else's solution."""

    def __init__(self) -> None:
        self._epochs = _Epochs(*[NOT_MEASURED] * 9)

    def attitude(self, time: float, roll: float, pitch: float, heading: float) -> None:
        """Attitude [rad]."""
        self._epochs.say(time, 0, roll, pitch, heading)

    def position(self, time: float, latitude: float, longitude: float, height: float) -> None:
        """Latitude and longitude [rad], height [m]."""
        self._epochs.say(time, 3, latitude, longitude, height)

    def velocity(self, time: float, east: float, north: float, up: float) -> None:
        """Velocity [m/s]."""
        self._epochs.say(time, 6, east, north, up)

    def table(self) -> ReferenceTable | None:
        """Table, if something was said."""
        time, rows = self._epochs.rows(slice(0, 9))
        return ReferenceTable(time, rows[:, 0:3], rows[:, 3:6], rows[:, 6:9]) if len(time) else None
