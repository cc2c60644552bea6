"""A first draft of a description, by looking at the files: every guess says why it was made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import (
    ahead,
    checks,
    clocks,
    forces,
    guessed_tables,
    guesses,
    halves,
    simultaneity,
    stamps,
    turns,
)
from sim_scenarios.recordings.clocks import Stamps
from sim_scenarios.recordings.description import TABLES
from sim_scenarios.recordings.fixes import with_velocities_later
from sim_scenarios.recordings.guesses import Guess
from sim_scenarios.recordings.readers import formats, plain, sheets
from sim_scenarios.recordings.readers.columns import incomplete, likely, of_one_sensor
from sim_scenarios.recordings.readers.contents import Clock, Contents
from sim_scenarios.recordings.readers.sheets import Sheet
from sim_scenarios.recordings.sources import FOUND
from sim_scenarios.recordings.tables import ImuTable, finite
from sim_scenarios.toml import comment, written
from sim_scenarios.units import DEGREE

LEVER_ARM: Final = Guess([0.0, 0.0, 0.0], "fill in: from the IMU to it, right, forward, up [m]")
TELLING: Final = 0.5
"""Correlation of turns that tells apart units of which one is 57 times the other."""
_MOUNTING: Final = (
    "# mounting = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
    "# fill in if the sensor is not mounted along the vehicle's axes: the matrix that takes its vectors\n"
    '# into `axes`, which then are those of the vehicle, such as "forward-right-down"'
)


@dataclass
class Part:
    """A table of the description that is drafted."""

    table: str
    path: Path
    contents: Contents
    entries: dict[str, Guess] = field(default_factory=dict)
    incomplete: tuple[str, ...] = ()
    """Columns beside it along one axis or two."""

    @property
    def rows(self) -> Any:
        """What was read."""
        return getattr(self.contents, TABLES[self.table][0])

    @property
    def is_half(self) -> bool:
        """Whether it is an IMU without forces, or forces without angles."""
        return self.table == "accelerometer" or (
            self.table == "imu" and bool(np.isnan(self.rows.force).all())
        )

    @property
    def clock(self) -> Clock:
        """Clock that was guessed, or that the reader knows."""
        said = self.entries.get("clock")
        return Clock(said.value) if said else self.contents.clock

    def stamps(self, clock: Clock | None = None) -> Stamps:
        """Its stamps, on a clock that is tried."""
        clock = clock or self.clock
        time = clocks.unwrapped(self.rows.time, clock)
        epoch = clocks.begins(self.contents.epoch, self.contents.clock, clock)
        return Stamps(str(self.path), clock, epoch, time)


def draft(files: Sequence[Path], folder: Path) -> tuple[str, list[str]]:
    """Description of files that were recorded together.

    Parameters
    ----------
    files : sequence of Path
        In any order; what each is for is found.
    folder : Path
        Where the description will stand.

    Returns
    -------
    text : str
        TOML.
    guesses : list of str
        A sentence on each, and on each table that was left out.

    Raises
    ------
    InputError
        If no file has an IMU, or nothing is recognised in one.
    """
    found: list[list[Part]] = []
    for path in files:
        if not (of_file := _parts(path)):
            raise InputError(f"{path}: has neither an IMU nor an aid that can be recognised")
        found.append(of_file)
    parts, left_out = _chosen(found)
    _check_imu(parts, files)
    ordered = [parts[table] for table in TABLES if table in parts]
    _guess_clocks(ordered)
    if "accelerometer" in parts:
        _join(parts["imu"], parts["accelerometer"])
    _guess_turns(parts["imu"], parts.get("gnss"))
    _guess_axes(parts["imu"], parts.get("gnss"))
    for table in ("gnss", "body_velocity"):
        if table in parts:
            parts[table].entries["lever_arm"] = LEVER_ARM
    if "gnss" in parts and (lag := simultaneity.of_velocities(parts["gnss"].rows)) and lag.is_certain:
        why = f"so positions and velocities go together; sigma {lag.sigma:.2g} s"
        parts["gnss"].entries["velocity_offset"] = Guess(round(lag.value, 4), why)
    _guess_offset(parts)
    return _text(ordered, left_out, folder), left_out + [
        f"{part.table}.{key} = {written(guess.value)}: {guess.why}"
        for part in ordered
        for key, guess in part.entries.items()
    ]


def _chosen(files: list[list[Part]]) -> tuple[dict[str, Part], list[str]]:
    """One part of each table, and a sentence on each that is left out.

    Of several, an aid of a file of its own: receivers know better than what an IMU copied of them.
    """
    parts: dict[str, Part] = {}
    left_out = []
    for of_file in sorted(files, key=lambda of_file: max(map(_rank, of_file))):
        for part in of_file:
            if taken := parts.get(part.table):
                left_out.append(f"{part.table} of {part.path.name}: left out, {taken.path.name} has it too")
            else:
                parts[part.table] = part
    if "imu" in parts and not parts["imu"].is_half and (spare := parts.pop("accelerometer", None)):
        left_out.append(f"accelerometer of {spare.path.name}: left out, {parts['imu'].path.name} has one too")
    return parts, left_out


def _rank(part: Part) -> int:
    """Aids come before IMUs, and those before halves of them."""
    return 2 if part.is_half else int(part.table == "imu")


def _check_imu(parts: dict[str, Part], files: Sequence[Path]) -> None:
    """Refuse files without an IMU, or with half of one."""
    half = parts.get("accelerometer") or parts.get("imu")
    if half is None:
        raise InputError(f"{', '.join(map(str, files))}: none has an IMU")
    if half.is_half and len({"imu", "accelerometer"} & set(parts)) == 1:
        halves = {"imu": ("angular", "angular rates"), "accelerometer": ("force", "specific forces")}
        key, has = halves.pop(half.table)
        [(_, lacks)] = halves.values()
        named = half.entries.get(f"columns.{key}")
        what = ", ".join(named.value) if named else f"its {has}"
        but = f" but {', '.join(half.incomplete)}, which are not along three axes" if half.incomplete else ""
        raise InputError(
            f"{half.path}: {what} are of an IMU, and there are no {lacks} beside them{but}: name the file "
            "that has them too; beside positions, velocities or an attitude they are no half of an IMU"
        )


def _join(imu: Part, accelerometer: Part) -> None:
    """Bring the forces onto the stamps of the angles."""
    rows = []
    for part, time in zip(
        (imu, accelerometer), clocks.on_one_clock([imu.stamps(), accelerometer.stamps()]), strict=True
    ):
        once, first = np.unique(time, return_index=True)
        table = part.rows
        rows.append(replace(table, time=once, angular=table.angular[first], force=table.force[first]))
    gyros, accelerometers = rows
    late = gyros.time[0] - np.min(imu.stamps().time)
    joined, _ = halves.joined(gyros, accelerometers, (str(imu.path), str(accelerometer.path)))
    imu.contents = replace(imu.contents, imu=replace(joined, time=joined.time - late))


def _parts(path: Path) -> list[Part]:
    """Tables that a file has."""
    if formats.recognised(path) == "csv" and not plain.recognises(path):
        return _of_cells(sheets.read(path))
    form = formats.recognised(path)
    contents = formats.read(path, form)
    why = "our own columns" if form == "csv" else "by what is in the file"
    return [
        Part(table, path, contents, {"format": Guess(form, why)})
        for table, (entry, _) in TABLES.items()
        if getattr(contents, entry) is not None
    ]


def _of_cells(sheet: Sheet) -> list[Part]:
    """Tables that the columns of a text file are likely to hold."""
    names = sheet.habits.names
    columns = likely(names) if sheet.habits.header else guessed_tables.unnamed(sheet)
    if "time" not in columns and (growing := guessed_tables.growing(sheet)):
        columns["time"] = growing[:1]
    if "time" not in columns:
        raise InputError(f"{sheet.path}: no column of {', '.join(names[:20])} seems to be a time")
    why = "by their names" if sheet.habits.header else "there is no header: by size and steadiness"
    if set(columns) == {"time"} and (of_one := of_one_sensor(names, sheet.path.name)):
        columns |= of_one
        why = "by their names and that of the file"
    parts = []
    for table, told in guessed_tables.tables(sheet, columns).items():
        named = {
            f"columns.{key}": Guess(_single(value), why) for key, value in told.columns.items() if any(value)
        }
        units = {f"units.{key}": guess for key, guess in told.units.items()}
        contents = TABLES[table][1](sheet, *told.models())
        parts.append(Part(table, sheet.path, contents, {**named, **units}, incomplete(names)))
    if not parts:
        raise InputError(
            f"{sheet.path}: has neither an IMU nor an aid that can be recognised; its columns are "
            f"{', '.join(names[:20])}"
        )
    return parts


def _single(names: tuple[str, ...]) -> object:
    return names[0] if len(names) == 1 else list(names)


def _guess_clocks(parts: list[Part]) -> None:
    """Clocks of the tables whose files do not say them: by size, by name, so that spans and turns agree."""
    for part in parts:
        counted = part.clock is Clock.OWN or "units.time" in part.entries
        if counted and (guess := guesses.dated(part.path, part.stamps(), _time_name(part))):
            part.entries["clock"] = guess
    named = next((part for part in parts if part.clock.dated), None)
    for part in parts:
        if named is None or part.clock is not Clock.OWN:
            continue
        fitting = [clock for clock in _UNDATED if _together(named.stamps(), part.stamps(clock))]
        if not fitting:
            continue
        why = f"with it the stamps overlap those of {named.path.name}"
        if late := _late(parts[0], part, named, fitting):
            fitting.sort(key=lambda clock: late.get(clock, math.inf))
            why += f", and turns go with the course to {late[fitting[0]]:.1f} s"
        elif "utc" in _time_name(part) and Clock.UTC_DAY in fitting:
            fitting = [Clock.UTC_DAY]
        elif len(fitting) > 1:
            why += f"; check: so they would as {' or '.join(clock.value for clock in fitting[1:])}"
        part.entries["clock"] = Guess(fitting[0].value, why)


_UNDATED: Final = (Clock.GPS_DAY, Clock.UTC_DAY, Clock.GPS_WEEK)


def _late(imu: Part, part: Part, named: Part, fitting: list[Clock]) -> dict[Clock, float]:
    """How far turns of the IMU and of the course are apart on each clock [s], where it can be seen."""
    if {imu.table, part.table, named.table} != {"imu", "gnss"}:
        return {}
    late = {}
    for clock in fitting:
        both = [
            one.stamps(clock if one is part else None) for one in (imu, part if part is not imu else named)
        ]
        time, of_fixes = clocks.on_one_clock(both)
        gnss = replace((named if part is imu else part).rows, time=of_fixes)
        if (found := turns.compare(replace(_increments(imu), time=time), gnss)) is not None:
            late[clock] = abs(found.lag)
    return late


def _time_name(part: Part) -> str:
    named = part.entries.get("columns.time")
    return str(named.value).casefold() if named else ""


def _together(one: Stamps, other: Stamps) -> bool:
    longest = other.clock.repeats
    if other.time[0] + other.epoch < 0 or other.time[0] + other.epoch > longest:
        return False
    try:
        clocks.on_one_clock([one, other])
    except InputError:
        return False
    return True


def _guess_turns(imu: Part, gnss: Part | None) -> None:
    """Degrees or radians, where size alone told them: those that turn as the course does."""
    guess = imu.entries.get("units.angular")
    if gnss is None or guess is None or not guess.why.startswith(guessed_tables.BY_SIZE):
        return
    with suppress(InputError):  # of spans that do not overlap, which loading the description tells
        time, of_fixes = clocks.on_one_clock([imu.stamps(), gnss.stamps()])
        fixes = replace(gnss.rows, time=of_fixes)
        found = turns.compare(replace(_increments(imu), time=time), fixes)
        if found is None or abs(found.correlation) < TELLING:
            return
        of_degrees = guess.value.startswith("deg")
        times = abs(found.slope) * (DEGREE if of_degrees else 1.0)  # as far as the numbers say
        for unit, factor in (("rad", 1.0), ("deg", DEGREE)):
            if checks.turns_alike(times / factor):
                why = f"the course turns {times:.3g} times as far as the numbers say"
                imu.entries["units.angular"] = Guess(
                    guess.value.replace("deg", unit).replace("rad", unit), why
                )
                told = imu.rows.angular * factor / (DEGREE if of_degrees else 1.0)
                imu.contents = replace(imu.contents, imu=replace(imu.rows, angular=told))


def _guess_axes(imu: Part, gnss: Part | None) -> None:
    if imu.rows.axes is not None or plain.recognises(imu.path):
        return
    table, forward = _increments(imu), None
    if gnss is not None and (gnss.clock is Clock.OWN) == (imu.clock is Clock.OWN):
        with suppress(InputError):  # of spans that do not overlap, which loading the description tells
            time, of_fixes = clocks.on_one_clock([imu.stamps(), gnss.stamps()])
            forward = ahead.find(replace(table, time=time), replace(gnss.rows, time=of_fixes))
    imu.entries["axes"] = guesses.axes(forces.mean_direction(table), forward)


def _guess_offset(parts: dict[str, Part]) -> None:
    """Whether an IMU and fixes from different files are late against one another, by how they move.

    A host stamps all that it records when it arrives: its IMU moves, unless other tables are on its clock.
    """
    imu, gnss = parts["imu"], parts.get("gnss")
    if gnss is None or gnss.path == imu.path or (gnss.clock is Clock.OWN) != (imu.clock is Clock.OWN):
        return
    with suppress(InputError):  # of spans that do not overlap, which loading the description tells
        time, of_fixes = clocks.on_one_clock([imu.stamps(), gnss.stamps()])
        fixes = replace(gnss.rows, time=of_fixes)
        if offset := gnss.entries.get("velocity_offset"):
            fixes = with_velocities_later(fixes, offset.value)
        lag = simultaneity.of_imu(replace(_increments(imu), time=time), fixes, (0.0, 0.0, 0.0))
        if lag is not None and lag.is_certain:
            alone = all(part is imu or part.path != imu.path for part in parts.values())
            why = (
                f"{lag.value if alone else -lag.value:.3f} s, by how IMU and fixes move, lever arm 0; "
                "found again, with the lever arm, when this is read"
            )
            (imu if alone else gnss).entries["offset"] = Guess(FOUND, why)


def _increments(imu: Part) -> ImuTable:
    """Increments in the sensor's own axes; with stamps that hardly rise, which loading tells, the rates."""
    rising = np.median(np.diff(imu.rows.time)) > 0
    covers = stamps.intervals(imu.rows.time) if rising and not imu.rows.increments else np.ones(1)
    angular, force = (finite(half) * covers[:, None] for half in (imu.rows.angular, imu.rows.force))
    return ImuTable(imu.rows.time, angular, force)


def _text(parts: list[Part], left_out: list[str], folder: Path) -> str:
    files = ", ".join(dict.fromkeys(part.path.name for part in parts))
    lines = [comment(f"Drafted by `truenorth import` from {files}. Each guess says why; mend what is wrong.")]
    lines += [*map(comment, left_out), ""]
    imu = parts[0]
    for part in parts:
        lines.append(f"[{part.table}]")
        if part is imu or part.path != imu.path:
            lines.append(f"file = {written(_relative(part.path, folder))}")
        for key, guess in part.entries.items():
            lines += [comment(guess.why), f"{key} = {written(guess.value)}"]
        if part is imu and "axes" in part.entries:
            lines.append(_MOUNTING)
        lines.append("")
    return "\n".join(lines)


def _relative(path: Path, folder: Path) -> str:
    whole = path.resolve()
    return (
        whole.relative_to(folder.resolve()) if whole.is_relative_to(folder.resolve()) else whole
    ).as_posix()
