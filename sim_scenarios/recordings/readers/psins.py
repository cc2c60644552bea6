"""Files of the PSINS toolbox (Gongmin Yan): right, forward, up; increments up to the stamp.

    .imu   text: `%` comments, of which the first names PSINS and SIMU; then three rows,
               pitch, roll, yaw [deg], velocity [m/s]                        (not read: "maybe inaccurate")
               latitude, longitude [deg], height [m], t0 [s], interval [ms], g [m/s2]
               scales of the six columns: [arcsec], [ug s]
           and a row of counts for each sample, with a seventh column where the interval was not kept [us].
    .bin   an IMU array as `binfile` or `binfile32` writes it: 7 doubles or floats a row
    .mat   of MATLAB (up to version 7): the first array of each kind, also inside of structures,
               IMU          7 columns    delta angles [rad], delta velocities [m/s], time [s]
               reference    10 columns   pitch, roll, yaw (counterclockwise) [rad], velocity east, north, up
                                         [m/s], latitude, longitude [rad], height [m], time [s]
               fixes        7 columns    velocity east, north, up, latitude, longitude, height, time; or the
                                         last 4 of them; named gps... or gnss...

Seconds since a start that is not told: Clock.OWN.

Source: base/io/imufile.m and binfile.m, base/base1/gpssimu.m and base/base0/a2mat.m of the toolbox.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios import matlab
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Axes, Contents, Inertial
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.recordings.readers.rows import line, numbers
from sim_scenarios.recordings.tables import Array, FixTable, ReferenceTable, doubles
from sim_scenarios.units import ARCMIN, STANDARD_GRAVITY

ARCSEC: Final = ARCMIN / 60
_SETTINGS: Final = 3
"""Rows of a text file above its counts."""
_WIDTH: Final = 7
_BINARY: Final = {"<f8": 8, "<f4": 4}
"""Numbers of a binary file and their bytes."""
_MATLAB: Final = b"MATLAB 5.0 MAT-file"


def recognises(path: Path) -> bool:
    """Whether a file names PSINS, or is a .mat or .bin of MATLAB's arrays."""
    head = beginning(path)
    if path.suffix == ".bin":
        return any(_is_imu(table) for table in _tables(head))
    if head.startswith(_MATLAB):
        return True
    first = head.split(b"\n", 1)[0]
    return first.startswith(b"%") and b"PSINS" in first and b"SIMU" in first


def read(path: Path) -> Contents:
    """IMU, fixes and reference of a file.

    Raises
    ------
    InputError
        If the file is damaged, with the line or row where there is one, or holds nothing of what is known.
    """
    if path.suffix == ".bin":
        return _of_binary(path)
    if path.suffix == ".mat" or beginning(path).startswith(_MATLAB):
        return _of_arrays(path)
    return _of_counts(path)


def _of_counts(path: Path) -> Contents:
    table = numbers(path)
    if len(table) <= _SETTINGS or table.shape[1] not in (6, 7):
        raise InputError(
            f"{path}: {len(table)} rows of {table.shape[1]} numbers: a PSINS file has three rows of "
            "settings, then counts, in 6 or 7 columns"
        )
    (*_, start, interval, g), scales, counts = table[1, :6], table[2, :6], table[_SETTINGS:]
    if interval <= 0 or g <= 0 or (scales <= 0).any():
        raise InputError(f"{path}: interval ({interval:g} ms), g ({g:g} m/s2) and scales must exceed 0")
    time = start + np.arange(1, len(counts) + 1) * (interval / 1000)
    if counts.shape[1] == 7:
        time = time + np.cumsum(counts[:, 6]) * 1e-6
    angle = counts[:, 0:3] * (scales[0:3] * ARCSEC)
    velocity = counts[:, 3:6] * (scales[3:6] * (1e-6 * g))
    imu = Inertial(time, angle, velocity, True, Axes.RIGHT_FORWARD_UP)
    return Contents(imu=imu, place=lambda _, row: f"line {line(path, row + _SETTINGS)}")


def _of_binary(path: Path) -> Contents:
    content = whole(path)
    for size, table in zip(_BINARY.values(), _tables(content), strict=True):
        if _is_imu(table):
            if len(content) % (size * _WIDTH):
                raise InputError(f"{path}: row {len(table) + 1} is cut short: must be {_WIDTH} numbers")
            return Contents(imu=_imu(table), place=lambda _, row: f"row {row + 1}")
    raise InputError(
        f"{path}: {_WIDTH} doubles or floats a row are no increments of an IMU: the last column must be "
        "time, and columns 4 to 6 over its step the size of gravity"
    )


def _of_arrays(path: Path) -> Contents:
    imu: Inertial | None = None
    gnss: FixTable | None = None
    reference: ReferenceTable | None = None
    names: dict[str, str] = {}
    for name, table in matlab.tables(path, whole(path)):
        array, width = doubles(table), table.shape[1]
        if imu is None and width == _WIDTH and _is_imu(array):
            imu, names["imu"] = _imu(array), name
        elif reference is None and width == 10 and _increases(array[:, -1]):
            reference, names["reference"] = _solution(array), name
        elif gnss is None and name.lower().startswith(("gps", "gnss")) and width in (4, 7):
            gnss, names["gnss"] = _fixes(array), name
    if imu is None and gnss is None and reference is None:
        raise InputError(f"{path}: no array is an IMU (7 columns), an avp (10 columns) or a gps of PSINS")
    return Contents(
        imu=imu, gnss=gnss, reference=reference, place=lambda table, row: f"{names[table]}: row {row + 1}"
    )


def _tables(content: bytes) -> Iterator[Array]:
    """Rows of bytes taken as doubles and as floats."""
    for number, size in _BINARY.items():
        rows = len(content) // (size * _WIDTH)
        table = np.frombuffer(content, number, rows * _WIDTH).reshape(rows, _WIDTH)
        yield doubles(table)


def _increases(time: Array) -> bool:
    """Whether stamps go forward but for few."""
    return len(time) > 1 and bool(np.isfinite(time).all()) and bool(np.mean(np.diff(time) > 0) > 0.9)


def _is_imu(table: Array) -> bool:
    """Whether rows are increments: the last column time, the three before it gravity over its step."""
    with np.errstate(all="ignore"):  # bytes of anything, taken as doubles
        if not _increases(table[:, 6]) or not np.isfinite(table).all():
            return False
        force = np.mean(np.linalg.norm(table[:, 3:6], axis=1)) / np.median(np.diff(table[:, 6]))
    return bool(STANDARD_GRAVITY / 2 < force < 2 * STANDARD_GRAVITY)


def _imu(table: Array) -> Inertial:
    return Inertial(table[:, 6], table[:, 0:3], table[:, 3:6], True, Axes.RIGHT_FORWARD_UP)


def _solution(avp: Array) -> ReferenceTable:
    pitch, roll, yaw = avp[:, 0:3].T
    heading = -yaw % math.tau
    return ReferenceTable(avp[:, 9], np.column_stack((roll, pitch, heading)), avp[:, 6:9], avp[:, 3:6])


def _fixes(gps: Array) -> FixTable:
    unknown, untold = np.full((len(gps), 3), np.nan), np.zeros((len(gps), 3))
    velocity = gps[:, 0:3] if gps.shape[1] == _WIDTH else unknown
    return FixTable(gps[:, -1], gps[:, -4:-1], velocity, untold, untold)
