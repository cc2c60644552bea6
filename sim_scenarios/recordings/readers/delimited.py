"""Tables of a text file, of which it is said which column is what, in which unit.

What is empty has not been measured; a row in which an aid has nothing is none of its rows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import units as of
from sim_scenarios.recordings.readers.contents import Contents, Inertial
from sim_scenarios.recordings.readers.layouts import (
    AccelerometerColumns,
    AccelerometerUnits,
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
    ReferenceColumns,
    ReferenceUnits,
    Three,
)
from sim_scenarios.recordings.readers.sheets import Sheet
from sim_scenarios.recordings.readers.time_columns import stamps
from sim_scenarios.recordings.tables import (
    Array,
    BodyVelocityTable,
    FixTable,
    HeadingTable,
    HeightTable,
    ReferenceTable,
)

FASTEST_FIXES: Final = 0.03  # s between them
MOSTLY: Final = 0.8
"""Share of rows that repeat the one before where values are held."""


def imu(sheet: Sheet, columns: ImuColumns, units: ImuUnits) -> Contents:
    """IMU of a file, perhaps without its forces; every row is a sample."""
    rates = of.measures(units.angular, of.ANGULAR_RATE)
    angular = of.si(units.angular, {**of.ANGLE, **of.ANGULAR_RATE})
    force = of.si(units.force, {**of.DELTA_VELOCITY, **of.SPECIFIC_FORCE})
    if any(columns.force) and rates != of.measures(units.force, of.SPECIFIC_FORCE):
        raise InputError(
            f"{sheet.path}: {units.angular} and {units.force} do not go together: rates are an angular rate "
            "and a specific force, increments an angle and a velocity"
        )
    stamped = stamps(sheet, columns.time, units.time)
    table = Inertial(
        time=stamped.time,
        angular=_matrix(sheet, columns.angular) * angular,
        force=_matrix(sheet, columns.force) * force,
        increments=not rates,
    )
    return Contents(stamped.clock, stamped.epoch, imu=table, place=_places(sheet, np.arange(len(table.time))))


def accelerometer(sheet: Sheet, columns: AccelerometerColumns, units: AccelerometerUnits) -> Contents:
    """Forces of a file that has no angles; every row is a sample."""
    force = _matrix(sheet, columns.force) * of.si(units.force, {**of.DELTA_VELOCITY, **of.SPECIFIC_FORCE})
    stamped = stamps(sheet, columns.time, units.time)
    increments = of.measures(units.force, of.DELTA_VELOCITY)
    table = Inertial(stamped.time, np.full_like(force, np.nan), force, increments)
    places = _places(sheet, np.arange(len(table.time)))
    return Contents(stamped.clock, stamped.epoch, accelerometer=table, place=places)


def gnss(sheet: Sheet, columns: GnssColumns, units: GnssUnits) -> Contents:
    """Fixes of a file, in the rows that have any part of one."""
    position = _position(sheet, columns.position, units.position, units.height)
    velocity = _matrix(sheet, columns.velocity) * of.si(units.velocity, of.VELOCITY)
    rows = _measured(sheet, "gnss", position, velocity)
    stamped = stamps(sheet, columns.time, units.time, rows)
    new = _new(stamped.time, np.concatenate([position, velocity], axis=1)[rows])
    remarks: tuple[str, ...] = ()
    if len(new) < len(rows):
        remarks = (f"{sheet.path}: fixes are held from one to the next: {len(new)} of {len(rows)} are new",)
        rows, stamped = rows[new], replace(stamped, time=stamped.time[new])
    table = FixTable(
        stamped.time,
        position[rows],
        velocity[rows],
        _sigma(sheet, columns.position_sigma, units.position_sigma, of.LENGTH)[rows],
        _sigma(sheet, columns.velocity_sigma, units.velocity_sigma, of.VELOCITY)[rows],
    )
    return Contents(stamped.clock, stamped.epoch, gnss=table, place=_places(sheet, rows), remarks=remarks)


def body_velocity(sheet: Sheet, columns: BodyVelocityColumns, units: BodyVelocityUnits) -> Contents:
    """Velocities in body axes of a file, in the rows that have any part of one."""
    velocity = _matrix(sheet, columns.velocity) * of.si(units.velocity, of.VELOCITY)
    rows = _measured(sheet, "body_velocity", velocity)
    stamped = stamps(sheet, columns.time, units.time, rows)
    sigma = _sigma(sheet, columns.sigma, units.sigma, of.VELOCITY)
    table = BodyVelocityTable(stamped.time, velocity[rows], sigma[rows])
    return Contents(stamped.clock, stamped.epoch, body_velocity=table, place=_places(sheet, rows))


def heading(sheet: Sheet, columns: HeadingColumns, units: HeadingUnits) -> Contents:
    """Headings of a file, in the rows that have one."""
    values = sheet.numbers(columns.heading) * of.si(units.heading, of.ANGLE)
    rows = _measured(sheet, "heading", values[:, None])
    stamped = stamps(sheet, columns.time, units.time, rows)
    sigma = _sigma(sheet, (columns.sigma,), units.sigma, of.ANGLE)
    table = HeadingTable(stamped.time, values[rows], sigma[rows, 0])
    return Contents(stamped.clock, stamped.epoch, heading_aid=table, place=_places(sheet, rows))


def height(sheet: Sheet, columns: HeightColumns, units: HeightUnits) -> Contents:
    """Heights of a file, in the rows that have one."""
    values = sheet.numbers(columns.height) * of.si(units.height, of.LENGTH)
    rows = _measured(sheet, "height", values[:, None])
    stamped = stamps(sheet, columns.time, units.time, rows)
    sigma = _sigma(sheet, (columns.sigma,), units.sigma, of.LENGTH)
    table = HeightTable(stamped.time, values[rows], sigma[rows, 0])
    return Contents(stamped.clock, stamped.epoch, height_aid=table, place=_places(sheet, rows))


def reference(sheet: Sheet, columns: ReferenceColumns, units: ReferenceUnits) -> Contents:
    """Somebody else's solution in a file, in the rows that have any part of one."""
    attitude = _matrix(sheet, columns.attitude) * of.si(units.attitude, of.ANGLE)
    position = _position(sheet, columns.position, units.position, units.height)
    velocity = _matrix(sheet, columns.velocity) * of.si(units.velocity, of.VELOCITY)
    rows = _measured(sheet, "reference", attitude, position, velocity)
    stamped = stamps(sheet, columns.time, units.time, rows)
    table = ReferenceTable(stamped.time, attitude[rows], position[rows], velocity[rows])
    return Contents(stamped.clock, stamped.epoch, reference=table, place=_places(sheet, rows))


