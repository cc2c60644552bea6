"""NMEA 0183: sentences of GNSS receivers and compasses.

    GGA   position, height (above mean sea level, plus geoid separation)
    RMC   date, speed and course over ground; position where there is no GGA
    VTG   speed and course over ground
    GST   standard deviations of the position
    ZDA   date
    HDT, THS   heading

Sentences of any talker; all others are passed over, and so is what stands in a line before the `$`. Stamps
are UTC (Clock.UNIX), with the date of the RMC or ZDA; in a file without a date they are seconds since the
midnight before its first sentence (Clock.OWN). VTG, HDT and THS have no time: they belong to the time that
was said last before them, so of several headings in between the last one counts. Courses give velocities east
and north; the vertical one is not measured. A position by dead reckoning or by hand (GGA quality 6, 7) is no
fix.

Source: NMEA 0183 version 4.11; u-blox F9 HPG 1.32 interface description, UBX-22008968, ch. 2.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from datetime import date
from functools import reduce
from operator import xor
from pathlib import Path
from typing import Final

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Clock, Contents
from sim_scenarios.recordings.readers.epochs import NOT_MEASURED, Fixes, Headings
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.recordings.readers.gps_time import DAY
from sim_scenarios.recordings.units import VELOCITY
from sim_scenarios.units import DEGREE

_SENTENCE: Final = re.compile(rb"\$[A-OQ-Z][A-Z](GGA|RMC|VTG|GST|ZDA|HDT|THS),[^\r\n$]*")
_WHOLE: Final = re.compile(rb"\$([^*]*)\*([0-9A-Fa-f]{2})\s*")
_TIMED: Final = ("GGA", "RMC", "GST", "ZDA")
_TIME: Final = re.compile(r"(\d\d)(\d\d)(\d\d(?:\.\d*)?)")
_NO_FIX: Final = ("", "0", "6", "7")
"""Qualities of a GGA: none, estimated, manual."""
_UNIX: Final = date(1970, 1, 1)
_CENTURY: Final = 80
"""Years of two digits from here on are of the last century."""


def recognises(path: Path) -> bool:
    """Whether the beginning of a file has a sentence."""
    return _SENTENCE.search(beginning(path)) is not None


def read(path: Path) -> Contents:
    """Fixes and headings of a log.

    Raises
    ------
    InputError
        If a sentence is damaged, with its line (the last one of a file may be cut short), or if no sentence
        has a fix or a heading.
    """
    said = _Said()
    lines = whole(path).split(b"\n")
    for number, line in enumerate(lines, start=1):
        found = _SENTENCE.search(line)
        if found is None:
            continue
        sentence = _WHOLE.fullmatch(found[0])
        if sentence is None and number == len(lines):
            break  # where the logger was switched off
        try:
            if sentence is None:
                raise ValueError("it does not end in a check sum")
            if reduce(xor, sentence[1]) != int(sentence[2], 16):
                raise ValueError("its check sum does not fit")
            said.hear(found[1].decode(), sentence[1].decode("ascii").split(",")[1:])
        except (ValueError, IndexError) as error:
            text = found[0].decode("ascii", "replace").strip()
            raise InputError(f"{path}: line {number}: '{text[:60]}' is damaged: {error}") from None
    contents = said.contents()
    if contents.gnss is None and contents.heading_aid is None:
        raise InputError(f"{path}: no sentence has a fix or a heading")
    return contents


class _Said:
    """What the sentences have said so far."""

    def __init__(self) -> None:
        self._now: float | None = None
        """Seconds since the midnight before the first sentence."""
        self._midnight: float | None = None
        """That midnight, seconds since 1970."""
        self._events: list[tuple[str, float, tuple[float, ...]]] = []

    def hear(self, kind: str, fields: Sequence[str]) -> None:
        """Take in one sentence; ValueError or IndexError if its fields are not those of its kind."""
        if kind in _TIMED and fields[0]:
            self._tell_time(_of_day(fields[0]), _date(kind, fields))
        if self._now is not None:
            self._events += [(name, self._now, values) for name, values in _quantities(kind, fields)]

    def _tell_time(self, clock: float, day: date | None) -> None:
        days, before = divmod(self._now or 0.0, DAY)
        if self._now is not None:
            days += 1 if clock < before - DAY / 2 else -1 if clock > before + DAY / 2 else 0
        if day is not None:
            midnight = (day - _UNIX).days * DAY
            if self._midnight is None:
                self._midnight = midnight - days * DAY
            days = (midnight - self._midnight) / DAY
        self._now = days * DAY + clock

    def contents(self) -> Contents:
        """Everything on one clock, from that midnight on."""
        fixes, headings = Fixes(), Headings()
        full = any(name == "position" for name, _, _ in self._events)
        for name, when, values in self._events:
            if name == "heading":
                headings.heading(when, *values)
            elif name == "position" or (name == "flat position" and not full):
                fixes.position(when, *values)
            elif name == "velocity":
                fixes.velocity(when, *values)
            elif name == "sigma":
                fixes.position_sigma(when, *values)
        clock = Clock.OWN if self._midnight is None else Clock.UNIX
        return Contents(clock, self._midnight or 0.0, gnss=fixes.table(), heading_aid=headings.table())


def _of_day(field: str) -> float:
    """Seconds since midnight of hhmmss.ss."""
    parts = _TIME.fullmatch(field)
    if parts is None:
        raise ValueError(f"'{field}' is no time of day")
    return int(parts[1]) * 3600 + int(parts[2]) * 60 + float(parts[3])


def _date(kind: str, fields: Sequence[str]) -> date | None:
    if kind == "RMC" and fields[8]:
        day, month, year = (int(fields[8][i : i + 2]) for i in (0, 2, 4))
        return date(year + (1900 if year >= _CENTURY else 2000), month, day)
    if kind == "ZDA" and all(fields[1:4]):
        return date(int(fields[3]), int(fields[2]), int(fields[1]))
    return None


def _quantities(kind: str, fields: Sequence[str]) -> Iterator[tuple[str, tuple[float, ...]]]:
    """What a sentence measures, in SI; empty fields measure nothing."""
    if kind == "GGA" and fields[5] not in _NO_FIX and all(fields[1:5]):
        known = fields[8] and fields[10]
        height = float(fields[8]) + float(fields[10]) if known else NOT_MEASURED
        yield "position", (*_place(fields[1:5]), height)
    elif kind == "RMC" and fields[1] == "A":
        if all(fields[6:8]):
            yield "velocity", _velocity(fields[6], VELOCITY["knot"], fields[7])
        if all(fields[2:6]):
            yield "flat position", (*_place(fields[2:6]), NOT_MEASURED)
    elif kind == "VTG" and fields[0] and fields[6]:
        yield "velocity", _velocity(fields[6], VELOCITY["km/h"], fields[0])
    elif kind == "GST" and all(fields[5:8]):
        north, east, up = map(float, fields[5:8])
        yield "sigma", (east, north, up)
    elif (kind == "HDT" and fields[0]) or (kind == "THS" and fields[0] and fields[1] == "A"):
        yield "heading", (float(fields[0]) * DEGREE,)


def _place(fields: Sequence[str]) -> tuple[float, float]:
    """Latitude and longitude [rad] of ddmm.mm, N or S, dddmm.mm, E or W."""
    latitude, north, longitude, east = fields
    return _angle(latitude, north, "NS"), _angle(longitude, east, "EW")


def _angle(field: str, side: str, sides: str) -> float:
    if side not in sides:
        raise ValueError(f"'{side}' is neither {sides[0]} nor {sides[1]}")
    degrees, minutes = divmod(float(field), 100)
    return (degrees + minutes / 60) * DEGREE * (1 if side == sides[0] else -1)


def _velocity(speed: str, unit: float, course: str) -> tuple[float, float]:
    angle = float(course) * DEGREE
    return float(speed) * unit * math.sin(angle), float(speed) * unit * math.cos(angle)
