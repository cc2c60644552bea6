"""NovAtel logs, by the manual."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

WEEK = 2209
SECONDS = 491674.0
UNDULATION = -16.25  # m


def crc(message: str) -> int:
    """CRC-32 bit by bit, as the manual has it."""
    value = 0
    for byte in message.encode():
        rest = (value ^ byte) & 0xFF
        for _ in range(8):
            rest = rest >> 1 ^ (0xEDB88320 if rest & 1 else 0)
        value = (value >> 8) & 0x00FFFFFF ^ rest
    return value


def log(name: str, fields: str, seconds: float = SECONDS, week: int = WEEK) -> str:
    """A log with the long header."""
    message = f"{name}A,COM1,0,65.0,FINESTEERING,{week},{seconds:.3f},02000020,e5fc,16809;{fields}"
    return f"#{message}*{crc(message):08x}"


def short(name: str, fields: str, seconds: float = SECONDS) -> str:
    """A log with the short header."""
    message = f"{name}A,{WEEK},{seconds:.3f};{fields}"
    return f"%{message}*{crc(message):08x}"


def raw_imu(imu: int, counts: Sequence[int], seconds: float = SECONDS) -> str:
    """Order of the manual: Z, -Y, X of the accelerometers, then of the gyros."""
    x, y, z, turn_x, turn_y, turn_z = counts
    fields = f"00,{imu},{WEEK},{seconds:.9f},00000077,{z},{-y},{x},{turn_z},{-turn_y},{turn_x}"
    return short("RAWIMUSX", fields, seconds)


def best_position(
    kind: str = "NARROW_INT",
    status: str = "SOL_COMPUTED",
    name: str = "BESTPOS",
    place: tuple[float, float, float] = (51.5, -114.25, 1063.5),
    seconds: float = SECONDS,
) -> str:
    """Latitude, longitude [deg], and height above the geoid [m], which is 16.25 m below the ellipsoid."""
    latitude, longitude, height = place
    fields = (
        f"{status},{kind},{latitude:.11f},{longitude:.11f},{height:.4f},{UNDULATION:.4f},WGS84,0.02,0.01,0.03"
        ',"AAAA",1.0,0.0,8,8,8,8,0,01,0,03'
    )
    return log(name, fields, seconds)


def best_velocity(
    latency: float = 0.0,
    kind: str = "DOPPLER_VELOCITY",
    name: str = "BESTVEL",
    motion: tuple[float, float, float] = (10.0, 210.0, 0.25),
    seconds: float = SECONDS,
) -> str:
    """Speed over ground [m/s], course [deg], speed upwards [m/s]."""
    speed, course, up = motion
    return log(
        name, f"SOL_COMPUTED,{kind},{latency:.3f},0.000,{speed:.4f},{course:.6f},{up:.4f},0.0", seconds
    )


def written(path: Path, *logs: str) -> Path:
    """A file of logs."""
    path.write_bytes("".join(f"{line}\r\n" for line in logs).encode())
    return path
