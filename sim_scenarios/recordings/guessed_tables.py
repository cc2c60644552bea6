"""Tables of a description that the columns of a text file are likely to hold, and their units.

A unit is that which a name ends with, if a size does not speak against it; else that which makes a force the
size of gravity, turns as fast as the force turns, and steps as long as loggers make them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd
from pydantic import BaseModel

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import forces, stamps, tracks
from sim_scenarios.recordings import units as of
from sim_scenarios.recordings.guesses import Guess
from sim_scenarios.recordings.readers import columns as named
from sim_scenarios.recordings.readers import delimited, layouts
from sim_scenarios.recordings.readers.contents import Inertial
from sim_scenarios.recordings.readers.sheets import Sheet
from sim_scenarios.recordings.readers.time_columns import ISO, TIME_OF_DAY
from sim_scenarios.recordings.tables import Array, ImuTable, finite
from sim_scenarios.units import STANDARD_GRAVITY

Columns = Mapping[str, tuple[str, ...]]
"""Names of columns by what they are likely to hold."""

IMU_STEPS: Final = (1e-4, 0.11)  # s between samples
AID_STEPS: Final = (0.02, 21.0)  # s
SOLUTION_STEPS: Final = (IMU_STEPS[0], AID_STEPS[1])
LEAST_COUNTS: Final = 2.0
"""Steps between stamps below which fractions tell that these count seconds, as of 1 Hz or 2 Hz."""
NEAR_GRAVITY: Final = 1.25
"""Factor by which a mean force may differ from gravity to tell its unit."""
FASTEST: Final = 40.0  # rad/s, more than 2000 deg/s
LEAST_STEADY: Final = 0.3
"""Least share of a force that lasts: gravity does, unless an IMU is turned over and over."""
SMALLEST_COUNT: Final = 1000.0
"""From which on a latitude or a longitude is a whole number of 1e-7 deg, as receivers put it out."""
BY_SIZE: Final = "check: by size alone"
"""Of a unit that nothing else tells."""
COUNTS: Final = "check: counts?"
"""Of a force that has the size of gravity in none."""
_FORCES: Final = ("m/s2", "g", "mg")
_KINDS_OF_IMU: Final = (layouts.ImuColumns, layouts.ImuUnits)


@dataclass(frozen=True)
class Told:
    """What is guessed of the columns of a table."""

    columns: Columns
    units: Mapping[str, Guess]
    kinds: tuple[type[BaseModel], type[BaseModel]]

    def models(self) -> tuple[BaseModel, BaseModel]:
        """Columns and units, as a reader takes them."""
        single = {key: value[0] if len(value) == 1 else value for key, value in self.columns.items()}
        return (
            self.kinds[0].model_validate(single),
            self.kinds[1].model_validate({key: guess.value for key, guess in self.units.items()}),
        )


def tables(sheet: Sheet, columns: Columns) -> dict[str, Told]:
    """Tables of a description for which a file has likely columns.

    A file with an attitude and without an IMU is somebody's solution, whose positions are no fixes.
    """
    time = {"time": columns["time"]}
    found = {}
    if {"angular", "force"} <= set(columns):
        found["imu"] = _imu(sheet, _some(columns, "time", "angular", "force"))
    elif {"attitude", "position", "velocity"} & set(columns):
        pass  # rates and accelerations of a solution or of a receiver are no half of an IMU
    elif "angular" in columns:
        found["imu"] = _gyros(sheet, {**_some(columns, "time", "angular"), "force": layouts.NONE})
    elif "force" in columns:
        found["accelerometer"] = _accelerometers(sheet, _some(columns, "time", "force"))
    solution = "attitude" in columns and not found
    steps = IMU_STEPS if found else SOLUTION_STEPS if solution else AID_STEPS
    unit = {"time": _time(sheet, columns["time"][0], steps)}
    if not solution and {"position", "velocity"} & set(columns):
        told = _some(columns, "time", "position", "velocity", "position_sigma", "velocity_sigma")
        found["gnss"] = _moving(sheet, told, unit, (layouts.GnssColumns, layouts.GnssUnits))
    if "forward" in columns:
        told = {**time, "velocity": ("", *columns["forward"], "")}
        units = {**unit, "velocity": _speed(columns["forward"][0])}
        found["body_velocity"] = Told(told, units, (layouts.BodyVelocityColumns, layouts.BodyVelocityUnits))
    if "attitude" in columns:
        told = _some(columns, "time", "attitude", *(("position", "velocity") if solution else ()))
        units = {**unit, "attitude": _angle(sheet, columns["attitude"])}
        found["reference"] = _moving(sheet, told, units, (layouts.ReferenceColumns, layouts.ReferenceUnits))
    elif "heading" in columns:
        units = {**unit, "heading": _angle(sheet, columns["heading"])}
        told = _some(columns, "time", "heading")
        found["heading"] = Told(told, units, (layouts.HeadingColumns, layouts.HeadingUnits))
    if "height" in columns:
        told = _some(columns, "time", "height")
        found["height"] = Told(told, unit, (layouts.HeightColumns, layouts.HeightUnits))
    return found


def _some(columns: Columns, *keys: str) -> dict[str, tuple[str, ...]]:
    return {key: columns[key] for key in keys if key in columns}


def unnamed(sheet: Sheet) -> dict[str, tuple[str, ...]]:
    """Time, angular and force columns of a file without a header.

    Time increases; of the first two triples of the rest, that with the steadier size is the force.
    """
    numbers = _numbers(sheet)
    if not (time := growing(sheet)[:1]):
        return {}
    rest = [n for n in numbers if n not in time]
    if len(rest) < 6:
        return {"time": time}
    triples = [tuple(rest[:3]), tuple(rest[3:6])]
    sizes = [np.linalg.norm(np.stack([numbers[n] for n in triple]), axis=0) for triple in triples]
    angular, force = sorted(triples, key=lambda t: -_unsteadiness(sizes[triples.index(t)]))
    return {"time": time, "angular": angular, "force": force}


def growing(sheet: Sheet) -> tuple[str, ...]:
    """Columns whose numbers increase nearly from row to row, as those of stamps do."""
    return tuple(name for name, values in _numbers(sheet).items() if (np.diff(values) > 0).mean() > 0.99)


def _numbers(sheet: Sheet) -> dict[str, Array]:
    names = sheet.habits.names
    return {n: sheet.numbers(n) for n in names if pd.api.types.is_numeric_dtype(sheet.cells[n])}


def _unsteadiness(size: Array) -> float:
    return float(np.nanstd(size) / max(float(np.nanmean(size)), 1e-30))


def _time(sheet: Sheet, name: str, steps: tuple[float, float]) -> Guess:
    cells = sheet.column(name)
    if not pd.api.types.is_numeric_dtype(cells):
        text = str(cells.dropna().iloc[0]) if cells.notna().any() else ""
        if len(cells) > 1 and pd.to_numeric(cells[1:], errors="coerce").notna().all():
            raise InputError(
                f"{sheet.path}: line {sheet.line(0)}: {name} holds '{text}', and numbers below it: take "
                "out the second line of a header"
            )
        return Guess(TIME_OF_DAY if ":" in text[:3] else ISO, f"stamps such as {text}")
    numbers = sheet.numbers(name)
    differences = np.diff(numbers[np.isfinite(numbers)])
    step = float(np.median(differences[differences > 0])) if (differences > 0).any() else math.nan
    units = ("s", "ms", "us", "ns")
    said = named.unit(name, units)
    counted = step >= LEAST_COUNTS or bool((differences == np.rint(differences)).all())
    if said and steps[0] <= step * of.TIME[said] <= max(steps[1], 1.0):
        return Guess(said, f"by the name {name}, with steps of {step:.4g}")
    for unit in units if counted else units[:1]:
        if steps[0] <= step * of.TIME[unit] <= steps[1]:
            doubt = "; check: or are they seconds?" if step == 1.0 and unit != "s" else ""
            return Guess(unit, f"with steps of {step:.4g}, {1 / (step * of.TIME[unit]):.4g} Hz{doubt}")
    return Guess("s", f"check: steps are {step:.4g}")


def _inertial(sheet: Sheet, columns: Columns, *measured: str) -> tuple[Guess, Inertial]:
    """The samples as they are logged, of which some columns are measured, and the guess of their time."""
    time = _time(sheet, columns["time"][0], IMU_STEPS)
    read = delimited.imu(
        sheet, layouts.ImuColumns.model_validate(columns), layouts.ImuUnits(time=time.value)
    ).imu
    assert read is not None
    _check_samples(sheet, _some(columns, *measured), read.time)
    return time, replace(read, angular=finite(read.angular), force=finite(read.force))


def _imu(sheet: Sheet, columns: Columns) -> Told:
    time, read = _inertial(sheet, columns, "angular", "force")
    order = np.argsort(read.time, kind="stable")
    _, first = np.unique(read.time[order], return_index=True)
    rows = order[first]
    period = stamps.period(read.time[rows])
    mean = forces.mean_size(read.force[rows], read.time[rows])
    force = _force(columns["force"][0], mean, period)
    _check_gravity(sheet, columns["force"], read.force, force)
    increments = of.measures(force.value, of.DELTA_VELOCITY)
    raw = ImuTable(
        read.time[rows],
        read.angular[rows] * (1.0 if increments else stamps.intervals(read.time[rows])[:, None]),
        read.force[rows],
    )
    angular = _angular(columns["angular"][0], raw.time, read.angular, increments, forces.tilts(raw))
    return Told(columns, {"time": time, "angular": angular, "force": force}, _KINDS_OF_IMU)


def _gyros(sheet: Sheet, columns: Columns) -> Told:
    """Angles alone: increments if their name says so."""
    time, read = _inertial(sheet, columns, "angular")
    name = columns["angular"][0]
    angular = _angular(name, np.unique(read.time), read.angular, named.is_increment(name))
    return Told(columns, {"time": time, "angular": angular}, _KINDS_OF_IMU)


def _accelerometers(sheet: Sheet, columns: Columns) -> Told:
    """Forces alone."""
    time = _time(sheet, columns["time"][0], IMU_STEPS)
    kinds = (layouts.AccelerometerColumns, layouts.AccelerometerUnits)
    read = delimited.accelerometer(
        sheet,
        layouts.AccelerometerColumns.model_validate(columns),
        layouts.AccelerometerUnits(time=time.value),
    ).accelerometer
    assert read is not None
    _check_samples(sheet, _some(columns, "force"), read.time)
    stamps_once, first = np.unique(read.time, return_index=True)
    values = finite(read.force[first])
    mean = forces.mean_size(values, stamps_once)
    force = _force(columns["force"][0], mean, stamps.period(stamps_once))
    _check_gravity(sheet, columns["force"], values, force)
    return Told(columns, {"time": time, "force": force}, kinds)


def _check_samples(sheet: Sheet, columns: Columns, time: Array) -> None:
    """Refuse what is too little to guess anything from."""
    if (count := len(np.unique(time))) < 2:
        raise InputError(f"{sheet.path}: has {count} samples; an alignment needs many")
    for names in columns.values():
        known = np.isfinite([sheet.numbers(name) for name in names])
        for name, of_column in zip(names, known, strict=True):
            if not of_column.any():
                raise InputError(f"{sheet.path}: column {name} has no number in it")
        if not known.all(axis=0).any():
            raise InputError(f"{sheet.path}: no row has a number in each of the columns {', '.join(names)}")


def _check_gravity(sheet: Sheet, names: Sequence[str], values: Array, force: Guess) -> None:
    """Refuse counts of a force that points nowhere for long, as accelerations without gravity do."""
    lasting = float(np.linalg.norm(np.nanmean(values, axis=0)))
    size = float(np.nanmean(np.linalg.norm(values, axis=1)))
    if force.why.startswith(COUNTS) and not lasting > LEAST_STEADY * size:
        raise InputError(
            f"{sheet.path}: {', '.join(names)} are {size:.3g} in size and {lasting:.3g} in the mean: gravity "
            "is not in them, which an IMU feels; accelerations that it was taken from are of no use"
        )


def _force(name: str, mean: float, period: float) -> Guess:
    """Unit of a force by the size of gravity: the mean size as it stands in the file.

    At 10 Hz, a velocity gained in m/s looks like a force in g: then the name decides, or it is a force.
    """
    by_name = f" by the name {name}, and" if named.is_increment(name) or named.unit(name, _FORCES) else ""
    rates = {} if named.is_increment(name) else {unit: mean * of.SPECIFIC_FORCE[unit] for unit in _FORCES}
    increments = {unit: mean * of.DELTA_VELOCITY[unit] / period for unit in ("m/s", "g*s")}
    for kind, sizes in (("rates", rates), ("increments", increments)):
        for unit, size in sizes.items():
            if size > 0 and abs(math.log(size / STANDARD_GRAVITY)) < math.log(NEAR_GRAVITY):
                over = f" over {period:.4g} s" if kind == "increments" else ""
                return Guess(unit, f"{kind},{by_name} gravity is {mean:.4g} in the mean{over}")
    return Guess(
        f"{STANDARD_GRAVITY / max(mean, 1e-30):.6g} m/s2",
        f"{COUNTS} the mean of {mean:.4g} is taken for gravity",
    )


def _angular(
    name: str, time: Array, values: Array, increments: bool, tilts: forces.Tilts | None = None
) -> Guess:
    """Degrees or radians; `tilts` are those with angles in the unit of the file."""
    degrees, radians = ("deg", "rad") if increments else ("deg/s", "rad/s")
    if said := named.unit(name, (degrees, radians)):
        return Guess(said, f"by the name {name}")
    if tilts is not None and tilts.correlation > 0.5 and tilts.slope > 0:
        unit = degrees if tilts.slope < 1 / 8 else radians
        return Guess(unit, f"the force turns {tilts.slope:.3g} times as far as the numbers say")
    period = stamps.period(time) if increments else 1.0
    fast = float(np.nanquantile(np.abs(values), 0.999)) / period
    if fast > FASTEST:
        return Guess(degrees, f"{fast:.3g} rad/s would be too fast")
    middle = float(np.nanmedian(np.linalg.norm(values, axis=1))) / period
    unit = radians if middle < 0.05 else degrees
    return Guess(unit, f"{BY_SIZE}, {middle:.3g} in the middle")


def _moving(
    sheet: Sheet, columns: Columns, units: Mapping[str, Guess], kinds: tuple[type[BaseModel], type[BaseModel]]
) -> Told:
    """Table with positions and velocities, as far as there are columns for them."""
    guessed = dict(units)
    if "position" in columns:
        guessed["position"] = _place(sheet, columns, units["time"])
    if "velocity" in columns:
        guessed["velocity"] = _speed(columns["velocity"][0])
    return Told(columns, guessed, kinds)


def _place(sheet: Sheet, columns: Columns, time: Guess) -> Guess:
    latitude, longitude, _ = columns["position"]
    if said := named.unit(latitude, ("deg", "rad")):
        return Guess(said, f"by the name {latitude}")
    largest = _largest(sheet, (latitude, longitude))
    if largest > SMALLEST_COUNT:
        return Guess("1e-7 deg", f"up to {largest:.4g}, as whole numbers of receivers are")
    if largest <= math.pi and "velocity" in columns:
        told = layouts.GnssColumns.model_validate(_some(columns, "time", "position", "velocity"))
        fixes = delimited.gnss(sheet, told, layouts.GnssUnits(time=time.value, position="rad")).gnss
        if fixes is not None and tracks.explanations(fixes)[0] < tracks.GOOD:
            return Guess("rad", f"up to {largest:.4g}, and as radians they move as the velocities say")
    return Guess("deg", f"up to {largest:.4g}")


def _largest(sheet: Sheet, names: Sequence[str]) -> float:
    sizes = np.abs([sheet.numbers(name) for name in names])
    return float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))


def _speed(name: str) -> Guess:
    if said := named.unit(name, ("m/s", "km/h")):
        return Guess(said, f"by the name {name}")
    return Guess("m/s", "check: taken for granted")


def _angle(sheet: Sheet, names: Sequence[str]) -> Guess:
    if said := named.unit(names[0], ("deg", "rad")):
        return Guess(said, f"by the name {names[0]}")
    largest = _largest(sheet, names)
    return Guess("deg" if largest > 2 * math.pi else "rad", f"up to {largest:.4g}")
