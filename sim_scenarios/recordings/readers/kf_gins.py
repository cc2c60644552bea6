"""KF-GINS text: numbers between blanks, a file for each sensor.

    IMU         7 columns    second of the week, delta angles [rad], delta velocities [m/s]; forward, right,
                             down, increments over the interval that ends at the stamp
    GNSS        7 columns    second of the week, latitude, longitude [deg], height [m], standard deviations
                             north, east, down [m]
                13 columns   the same, then velocity north, east, down [m/s], its standard deviations
    reference   11 columns   week, second of the week, latitude, longitude [deg], height [m], velocity
                             north, east, down [m/s], roll, pitch, yaw [deg]

An IMU file is one in which the last three columns over the time step are the size of gravity; in a GNSS file
the standard deviations are below 100 m and the rows at least 0.02 s apart. No week is told
but in a reference, so that IMU and GNSS have Clock.OWN, seconds of the same unnamed week; a step back by
more than half a week is the next week. References have Clock.GPS.

Source: KF-GINS (i2Nav-WHU), README section 2.2, and awesome-gins-datasets, whose formats they are.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import gps_time
from sim_scenarios.recordings.readers.contents import Axes, Clock, Contents, Inertial
from sim_scenarios.recordings.readers.files import beginning
from sim_scenarios.recordings.readers.rows import line, numbers
from sim_scenarios.recordings.tables import Array, FixTable, ReferenceTable
from sim_scenarios.units import DEGREE, STANDARD_GRAVITY

_ROWS: Final = 50
"""By which a file is recognised."""
_WIDTHS: Final = (7, 11, 13)
_WORST: Final = 100.0  # m
_FASTEST_FIXES: Final = 0.02  # s
_FROM_NED: Final = np.array([1, 0, 2])
_UP: Final = np.array([1.0, 1.0, -1.0])


def recognises(path: Path) -> bool:
    """Whether the first rows of a file are those of one of the three kinds."""
    lines = beginning(path).split(b"\n")[:-1] or [beginning(path)]
    try:
        rows = [[float(cell) for cell in line.split()] for line in islice(lines, _ROWS) if line.strip()]
        table = np.array(rows)
    except ValueError:
        return False
    return table.ndim == 2 and np.isfinite(table).all() and _kind(table) is not None


def read(path: Path) -> Contents:
    """IMU, fixes or reference of a file.

    Raises
    ------
    InputError
        If the file is none of the three kinds, or a row is damaged, with its line.
    """
    table = numbers(path)
    kind = _kind(table)

    def place(_: str, row: int) -> str:
        return f"line {line(path, row)}"

    if kind == "reference":
        first = table[0, 0]
        time = gps_time.WEEK * (table[:, 0] - first) + table[:, 1]
        return Contents(Clock.GPS, first * gps_time.WEEK, reference=_reference(time, table), place=place)
    if kind is None:
        raise InputError(
            f"{path}: {table.shape[1]} columns that are neither KF-GINS's IMU (7), GNSS (7 or 13) "
            "nor reference (11)"
        )
    time = table[:, 0] + gps_time.WEEK * np.cumsum(
        np.diff(table[:, 0], prepend=table[0, 0]) < -gps_time.WEEK / 2
    )
    if kind == "imu":
        imu = Inertial(time, table[:, 1:4], table[:, 4:7], True, Axes.FORWARD_RIGHT_DOWN)
        return Contents(imu=imu, place=place)
    return Contents(gnss=_fixes(time, table), place=place)


def _kind(table: Array) -> str | None:
    """What a table holds."""
    width = table.shape[1]
    if width not in _WIDTHS:
        return None
    second = table[:, 1 if width == 11 else 0]
    place = table[:, 2:4] if width == 11 else table[:, 1:3]
    on_earth = (np.abs(place[:, 0]) <= 90).all() and (np.abs(place[:, 1]) <= 360).all()
    if not ((second >= 0) & (second <= gps_time.WEEK)).all():
        return None
    if width == 11 and on_earth and (table[:, 0] == np.round(table[:, 0])).all():
        return "reference"
    step = np.median(np.diff(second)) if len(table) > 1 else np.inf
    if width == 7:
        force = np.mean(np.linalg.norm(table[:, 4:7], axis=1)) / step if step > 0 else 0.0
        if STANDARD_GRAVITY / 2 < force < 2 * STANDARD_GRAVITY and (np.abs(table[:, 1:4]) < 1).all():
            return "imu"
    sigmas = table[:, 4:7]
    if width != 11 and on_earth and step >= _FASTEST_FIXES and ((sigmas > 0) & (sigmas < _WORST)).all():
        return "gnss"
    return None


def _fixes(time: Array, table: Array) -> FixTable:
    nothing = np.full((len(table), 3), np.nan)
    full = table.shape[1] == 13
    return FixTable(
        time,
        table[:, 1:4] * (DEGREE, DEGREE, 1.0),
        table[:, 7:10][:, _FROM_NED] * _UP if full else nothing,
        table[:, 4:7][:, _FROM_NED],
        table[:, 10:13][:, _FROM_NED] if full else np.zeros_like(nothing),
    )


def _reference(time: Array, table: Array) -> ReferenceTable:
    return ReferenceTable(
        time,
        table[:, 8:11] * DEGREE,
        table[:, 2:5] * (DEGREE, DEGREE, 1.0),
        table[:, 5:8][:, _FROM_NED] * _UP,
    )
