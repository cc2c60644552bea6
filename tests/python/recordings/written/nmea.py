"""NMEA sentences, by the standard."""

from __future__ import annotations

from functools import reduce
from pathlib import Path


def sentence(body: str) -> str:
    """With its check sum."""
    return f"${body}*{reduce(lambda a, b: a ^ b, body.encode()):02X}"


def angle(degrees: float, width: int) -> str:
    """[d]ddmm.mmmmmmm."""
    whole = int(abs(degrees))
    return f"{whole:0{width}d}{(abs(degrees) - whole) * 60:010.7f}"


def place(latitude: float, longitude: float) -> str:
    """Of degrees."""
    south, west = "S" if latitude < 0 else "N", "W" if longitude < 0 else "E"
    return f"{angle(latitude, 2)},{south},{angle(longitude, 3)},{west}"


def gga(time: str, latitude: float, longitude: float, altitude: str = "12.345", geoid: str = "-30.5") -> str:
    """Position [deg, m]."""
    return sentence(f"GPGGA,{time},{place(latitude, longitude)},4,12,0.7,{altitude},M,{geoid},M,1.0,0001")


def rmc(time: str, date: str, speed: str = "10.000", course: str = "210.00", status: str = "A") -> str:
    """Speed [knot] and course [deg], at a place of no account."""
    return sentence(f"GPRMC,{time},{status},{place(-33.5, 151.25)},{speed},{course},{date},,,A")


def written(path: Path, *sentences: str) -> Path:
    """A file of sentences."""
    path.write_bytes("".join(f"{line}\r\n" for line in sentences).encode())
    return path
