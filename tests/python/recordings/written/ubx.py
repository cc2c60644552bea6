"""u-blox messages, by the interface description."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from datetime import datetime, timedelta
from pathlib import Path

LEAP_SECONDS = 18
WEEK = 2350
GPS_EPOCH = datetime(1980, 1, 6)
PLACE = {"lat": -335123456, "lon": 1512543210, "height": -18155}
"""[1e-7 deg, mm]"""
PRECISELY = {"lat": -41, "lon": 37, "height": 6}
"""What a precise position has beyond it [1e-9 deg, 0.1 mm]."""
MOTION = {"north": -8660, "east": 5000, "down": -250}
"""[mm/s]"""


def frame(number: int, payload: bytes, kind: int = 1) -> bytes:
    """A message with its check sums."""
    body = bytes((kind, number)) + struct.pack("<H", len(payload)) + payload
    first = second = 0
    for byte in body:
        first = (first + byte) % 256
        second = (second + first) % 256
    return b"\xb5b" + body + bytes((first, second))


def pvt(
    tow: int,
    week: int = WEEK,
    nano: int = 0,
    valid: int = 7,
    fix: int = 3,
    flags: int = 1,
    second: int | None = None,
    at: Mapping[str, int] = PLACE,
    moving: Mapping[str, int] = MOTION,
) -> bytes:
    """NAV-PVT of a time of the week [ms] with the UTC that goes with it."""
    utc = GPS_EPOCH + timedelta(weeks=week, milliseconds=tow, seconds=-LEAP_SECONDS)
    utc += timedelta(milliseconds=500)
    date = (utc.year, utc.month, utc.day, utc.hour, utc.minute, utc.second if second is None else second)
    place, motion = (at["lon"], at["lat"], at["height"], 12345), tuple(moving.values())
    payload = struct.pack("<IH5BBIiBBBB", tow, *date, valid, 20, nano, fix, flags, 0, 12)
    payload += struct.pack("<4iII", *place, 14, 23)
    payload += struct.pack("<3iiiIIHH4siHH", *motion, 10000, 0, 45, 0, 120, 0, b"", 0, 0, 0)
    assert len(payload) == 92
    return frame(0x07, payload)


def precise(
    tow: int, invalid: int = 0, at: Mapping[str, int] = PLACE, beyond: Mapping[str, int] = PRECISELY
) -> bytes:
    """NAV-HPPOSLLH: 1e-9 deg and 0.1 mm more."""
    place = (at["lon"], at["lat"], at["height"], 12345)
    more = (beyond["lon"], beyond["lat"], beyond["height"], 0)
    payload = struct.pack("<BHBI4i4bII", 0, 0, invalid, tow, *place, *more, 121, 199)
    return frame(0x14, payload)


def written(path: Path, *frames: bytes) -> Path:
    """A file of messages."""
    path.write_bytes(b"".join(frames))
    return path
