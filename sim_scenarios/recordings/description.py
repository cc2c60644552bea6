"""Recordings from their descriptions or from single files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from sim_scenarios import toml
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import axes, checks, clocks, fixes, halves, simultaneity, stamps
from sim_scenarios.recordings.order import in_order
from sim_scenarios.recordings.readers import delimited, formats, layouts, sheets
from sim_scenarios.recordings.readers.contents import Axes, Clock, Contents, Inertial
from sim_scenarios.recordings.sources import FOUND, Description, GnssSource, ImuSource, Source, describe
from sim_scenarios.recordings.tables import Array, ImuTable, LeverArms, Recording

TABLES: Final[Mapping[str, tuple[str, Callable[..., Contents]]]] = {
    "imu": ("imu", delimited.imu),
    "accelerometer": ("accelerometer", delimited.accelerometer),
    "gnss": ("gnss", delimited.gnss),
    "body_velocity": ("body_velocity", delimited.body_velocity),
    "heading": ("heading_aid", delimited.heading),
    "height": ("height_aid", delimited.height),
    "reference": ("reference", delimited.reference),
}
"""Tables of a description: what they are called in a recording, and what reads them of a text file."""

_AXES_OF_READER: Final = {
    None: axes.BODY,
    Axes.RIGHT_FORWARD_UP: "right-forward-up",
    Axes.FORWARD_RIGHT_DOWN: "forward-right-down",
    Axes.FORWARD_LEFT_UP: "forward-left-up",
}


@dataclass(frozen=True)
class _Read:
    """A table that was read."""

    name: str
    path: Path
    source: Source
    contents: Contents

    @property
    def table(self) -> Any:
        return getattr(self.contents, TABLES[self.name][0])

    @property
    def clock(self) -> Clock:
        return self.source.clock or self.contents.clock

    @property
    def epoch(self) -> float:
        return clocks.begins(self.contents.epoch, self.contents.clock, self.clock)

    @property
    def where(self) -> str:
        return f"{self.path}, {self.name}"

    def place(self, row: int) -> str:
        return f"{self.path}: {self.contents.place(TABLES[self.name][0], row)}"


def is_recording(path: Path) -> bool:
    """Whether a file is one for `load`: the description of a recording, or no TOML at all."""
    return path.is_file() and (path.suffix != ".toml" or "imu" in toml.read(path))


def load(path: Path) -> Recording:
    """Recording of a description (.toml), or of one file that has an IMU in it.

    Parameters
    ----------
    path : Path
        A description (`recordings.sources`); a CSV file in this product's plain form
        (`recordings.readers.plain`); or any file that a reader recognises, as that reads it.

    Returns
    -------
    Recording
        In SI units, right, forward, up, all stamps increasing on one clock (`recordings.clocks`).

    Raises
    ------
    InputError
        If a file is not what it is said to be, in a sentence that names it, the line where there is one, and
        the rule; or if what is read contradicts physics for certain (`recordings.checks`).
    """
    if path.suffix == ".toml":
        return _described(path, describe(path))
    contents = formats.read(path)
    if contents.imu is None:
        raise InputError(f"{path}: has no IMU; `truenorth import` drafts a description of several files")
    read = [
        _Read(name, path, Source(), contents)
        for name, (entry, _) in TABLES.items()
        if getattr(contents, entry) is not None
    ]
    to_body = axes.conversion(_AXES_OF_READER[contents.imu.axes])
    return _assembled(path, path.name.split(".")[0], read, to_body, LeverArms())


def _described(path: Path, said: Description) -> Recording:
    read = _read(path, said)
    lever_arms = LeverArms(
        **{
            name: table.lever_arm
            for name in ("gnss", "body_velocity")
            if (table := getattr(said, name)) is not None
        }
    )
    try:
        to_body = _to_body(said.imu, read[0].table)
    except InputError as error:
        raise InputError(f"{path}: imu: {error}") from None
    return _assembled(path, said.name or path.stem, read, to_body, lever_arms)


def _read(path: Path, said: Description) -> list[_Read]:
    """Tables of a description, the IMU first; every file is read once."""
    cells: dict[Path, sheets.Sheet] = {}
    whole: dict[tuple[Path, str | None], Contents] = {}
    read = []
    for name, (entry, of_cells) in TABLES.items():
        source = getattr(said, name)
        if source is None:
            continue
        file = path.parent / (source.file or said.imu.file)
        form = source.format or (None if source.file else said.imu.format)
        columns = source.columns
        if (
            said.accelerometer
            and name in ("imu", "accelerometer")
            and (form or formats.recognised(file)) == "csv"
        ):
            columns = (
                _angles_alone(path, said.imu) if name == "imu" else columns or layouts.AccelerometerColumns()
            )
        if columns is None:
            if "units" in source.model_fields_set:
                raise InputError(f"{path}: {name}: units are those of columns: say these too")
            if (file, form) not in whole:
                whole[file, form] = formats.read(file, form)
            contents = whole[file, form]
        elif form in (None, "csv"):
            if file not in cells:
                cells[file] = sheets.read(file)
            contents = of_cells(cells[file], columns, source.units)
        else:
            raise InputError(f"{path}: {name}: columns are those of a text file, not of the format {form}")
        if getattr(contents, entry) is None:
            raise InputError(f"{path}: {name}: there is none in {file}")
        read.append(_Read(name, file, source, contents))
    return read


def _angles_alone(path: Path, imu: ImuSource) -> layouts.ImuColumns:
    """Columns of an IMU whose forces stand elsewhere."""
    columns = imu.columns or layouts.ImuColumns()
    if "force" in columns.model_fields_set:
        raise InputError(f"{path}: imu.columns.force: there is a table accelerometer; say one of both")
    return columns.model_copy(update={"force": layouts.NONE})


def _to_body(said: ImuSource, imu: Inertial) -> Array:
    if said.mounting is not None and said.axes is None:
        raise InputError("mounting: say into which axes it leads, such as axes = 'forward-right-down'")
    return axes.conversion(said.axes or _AXES_OF_READER[imu.axes], said.mounting)


def _assembled(path: Path, name: str, read: list[_Read], to_body: Array, lever_arms: LeverArms) -> Recording:
    in_time = [_in_order(one) for one in read]
    told = {one.name: _told_offset(one, read[0].source) for one in read}
    of_tables = [
        clocks.Stamps(one.where, one.clock, one.epoch, table.time, told[one.name])
        for one, (table, _) in zip(read, in_time, strict=True)
    ]
    times = clocks.on_one_clock(of_tables)
    tables = {
        TABLES[one.name][0]: _as_described(replace(table, time=time), one.source)
        for one, (table, _), time in zip(read, in_time, times, strict=True)
    }
    remarks = [remark for one in read for remark in one.contents.remarks]
    remarks += [remark for _, of_table in in_time for remark in of_table]
    imu = tables.pop("imu")
    if "accelerometer" not in tables and np.isnan(imu.force).all():
        raise InputError(
            f"{read[0].where}: has no specific forces; a table accelerometer says where they are"
        )
    if (accelerometer := tables.pop("accelerometer", None)) is not None:
        where = {one.name: one.where for one in read}
        imu, left_out = halves.joined(imu, accelerometer, (where["imu"], where["accelerometer"]))
        remarks += [f"{path}: {remark}" for remark in left_out]
    recording = Recording(
        name=name,
        imu=_increments(imu, to_body, read[0].path),
        lever_arms=lever_arms,
        epoch=clocks.common_epoch(of_tables),
        remarks=tuple(dict.fromkeys(remarks)),
        **tables,
    )
    checks.refuse(recording, path)
    moved = next((one.name for one in read if one.source.offset == FOUND), None)
    own = {one.name: told[one.name] for one in read if one.name == "imu" or _is_half_with_offset(one)}
    said = next((s.velocity_offset for one in read if isinstance(s := one.source, GnssSource)), 0.0)
    return _simultaneous(recording, moved, own, said)


def _told_offset(one: _Read, imu: Source) -> float:
    """Seconds to add; accelerometers without an offset of their own have that of their IMU."""
    source = imu if one.name == "accelerometer" and not _is_half_with_offset(one) else one.source
    if source.offset != FOUND:
        return float(source.offset)
    if source is imu or one.name == "gnss":
        return 0.0
    raise InputError(f"{one.where}: offset = '{FOUND}': it is found of the IMU or of the fixes alone")


def _is_half_with_offset(one: _Read) -> bool:
    return one.name == "accelerometer" and "offset" in one.source.model_fields_set


def _simultaneous(
    recording: Recording, moved: str | None, told: Mapping[str, float], told_of_velocities: float
) -> Recording:
    """Recording of which IMU or fixes are moved so that one goes with the other; else what would is said.

    `told` are the offsets that the description has [s] of the IMU and, if they have their own, of its
    accelerometers; and of velocities their own.
    """
    gnss = recording.gnss
    if gnss is None:
        return recording
    said = []
    if (lag := simultaneity.of_velocities(gnss)) is not None and lag.is_certain:
        offset = told_of_velocities + lag.value
        said.append(
            f"gnss: velocities go with the positions of {abs(offset):.3f} s "
            f"{'before' if offset < 0 else 'after'} their stamps; say velocity_offset = {offset:.3f}"
        )
        gnss = fixes.with_velocities_later(gnss, lag.value)
    lag = simultaneity.of_imu(recording.imu, gnss, recording.lever_arms.gnss)
    if lag is None or not lag.is_certain:
        if moved is not None:
            shown = (
                "none" if lag is None else f"{lag.value:.3f} s, sigma {lag.sigma:.2g} s, which may be chance"
            )
            said.append(f"{moved}: offset = '{FOUND}': how IMU and fixes move shows {shown}; stamps stay")
        return replace(recording, remarks=(*recording.remarks, *said))
    offsets = [f"offset = {offset + lag.value:.3f}" for offset in told.values()]
    with_offsets = " and its accelerometers with ".join(offsets)
    late = f"imu: its samples go with the fixes with {with_offsets} (sigma {lag.sigma:.2g} s)"
    if moved is None:
        ahead = "" if any(recording.lever_arms.gnss) else ", if the lever arm, which is 0 here, is right"
        said.append(f"{late}; say so, or offset = '{FOUND}'{ahead}")
        return replace(recording, remarks=(*recording.remarks, *said))
    table, by = getattr(recording, moved), lag.value if moved == "imu" else -lag.value
    tables: dict[str, Any] = {moved: replace(table, time=table.time + by)}
    said.append(f"{late}; the stamps of {moved} were moved by {by:.3f} s")
    return replace(recording, **tables, remarks=(*recording.remarks, *said))


def _in_order(one: _Read) -> tuple[Any, list[str]]:
    """A table in order, without what a receiver writes before its first fix, and remarks."""
    table, remarks = in_order(one.table, one.clock, one.source.stamps, one.place)
    if one.name != "gnss" or not (nowhere := fixes.before_the_first(table)).any():
        return table, remarks
    count = int(np.count_nonzero(nowhere))
    remark = f"{one.path}: latitude 0, longitude 0 before the first fix, {count} times, left out"
    return fixes.selected(table, ~nowhere), [*remarks, remark]


def _increments(imu: Inertial, to_body: Array, path: Path) -> ImuTable:
    """Increments in right, forward, up; a rate holds over what its sample covers."""
    if len(imu.time) < 2:
        raise InputError(f"{path}: has {len(imu.time)} samples; an alignment needs many")
    covers = np.ones(1) if imu.increments else stamps.intervals(imu.time)
    with np.errstate(invalid="ignore"):  # what is not finite makes its sample not a number
        return ImuTable(
            imu.time, imu.angular * covers[:, None] @ to_body.T, imu.force * covers[:, None] @ to_body.T
        )


def _as_described(table: Any, source: Source) -> Any:
    """Table with the sigmas of its description, where there are any, and its velocities at its stamps."""
    if isinstance(source, GnssSource) and source.velocity_offset:
        table = fixes.with_velocities_later(table, source.velocity_offset)
    given = {
        name: np.broadcast_to(np.array(sigma), getattr(table, name).shape)
        for name in ("position_sigma", "velocity_sigma", "sigma")
        if (sigma := getattr(source, name, None)) is not None
    }
    return replace(table, **given)
