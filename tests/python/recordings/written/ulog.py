"""PX4 logs, by the format's description."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

TYPES = {
    "uint64_t": "Q",
    "float": "f",
    "double": "d",
    "int32_t": "i",
    "uint32_t": "I",
    "uint8_t": "B",
    "bool": "?",
}
IMU = (
    "float[3] gyro_rad;uint32_t gyro_integral_dt;"
    "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt"
)
INCREMENTS = "uint64_t timestamp_sample;float[3] delta_angle;float[3] delta_velocity;uint32_t delta_angle_dt"
MOTION = (
    "float eph;float epv;float s_variance_m_s;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;float heading"
)
FLAGS = "uint8_t fix_type;bool vel_ned_valid"
NEW_FIX = (
    "uint64_t timestamp_sample;double latitude_deg;double longitude_deg;double altitude_msl_m;"
    f"double altitude_ellipsoid_m;{MOTION};float heading_accuracy;{FLAGS}"
)
Rows = list[tuple[int, Sequence[float]]]
"""Stamps [us] and values."""


def message(kind: str, payload: bytes) -> bytes:
    """A message of a kind."""
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def packing(fields: str) -> str:
    """How the values of a topic are packed, behind its stamp."""
    codes = ""
    for field in fields.split(";"):
        kind, _, count = field.split()[0].partition("[")
        codes += (count.rstrip("]") or "1") + TYPES[kind]
    return f"<Q{codes}"


def written(path: Path, topics: dict[str, tuple[str, Rows]]) -> Path:
    """A log: header, flags, formats, subscriptions, data in the order of their stamps."""
    content = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + message("B", bytes(40))
    for name, (fields, _) in topics.items():
        content += message("F", f"{name}:uint64_t timestamp;{fields};".encode())
    data = []
    for number, (name, (fields, rows)) in enumerate(topics.items()):
        content += message("A", struct.pack("<BH", 0, number) + name.encode())
        for stamp, values in rows:
            data.append(
                (
                    stamp,
                    message("D", struct.pack("<H", number) + struct.pack(packing(fields), stamp, *values)),
                )
            )
    path.write_bytes(content + b"".join(part for _, part in sorted(data, key=lambda item: item[0])))
    return path
