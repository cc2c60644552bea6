"""NovAtel OEM and SPAN logs in ASCII: `#NAMEA,header;fields*crc`, and `%NAMESA,...` with the short header.

    RAWIMUX, RAWIMUSX, RAWIMU, RAWIMUS       counts of the IMU in its own axes: increments. Which way the axes
                                             point depends on how it is mounted
    INSCONFIG                                which IMU it is, where RAWIMU does not say
    BESTGNSSPOS, BESTGNSSVEL                 position and velocity of the antenna; without them BESTPOS and
                                             BESTVEL, unless of the inertial solution (types INS_...)
    INSPVA, INSPVAS, INSPVAX                 the unit's own solution: reference
    HEADING, HEADING2, DUALANTENNAHEADING    direction from the first to the second antenna: heading

Counts become increments with the scale of each IMU in "Raw IMU Scale Factors"; Epson's IMUs count rates, of
their documented sample rate. Heights are above the ellipsoid (height plus undulation; INSPVA has it so). A
velocity is valid its latency before its header's time. Clock.GPS; logs from before the receiver knew the week
are passed over, so are all others, and so is what stands between logs.

CORRIMUDATA, CORRIMUS and IMURATECORRIMUS are not read: gravity and the Earth's rotation are taken out of
them, so that they are no specific force.

Source: OEM7 Commands and Logs Reference Manual, OM-20000169; scales also in oem7_imu.cpp of
novatel_oem7_driver.
"""

from __future__ import annotations

import math
import re
import zlib
from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import gps_time
from sim_scenarios.recordings.readers.contents import Clock, Contents, Inertial
from sim_scenarios.recordings.readers.epochs import Fixes, Headings, References
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.units import ARCMIN, DEGREE, STANDARD_GRAVITY

_BEGIN: Final = re.compile(rb"([#%])([A-Z][A-Z0-9]*)A,")
_LOG: Final = re.compile(rb"[#%]([^;*]*);([^*]*)\*([0-9a-fA-F]{8})\s*")
_POSITIONS: Final = ("BESTPOS", "BESTGNSSPOS")
_VELOCITIES: Final = ("BESTVEL", "BESTGNSSVEL")
_COUNTS: Final = ("RAWIMU", "RAWIMUS", "RAWIMUX", "RAWIMUSX")
_SOLUTIONS: Final = ("INSPVA", "INSPVAS", "INSPVAX")
_HEADINGS: Final = ("HEADING", "HEADING2", "DUALANTENNAHEADING")
_CORRECTED: Final = ("CORRIMUDATA", "CORRIMUDATAS", "CORRIMUS", "IMURATECORRIMUS")
_KNOWN: Final = {"INSCONFIG", *_POSITIONS, *_VELOCITIES, *_COUNTS, *_SOLUTIONS, *_HEADINGS}
_SOLVED: Final = (
    "INS_HIGH_VARIANCE",
    "INS_SOLUTION_GOOD",
    "INS_SOLUTION_FREE",
    "INS_ALIGNMENT_COMPLETE",
)
"""States of the inertial solution in which it has one."""


@dataclass(frozen=True)
class Scale:
    """What one count is: increments [rad], [m/s]."""

    angle: float
    velocity: float


_FOOT: Final = 0.3048  # m
_HONEYWELL: Final = Scale(2.0**-33, 2.0**-27 * _FOOT)
_HG1700_FAST: Final = Scale(2.0**-33, 2.0**-26 * _FOOT)
_HG4930: Final = Scale(2.0**-33, 2.0**-29)
_STIM: Final = Scale(2.0**-21 * DEGREE, 2.0**-22)
_LITEF: Final = Scale(1e-9, 2e-8)
_KVH: Final = Scale(0.1 / (3600 * 256), 0.05 * 2.0**-15)


def _epson(rate: float, angular: float, force: float) -> Scale:
    """Counts of 2^-16 of a rate [deg/s] and of a force [mg], `rate` times a second."""
    unit = 2.0**-16 / rate
    return Scale(angular * unit * DEGREE, force * unit * 1e-3 * STANDARD_GRAVITY)


