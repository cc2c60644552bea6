"""u-blox UBX, with the package pyubx2.

    NAV-PVT         position, velocity, their accuracies
    NAV-HPPOSLLH    the position to 0.1 mm and its accuracy, in the place of that of a spatial fix of NAV-PVT
    NAV-RELPOSNED   direction from the first to the second antenna, where both move (from a base that stands
                    it is no heading): heading

NMEA, RTCM and other messages in between are passed over. The horizontal accuracy, one number, is given to
east and to north, the speed accuracy to each component. A two-dimensional fix has no height, and dead
reckoning alone (fix type 1) is no fix. Heights are above the ellipsoid.

Clock.GPS: the time of the week is that of the navigation epoch, to the nanosecond where NAV-PVT has resolved
its UTC; the week is that of its date. In a file without a date, seconds of a week (Clock.OWN).

ESF-RAW and ESF-MEAS are not read: their tags count a clock of the sensor's own that no message ties to the
time of the week closer than the delay of the line.

Source: u-blox F9 HPG 1.32 interface description, UBX-22008968, ch. 3.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from itertools import accumulate
from pathlib import Path
from typing import Any, Final

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import gps_time
from sim_scenarios.recordings.readers.contents import Clock, Contents
from sim_scenarios.recordings.readers.epochs import NOT_MEASURED, Fixes, Headings
from sim_scenarios.recordings.readers.extras import needed
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.units import DEGREE

_SYNC: Final = b"\xb5b"
_MESSAGES: Final = {
    b"\x01\x07": ("NAV-PVT", (92,)),
    b"\x01\x14": ("NAV-HPPOSLLH", (36,)),
    b"\x01\x3c": ("NAV-RELPOSNED", (40, 64)),
}
"""Name and payload lengths by class and number."""
_SENSORS: Final = (b"\x10\x02", b"\x10\x03")
"""ESF-MEAS, ESF-RAW"""
_BESIDES: Final = 8
"""Bytes of a frame besides its payload."""
_FLAT: Final = 2
_SPATIAL: Final = (3, 4)
"""Spatial fix types of which the satellites are a part: alone, with dead reckoning."""
_MM: Final = 1e3  # in a metre


def recognises(path: Path) -> bool:
    """Whether a file begins with a whole frame, or has one of the three messages near its beginning."""
    frames = _frames(beginning(path))
    return any(fits and (offset == 0 or frame[2:4] in _MESSAGES) for offset, frame, fits in frames)


def read(path: Path) -> Contents:
    """Fixes and headings of a log.

    Raises
    ------
    InputError
        If one of the three messages is damaged, with its offset (the last one of a file may be cut short), or
        if no message has a fix or a heading.
    """
    reader = needed("pyubx2", "pyubx2", "reading UBX").UBXReader
    said = _Said()
    sensors = False
    for offset, frame, fits in _frames(whole(path)):
        name, lengths = _MESSAGES.get(frame[2:4], ("", ()))
        sensors |= fits and frame[2:4] in _SENSORS
        if not name:
            continue
        length = int.from_bytes(frame[4:6], "little")
        if length in lengths and len(frame) < length + _BESIDES:
            break  # where the logger was switched off
        try:
            if not fits:
                raise ValueError("its check sum does not fit")
            if length not in lengths:
                raise ValueError(f"it has {length} bytes")
            said.hear(name, reader.parse(frame))
        except ValueError as error:
            raise InputError(f"{path}: byte {offset}: the message {name} is damaged: {error}") from None
    remark = f"{path}: ESF-RAW and ESF-MEAS are left out: their clock is not that of the fixes"
    contents = said.contents((remark,) if sensors else ())
    if contents.gnss is None and contents.heading_aid is None:
        raise InputError(
            f"{path}: no NAV-PVT has a fix and no NAV-RELPOSNED a heading"
            f"{'; ESF-RAW and ESF-MEAS are not read' if sensors else ''}"
        )
    return contents


def _frames(content: bytes) -> Iterator[tuple[int, bytes, bool]]:
    """What begins like a frame, its offset, and whether it is one; nothing from within one that is."""
    offset = content.find(_SYNC)
    while offset >= 0:
        length = int.from_bytes(content[offset + 4 : offset + 6], "little")
        frame = content[offset : offset + length + _BESIDES]
        fits = _fits(frame)
        yield offset, frame, fits
        offset = content.find(_SYNC, offset + (len(frame) if fits else len(_SYNC)))


def _fits(frame: bytes) -> bool:
    """Whether a frame is whole and its check sum (RFC 1145's, Fletcher) fits."""
    if len(frame) < _BESIDES or len(frame) != int.from_bytes(frame[4:6], "little") + _BESIDES:
        return False
    body = frame[2:-2]
    return frame[-2:] == bytes((sum(body) & 0xFF, sum(accumulate(body)) & 0xFF))


class _Said:
    """What the messages have said so far, by seconds of the week of the first of them."""

    def __init__(self) -> None:
        self._now: float | None = None
        self._week: int | None = None
        self._exact: dict[float, float] = {}
        """Time of an epoch to the nanosecond, by that to the millisecond."""
        self._messages: list[tuple[str, float, Any]] = []

    def hear(self, name: str, message: Any) -> None:
        """Take in one message."""
        of_week = message.iTOW / 1e3
        weeks = 0 if self._now is None else self._now // gps_time.WEEK
        if self._now is not None and of_week < self._now % gps_time.WEEK - gps_time.WEEK / 2:
            weeks += 1
        self._now = weeks * gps_time.WEEK + of_week
        self._messages.append((name, self._now, message))
        if name == "NAV-PVT" and message.validDate and message.validTime:
            date = datetime(
                message.year, message.month, message.day, message.hour, message.min, min(message.second, 59)
            )
            self._week = self._week or gps_time.week_at(date, of_week) - int(weeks)
            if message.fullyResolved:  # UTC and GPS time differ by whole seconds
                part = message.nano / 1e9
                self._exact[self._now] = round(self._now - part) + part

    def contents(self, remarks: tuple[str, ...]) -> Contents:
        """Everything in SI; a precise position comes after the others and takes their place."""
        fixes, headings = Fixes(), Headings()
        spatial = {now for name, now, message in self._messages if name == "NAV-PVT" and _spatial(message)}
        for name, now, message in sorted(self._messages, key=lambda heard: heard[0] == "NAV-HPPOSLLH"):
            time = self._exact.get(now, now)
            if name == "NAV-PVT":
                _position_and_velocity(fixes, time, message)
            elif name == "NAV-HPPOSLLH" and now in spatial and not message.invalidLlh:
                _position(fixes, time, message, message.height / _MM)
            elif name == "NAV-RELPOSNED" and _is_heading(message):
                headings.heading(time, message.relPosHeading * DEGREE, message.accHeading * DEGREE)
        clock = Clock.OWN if self._week is None else Clock.GPS
        epoch = (self._week or 0) * gps_time.WEEK
        return Contents(clock, epoch, gnss=fixes.table(), heading_aid=headings.table(), remarks=remarks)


def _is_heading(message: Any) -> bool:
    """Whether a relative position tells the heading of what carries both antennas."""
    return bool(message.version == 1 and message.relPosHeadingValid and message.isMoving)


def _spatial(message: Any) -> bool:
    return bool(message.gnssFixOk and message.fixType in _SPATIAL)


def _position_and_velocity(fixes: Fixes, time: float, message: Any) -> None:
    flat = bool(message.gnssFixOk and message.fixType == _FLAT)
    if not flat and not _spatial(message):
        return
    _position(fixes, time, message, NOT_MEASURED if flat else message.height / _MM)
    fixes.velocity(time, message.velE / _MM, message.velN / _MM, -message.velD / _MM)
    fixes.velocity_sigma(time, *[message.sAcc / _MM] * 3)


def _position(fixes: Fixes, time: float, message: Any, height: float) -> None:
    fixes.position(time, message.lat * DEGREE, message.lon * DEGREE, height)
    fixes.position_sigma(time, message.hAcc / _MM, message.hAcc / _MM, message.vAcc / _MM)