def _matrix(sheet: Sheet, columns: Sequence[str]) -> Array:
    """Columns side by side, those that are not there not a number."""
    nothing = np.full(len(sheet.cells), np.nan)
    return np.stack([sheet.numbers(name) if name else nothing for name in columns], axis=-1)


def _position(sheet: Sheet, columns: Three, angle: str, length: str) -> Array:
    angle_unit, length_unit = of.si(angle, of.ANGLE), of.si(length, of.LENGTH)
    return _matrix(sheet, columns) * [angle_unit, angle_unit, length_unit]


def _sigma(sheet: Sheet, columns: Sequence[str], unit: str, units: of.Units) -> Array:
    """Sigmas, 0 where they are not told."""
    return np.nan_to_num(_matrix(sheet, columns) * of.si(unit, units), nan=0.0)


def _measured(sheet: Sheet, table: str, *values: Array) -> NDArray[np.intp]:
    """Rows in which anything was measured."""
    rows = np.flatnonzero(np.isfinite(np.concatenate(values, axis=1)).any(axis=1))
    if len(rows) == 0:
        raise InputError(f"{sheet.path}: no row has anything for {table}")
    return rows


def _new(time: Array, values: Array) -> NDArray[np.intp]:
    """Rows that are not those before, where a table repeats its rows faster than any receiver measures."""
    if len(time) < 2 or np.median(np.diff(time)) > FASTEST_FIXES:
        return np.arange(len(time))
    same = ((values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))).all(axis=1)
    held = np.mean(same) > MOSTLY
    return np.flatnonzero(np.concatenate(([True], ~same))) if held else np.arange(len(time))


def _places(sheet: Sheet, rows: NDArray[np.intp]) -> Callable[[str, int], str]:
    return lambda _table, row: f"line {sheet.line(int(rows[row]))}"