SCALES: Final = {
    (1, "HG1700_AG11"): _HONEYWELL,
    (4, "HG1700_AG17"): _HG1700_FAST,
    (5, "HG1900_CA29"): _HONEYWELL,
    (8, "LN200"): Scale(2.0**-19, 2.0**-14),
    (11, "HG1700_AG58"): _HONEYWELL,
    (12, "HG1700_AG62"): _HG1700_FAST,
    (13, "IMAR_FSAS"): Scale(0.1 * 2.0**-8 * ARCMIN / 60, 0.05 * 2.0**-15),
    (16, "KVH_COTS"): _KVH,
    (20, "HG1930_AA99"): _HONEYWELL,
    (26, "ISA100C"): _LITEF,
    (27, "HG1900_CA50"): _HONEYWELL,
    (28, "HG1930_CA50"): _HONEYWELL,
    (31, "ADIS16488"): Scale(720 * 2.0**-31 * DEGREE, 200 * 2.0**-31),
    (32, "STIM300"): _STIM,
    (33, "KVH_1750"): _KVH,
    (41, "EPSON_G320"): _epson(125, 0.008, 0.2),
    (52, "LITEF_MICROIMU"): _LITEF,
    (56, "STIM300D"): _STIM,
    (58, "HG4930_AN01"): _HG4930,
    (61, "EPSON_G370"): _epson(200, 0.0151515, 0.4),
    (62, "EPSON_G320_200HZ"): _epson(200, 0.008, 0.2),
    (68, "HG4930_AN04"): _HG4930,
    (69, "HG4930_AN04_400HZ"): _HG4930,
}
"""By the number of an IMU in RAWIMUX and its name in INSCONFIG."""


def recognises(path: Path) -> bool:
    """Whether the beginning of a file has a log."""
    return any(found[2].decode() in _KNOWN for found in _BEGIN.finditer(beginning(path)))


def read(path: Path) -> Contents:
    """IMU, fixes, headings and the unit's own solution of a file of logs.

    Raises
    ------
    InputError
        If a log is damaged, with its line (the last one of a file may be cut short); if the IMU is not told
        or its scale is not known; or if nothing is told.
    """
    logs = _Logs(path)
    lines = whole(path).split(b"\n")
    corrected = False
    for number, line in enumerate(lines, start=1):
        found = _BEGIN.search(line)
        name = found[2].decode() if found else ""
        corrected |= name in _CORRECTED
        if found is None or name not in _KNOWN:
            continue
        log = _LOG.fullmatch(line, found.start())
        if log is None and number == len(lines):
            break  # where the logger was switched off
        try:
            if log is None:
                raise ValueError("it does not end in a check sum")
            if _crc(line[log.start(1) : log.end(2)]) != int(log[3], 16):
                raise ValueError("its check sum does not fit")
            header, fields = (part.decode("ascii").split(",") for part in log.group(1, 2))
            logs.take(number, name, header[1:], fields)
        except (ValueError, IndexError) as error:  # InputError too
            raise InputError(f"{path}: line {number}: the log {name} is damaged: {error}") from None
    remark = f"{path}: CORRIMU logs are left out, gravity is taken out of them: log RAWIMUSXA"
    contents = logs.contents((remark,) if corrected else ())
    if not (contents.imu or contents.gnss or contents.heading_aid or contents.reference):
        raise InputError(
            remark if corrected else f"{path}: no log has an IMU, a fix, a heading or a solution"
        )
    return contents


def _crc(message: bytes) -> int:
    """NovAtel's CRC-32: that of zlib without its two inversions."""
    return zlib.crc32(message, 0xFFFFFFFF) ^ 0xFFFFFFFF


