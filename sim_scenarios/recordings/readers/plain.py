"""Text files in the plain form of this product.

Increments in right, forward, up and, in rows that have them, aids:

    time                                      end of the interval [s]
    delta_angle_x, _y, _z                     [rad]
    delta_velocity_x, _y, _z                  [m/s]
    gnss_velocity_east, _north, _up           of the antenna [m/s]
    gnss_latitude, gnss_longitude             [deg]
    gnss_height                               above the ellipsoid [m]
    gnss_velocity_sigma_east, _north, _up     [m/s], and gnss_position_sigma_east, _north, _up [m]
    gnss_time                                 time of validity of the fix [s]; else the row's time
    body_velocity_right, _forward, _up        [m/s], and body_velocity_sigma_right, _forward, _up
    heading_aid, heading_aid_sigma            [deg]
    height_aid, height_aid_sigma              [m]

What is empty has not been measured; a row in which an aid has nothing is none of its rows. All but the first
seven may be left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeVar

from pydantic import BaseModel

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.recordings.readers import delimited, sheets
from sim_scenarios.recordings.readers.columns import likely
from sim_scenarios.recordings.readers.contents import Contents
from sim_scenarios.recordings.readers.layouts import (
    BodyVelocityColumns,
    BodyVelocityUnits,
    GnssColumns,
    GnssUnits,
    HeadingColumns,
    HeadingUnits,
    HeightColumns,
    HeightUnits,
    ImuColumns,
    ImuUnits,
    three,
)
from sim_scenarios.recordings.readers.sheets import Sheet

AIDS: Final[dict[str, tuple[Callable[..., Contents], BaseModel, BaseModel]]] = {
    "gnss": (
        delimited.gnss,
        GnssColumns(
            position=("gnss_latitude", "gnss_longitude", "gnss_height"),
            velocity=three("gnss_velocity"),
            position_sigma=three("gnss_position_sigma"),
            velocity_sigma=three("gnss_velocity_sigma"),
        ),
        GnssUnits(),
    ),
    "body_velocity": (
        delimited.body_velocity,
        BodyVelocityColumns(
            velocity=three("body_velocity", "right forward up"),
            sigma=three("body_velocity_sigma", "right forward up"),
        ),
        BodyVelocityUnits(),
    ),
    "heading_aid": (
        delimited.heading,
        HeadingColumns(heading="heading_aid", sigma="heading_aid_sigma"),
        HeadingUnits(),
    ),
    "height_aid": (
        delimited.height,
        HeightColumns(height="height_aid", sigma="height_aid_sigma"),
        HeightUnits(),
    ),
}
"""Aids of a file: what reads them, their columns and units."""


def read(path: Path) -> Contents:
    """Tables of a file in the plain form.

    Raises
    ------
    InputError
        If a column of the IMU is missing or holds something that is not a number.
    """
    sheet = sheets.read(path)
    _check_plain(sheet)
    whole = delimited.imu(sheet, ImuColumns(), ImuUnits())
    places = {"imu": whole.place}
    remarks: list[str] = []
    for name, (reader, columns, units) in AIDS.items():
        there = _present(sheet, columns)
        if there is None:
            continue
        part = reader(sheet, there, units)
        table = getattr(part, name)
        table = replace(table, time=table.time + (part.epoch - whole.epoch))
        whole = replace(whole, **{name: table})
        places[name] = part.place
        remarks += part.remarks
    return replace(whole, remarks=tuple(remarks), place=lambda table, row: places[table](table, row))


def recognises(path: Path) -> bool:
    """Whether a file has the columns of the plain form."""
    try:
        names = sheets.habits_of(path).names
    except InputError:
        return False
    return set(_needed()) <= {name.casefold() for name in names}


def _needed() -> tuple[str, ...]:
    columns = ImuColumns()
    return (*columns.time, *columns.angular, *columns.force)


def _check_plain(sheet: Sheet) -> None:
    """Refuse a file without an IMU in the plain form, and say which columns seem to hold one."""
    missing = next((name for name in _needed() if not sheet.has(name)), None)
    if missing is None:
        return
    names = list(sheet.habits.names)
    hint = did_you_mean(missing, names)
    if not sheet.habits.header:
        hint = f"; there is no header, and its {len(names)} columns are called 1 to {len(names)}"
    elif found := _meaning(sheet):
        hint = f"; {found}"
    raise InputError(
        f"{sheet.path}: there is no column {missing}{hint}; `truenorth import {sheet.path.name}` drafts a "
        "description that says what its columns are"
    )


def _meaning(sheet: Sheet) -> str:
    """What the names of columns seem to mean, where they are not those of the plain form."""
    seem = {
        "time": "the time",
        "angular": "angular rates or delta angles",
        "force": "forces or delta velocities",
    }
    found = likely(sheet.habits.names)
    return "; ".join(
        f"{', '.join(found[what])} seem{'s' * (len(found[what]) == 1)} to be {meaning}"
        for what, meaning in seem.items()
        if what in found and not set(found[what]) & set(_needed())
    )


AnyColumns = TypeVar("AnyColumns", bound=BaseModel)


def _present(sheet: Sheet, columns: AnyColumns) -> AnyColumns | None:
    """Those of an aid's plain columns that a file has; None if it has none."""

    def found(name: str) -> str:
        return name if sheet.has(name) else ""

    given = columns.model_dump(exclude={"time"})
    there = {
        key: found(names) if isinstance(names, str) else tuple(map(found, names))
        for key, names in given.items()
    }
    measured = [names for key, names in there.items() if not key.endswith("sigma")]
    if not any(any(names) for names in measured):
        return None
    time = ("gnss_time",) if isinstance(columns, GnssColumns) and sheet.has("gnss_time") else ("time",)
    return columns.model_copy(update={**there, "time": time})
