"""A reference of another file; between its times attitude turns the shortest way, all else goes straight."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from sim_scenarios.attitude import dcm
from sim_scenarios.cosimulation import Columns
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import clocks
from sim_scenarios.recordings.clocks import Stamps
from sim_scenarios.recordings.order import in_order
from sim_scenarios.recordings.readers import formats
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.recordings.sources import StampsAre
from sim_scenarios.recordings.tables import Recording, ReferenceTable

Array = NDArray[np.float64]

LONGEST: Final = 3.0
"""Steps of usual length across which a reference is interpolated."""


def of_file(path: Path, recording: Recording) -> tuple[ReferenceTable, list[str]]:
    """Reference of a file that a reader recognises, on the clock of a recording, and remarks on it.

    Stamps with a date go with those of a recording that tells its own, and otherwise with seconds of the day
    in GPS time; stamps without one are taken for the recording's.

    Raises
    ------
    InputError
        If the file has no reference, its stamps do not increase, or none is of the recording's time.
    """
    form = formats.recognised(path)
    if form == "csv":
        raise InputError(
            f"{path}: has no reference that is known by itself: a table reference of recording.toml says "
            "what its columns are; `truenorth import` drafts it of a file with an attitude"
        )
    contents = formats.read(path, form)
    if contents.reference is None:
        raise InputError(f"{path}: has no reference: neither an attitude nor a solution of somebody else")
    clock = contents.clock
    found, remarks = in_order(
        contents.reference,
        clock,
        StampsAre.RECORDED,
        lambda row: f"{path}: {contents.place('reference', row)}",
    )
    beside = Stamps(recording.name, Clock.GPS_DAY if clock.dated else clock, 0.0, recording.imu.time)
    if clock.dated and recording.epoch is not None:
        beside = replace(beside, clock=Clock.GPS, epoch=recording.epoch)
    own, time = clocks.on_one_clock([beside, Stamps(str(path), clock, contents.epoch, found.time)])
    return replace(found, time=time - (own[0] - recording.imu.time[0])), remarks


def at(reference: ReferenceTable, time: Array) -> Columns:
    """What a reference tells at given times.

    Parameters
    ----------
    reference : ReferenceTable
        With increasing stamps.
    time : ndarray, shape (n,)
        [s]

    Returns
    -------
    dict of str to ndarray, shape (n,)
        By the names of TruthPlant's outputs; not a number before, after and in gaps of the reference, and of
        what it does not tell. A heading without roll and pitch stands alone.
    """
    told = np.isfinite(reference.attitude)
    whole = told.all(axis=1)
    angles = _attitude(reference.time[whole], reference.attitude[whole], time)
    alone = _line(reference.time, _continuous(reference.attitude[:, 2]), time)
    latitude, longitude, height = reference.position.T
    tables = {
        "latitude": latitude,
        "longitude": _continuous(longitude),
        "height": height,
        **{f"velocity[{i}]": column for i, column in enumerate(reference.velocity.T, start=1)},
    }
    lines = {name: _line(reference.time, values, time) for name, values in tables.items()}
    angles[:, 2] = np.where(np.isfinite(angles[:, 2]), angles[:, 2], alone)
    rotations = dict(zip(("roll", "pitch", "heading"), angles.T, strict=True))
    return {f"truth.{name}": values for name, values in (rotations | lines).items()}


def _attitude(known: Array, angles: Array, time: Array) -> Array:
    """Roll, pitch, heading [rad] on the shortest rotations, shape (n, 3)."""
    found = np.full((len(time), 3), np.nan)
    inside = _between(known, time)
    if inside.any():
        rotation = Slerp(known, Rotation.from_matrix(dcm(*angles.T)))(time[inside])
        minus_heading, pitch, roll = rotation.as_euler("ZXY").T
        found[inside] = np.column_stack((roll, pitch, -minus_heading % (2 * np.pi)))
    return found


def _line(known: Array, values: Array, time: Array) -> Array:
    finite = np.isfinite(values)
    inside = _between(known[finite], time)
    found = np.full(len(time), np.nan)
    if inside.any():
        found[inside] = np.interp(time[inside], known[finite], values[finite])
    return found


def _between(known: Array, time: Array) -> NDArray[np.bool_]:
    """Whether times lie between two known ones that are not far apart."""
    if len(known) < 2:
        return np.zeros(len(time), dtype=bool)
    steps = np.diff(known)
    step = steps[(np.searchsorted(known, time, side="right") - 1).clip(0, len(steps) - 1)]
    inside: NDArray[np.bool_] = (
        (time >= known[0]) & (time <= known[-1]) & (step <= LONGEST * np.median(steps))
    )
    return inside


def _continuous(angle: Array) -> Array:
    """An angle without leaps of a turn where it is known."""
    finite = np.isfinite(angle)
    whole = np.array(angle)
    whole[finite] = np.unwrap(angle[finite])
    return whole
