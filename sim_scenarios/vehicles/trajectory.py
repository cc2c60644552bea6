"""A trajectory of a file: where a vehicle was, how fast, and how it lay, at any rate.

A text file with a header, in all the habits that `recordings.readers.sheets` knows, has the columns

    time                                      [s]; the first row is time 0 of the scenario
    latitude, longitude                       of the IMU, WGS-84 [deg]
    height                                    above the ellipsoid [m]
    roll, pitch, heading                      [deg]
    velocity_east, _north, _up                [m/s]
    acceleration_east, _north, _up            derivative of the velocity, component by component [m/s2]
    rate_right, _forward, _up                 of the body relative to east, north, up [deg/s]

of which the last three kinds may be left out. Any other file is one of which a reader of recordings finds a
reference: RTKLIB's .pos does not tell an attitude and is refused, a truth of KF-GINS, a `recording.nc` of
`truenorth run` do.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import formats, sheets
from sim_scenarios.recordings.readers.layouts import three
from sim_scenarios.recordings.readers.sheets import Sheet
from sim_scenarios.recordings.readers.time_columns import stamps
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles.motion import HIGHEST_LATITUDE, Points, Vehicle

Array = NDArray[np.float64]
Place = Callable[[int], str]
"""File and line of a row."""

_POSITION: Final = ("latitude", "longitude", "height")
_ATTITUDE: Final = ("roll", "pitch", "heading")
_VELOCITY, _ACCELERATION, _RATE = three("velocity"), three("acceleration"), three("rate", "right forward up")

ASTRAY: Final = 0.1  # m
SHARE_ASTRAY: Final = 0.01
"""Of the way between two rows, how far positions may be off that to which velocities lead, beside ASTRAY."""
UNTURNED: Final = 0.3
"""Share of all turns between rows that body rates may leave unexplained."""


@lru_cache(maxsize=4)
def vehicle(path: Path, version: str) -> Vehicle:  # noqa: ARG001  (with another content it is another one)
    """Vehicle of a file.

    Parameters
    ----------
    path : Path
        A text file with the columns above, or one of which a reader finds a reference.
    version : str
        Tells contents of a file apart.

    Raises
    ------
    InputError
        The file is none, or its rows contradict one another; the sentence names the line.
    """
    points, place = _points(path)
    _check(points, place)
    moving = Vehicle(points)
    if points.velocity is not None:
        _check_velocities(moving, points.velocity, place)
    if points.body_rate is not None:
        _check_rates(moving, points.body_rate, path)
    return moving


def _points(path: Path) -> tuple[Points, Place]:
    """Points of a file, and where each of them stands."""
    name = formats.recognised(path)
    if name == "csv":
        sheet = sheets.read(path)
        return _of_sheet(sheet), lambda row: f"{path}: line {sheet.line(row)}"
    contents = formats.read(path, name)
    told = contents.reference
    if told is None:
        raise InputError(f"{path}: has no trajectory: no solution of position and attitude")
    velocity = told.velocity if np.isfinite(told.velocity).any() else None
    points = Points(told.time, told.position, told.attitude, velocity)
    return points, lambda row: f"{path}: {contents.place('reference', row)}"


def _of_sheet(sheet: Sheet) -> Points:
    def matrix(names: tuple[str, ...], unit: Array | float = 1.0) -> Array:
        columns: Array = np.stack([sheet.numbers(name) for name in names], axis=-1) * unit
        return columns

    def if_there(names: tuple[str, ...], unit: float = 1.0) -> Array | None:
        return matrix(names, unit) if any(map(sheet.has, names)) else None

    return Points(
        stamps(sheet, ("time",), "s").time,
        matrix(_POSITION, np.array([DEGREE, DEGREE, 1.0])),
        matrix(_ATTITUDE, DEGREE),
        if_there(_VELOCITY),
        if_there(_ACCELERATION),
        if_there(_RATE, DEGREE),
    )


def _check(points: Points, place: Place) -> None:
    """Refuse what is missing, and stamps that do not increase."""
    if len(points.time) < 2:
        raise InputError(f"{place(0)}: is the only row of the trajectory; it must have two at least")
    for names, values in (
        (_POSITION, points.position),
        (_ATTITUDE, points.attitude),
        (_VELOCITY, points.velocity),
        (_ACCELERATION, points.acceleration),
        (_RATE, points.body_rate),
    ):
        if values is not None and len(missing := np.argwhere(~np.isfinite(values))):
            row, column = missing[0].tolist()
            raise InputError(f"{place(row)}: {names[column]} must be a finite number")
    if len(rows := np.flatnonzero(np.diff(points.time) <= 0)):
        row = int(rows[0]) + 1
        raise InputError(
            f"{place(row)}: time = {points.time[row]:.9g} s: must be greater than in the row before"
        )
    if len(rows := np.flatnonzero(np.abs(points.position[:, 0]) > HIGHEST_LATITUDE)):
        row = int(rows[0])
        raise InputError(
            f"{place(row)}: latitude = {points.position[row, 0] / DEGREE:g} deg: must be at most "
            f"{HIGHEST_LATITUDE / DEGREE:.2f} either way"
        )


def _check_velocities(moving: Vehicle, velocity: Array, place: Place) -> None:
    """Refuse positions that do not move as velocities say."""
    off = np.linalg.norm(moving.astray, axis=1)
    speed = np.linalg.norm(velocity, axis=1)
    way = np.diff(moving.time) * np.maximum(speed[1:], speed[:-1])
    rows = np.flatnonzero(off > ASTRAY + SHARE_ASTRAY * way)
    if len(rows):
        row = int(rows[0])
        raise InputError(
            f"{place(row + 1)}: latitude, longitude, height lie {off[row]:.3g} m off where velocities "
            f"lead to from the row before: must be at most {ASTRAY:g} m and {SHARE_ASTRAY:.0%} of the way of "
            f"{way[row]:.3g} m; rows must be so close that the motion between them can be interpolated"
        )


def _check_rates(moving: Vehicle, rate: Array, path: Path) -> None:
    """Refuse body rates that are not those of the attitude."""
    said = np.diff(moving.time)[:, None] * (rate[1:] + rate[:-1]) / 2
    turned, left = (float(np.sum(np.linalg.norm(one, axis=1))) for one in (moving.turns, moving.turns - said))
    if left > UNTURNED * turned + 1e-6 * len(said):
        raise InputError(
            f"{path}: rate_right, rate_forward, rate_up leave {left / DEGREE:.3g} deg of the "
            f"{turned / DEGREE:.3g} deg unexplained by which roll, pitch, heading turn: must be at most "
            f"{UNTURNED:.0%} (deg/s, relative to east, north, up; rows close enough to be interpolated)"
        )