class _Logs:
    """What the logs have said so far."""

    def __init__(self, path: Path):
        self._path = path
        self._best, self._gnss = Fixes(), Fixes()
        self._headings, self._references = Headings(), References()
        self._week = 0
        """The first."""
        self._lines = array("q")
        self._times = array("d")
        self._counts = array("d")
        self._imus: set[int | str] = set()

    def take(self, line: int, name: str, header: Sequence[str], fields: Sequence[str]) -> None:
        """Take in one log; ValueError or IndexError if its fields are not those of its kind."""
        week, of_week = header[:2] if len(header) < 4 else header[4:6]
        if name == "INSCONFIG":
            self._imus.add(fields[0])
            return
        if int(week) == 0:
            return
        time = self._time(week, of_week)
        if name in _COUNTS:
            self._count(line, name, fields)
        elif name in _POSITIONS:
            self._position(name, time, fields)
        elif name in _VELOCITIES:
            self._velocity(name, time, fields)
        elif name in _HEADINGS and fields[0] == "SOL_COMPUTED":
            self._headings.heading(time, float(fields[3]) * DEGREE, float(fields[6]) * DEGREE)
        elif name in _SOLUTIONS:
            self._solution(name, time, fields)

    def _time(self, week: str, of_week: str) -> float:
        """Seconds since the beginning of the first week."""
        self._week = self._week or int(week)
        return (int(week) - self._week) * gps_time.WEEK + float(of_week)

    def _position(self, name: str, time: float, fields: Sequence[str]) -> None:
        if fields[0] != "SOL_COMPUTED" or fields[1].startswith("INS"):
            return
        latitude, longitude, height, undulation = map(float, fields[2:6])
        north, east, up = map(float, fields[7:10])
        fixes = self._fixes(name)
        fixes.position(time, latitude * DEGREE, longitude * DEGREE, height + undulation)
        fixes.position_sigma(time, east, north, up)

    def _velocity(self, name: str, time: float, fields: Sequence[str]) -> None:
        if fields[0] != "SOL_COMPUTED" or fields[1].startswith("INS"):
            return
        latency, _, speed, course, up = map(float, fields[2:7])
        angle = course * DEGREE
        self._fixes(name).velocity(time - latency, speed * math.sin(angle), speed * math.cos(angle), up)

    def _fixes(self, name: str) -> Fixes:
        return self._gnss if "GNSS" in name else self._best

    def _count(self, line: int, name: str, fields: Sequence[str]) -> None:
        if name.endswith("X"):
            self._imus.add(int(fields[1]))
            fields = fields[2:]
        week, of_week, _, *counts = fields[:9]
        up, back, right, turn_up, turn_back, turn_right = map(int, counts)
        self._lines.append(line)
        self._times.append(self._time(week, of_week))
        self._counts.extend((turn_right, -turn_back, turn_up, right, -back, up))

    def _solution(self, name: str, time: float, fields: Sequence[str]) -> None:
        if name == "INSPVAX":
            status, place = fields[0], list(map(float, fields[2:12]))
            place = [place[0], place[1], place[2] + place[3], *place[4:]]
        else:
            status, place = fields[11], list(map(float, fields[2:11]))
            time = self._time(fields[0], fields[1])
        if status not in _SOLVED:
            return
        latitude, longitude, height, north, east, up, roll, pitch, azimuth = place
        self._references.position(time, latitude * DEGREE, longitude * DEGREE, height)
        self._references.velocity(time, east, north, up)
        self._references.attitude(time, roll * DEGREE, pitch * DEGREE, azimuth * DEGREE)

    def contents(self, remarks: tuple[str, ...]) -> Contents:
        """Everything in SI."""
        return Contents(
            Clock.GPS,
            self._week * gps_time.WEEK,
            imu=self._inertial() if self._counts else None,
            gnss=self._gnss.table() or self._best.table(),
            heading_aid=self._headings.table(),
            reference=self._references.table(),
            place=self._place,
            remarks=remarks,
        )

    def _place(self, table: str, row: int) -> str:
        return f"line {self._lines[row]}" if table == "imu" else f"row {row + 1} of its {table} table"

    def _inertial(self) -> Inertial:
        counts, scale = np.array(self._counts).reshape(-1, 6), self._scale()
        time = np.array(self._times)
        return Inertial(time, counts[:, 0:3] * scale.angle, counts[:, 3:6] * scale.velocity, increments=True)

    def _scale(self) -> Scale:
        if not self._imus:
            raise InputError(
                f"{self._path}: RAWIMU does not say which IMU it is: log INSCONFIGA too, or RAWIMUSXA"
            )
        scales = {imu: [s for known, s in SCALES.items() if imu in known] for imu in self._imus}
        for imu, found in scales.items():
            if not found:
                raise InputError(f"{self._path}: the IMU {imu} has no scale that is documented here")
        if len({scale for found in scales.values() for scale in found}) > 1:
            names = ", ".join(sorted(map(str, scales)))
            raise InputError(f"{self._path}: IMUs {names} stand in one file: must be one")
        return next(iter(scales.values()))[0]
