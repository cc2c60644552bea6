"""PX4 flight logs (ULog), with the package pyulog.

    sensor_combined, vehicle_imu                 IMU, forward, right, down: whichever has more samples, the
                                                 first as rates [rad/s], [m/s2], the second as increments
    vehicle_gps_position, sensor_gps             fixes; heading of two antennas where the receiver has it
    vehicle_attitude, vehicle_global_position,   the autopilot's own solution: reference, a row for each stamp
    vehicle_local_position                       of any of them, with what was said then

A log often holds vehicle_imu twice a second only, each sample covering a few milliseconds. Heights are above
the ellipsoid; a global position with that above mean sea level alone has none. eph, one number, is given to
east and to north. Fields are taken by their old and their new names. Stamps are those of the
autopilot, seconds since its start (Clock.OWN); of a fix it is the time at which it was received, unless the
log says when it was valid.

Source: PX4 user guide, "ULog File Format"; comments of the messages in PX4-Autopilot/msg.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Axes, Contents, Inertial
from sim_scenarios.recordings.readers.epochs import References
from sim_scenarios.recordings.readers.extras import needed
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.recordings.tables import Array, FixTable, HeadingTable, doubles
from sim_scenarios.units import DEGREE

_MAGIC: Final = b"ULog\x01\x12\x35"
_MICROSECONDS: Final = 1e6  # in a second
_FIXES: Final = ("vehicle_gps_position", "sensor_gps")
_TOPICS: Final = (
    "sensor_combined",
    "vehicle_imu",
    *_FIXES,
    "vehicle_attitude",
    "vehicle_global_position",
    "vehicle_local_position",
)
_SPATIAL: Final = 3
"""Fix types from here on are three-dimensional."""

_ROUNDS: Final = 20
"""A log is read once, and what is damaged in it a few times more, in search of the next message."""

Topic = dict[str, Any]
"""Columns of a topic by their names."""


class _Log(BytesIO):
    """What is in a log. The package turns back in some damaged ones for ever: here that has an end."""

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self._left = _ROUNDS * (len(content) + 1)

    def read(self, size: int | None = -1, /) -> bytes:
        """Bytes from here on.

        Raises
        ------
        RuntimeError
            If so many were read that it is no longer going on.
        """
        part = super().read(size)
        self._left -= len(part) + 1
        if self._left < 0:
            raise RuntimeError("its messages do not end")
        return part


def recognises(path: Path) -> bool:
    """Whether a file begins like a ULog."""
    return beginning(path).startswith(_MAGIC)


def read(path: Path) -> Contents:
    """IMU, fixes, heading and the autopilot's own solution of a log.

    Raises
    ------
    InputError
        If the log is found damaged (the format has no check sums), or has none of the topics. A log that was
        cut short is read as far as it goes.
    """
    ulog = needed("pyulog", "pyulog", "reading ULog").ULog
    content = whole(path)
    try:
        with redirect_stdout(StringIO()):  # it prints what it finds damaged
            log = ulog(_Log(content), message_name_filter_list=list(_TOPICS), disable_str_exceptions=True)
        topics = {data.name: _quiet(data.data) for data in log.data_list if data.multi_id == 0}
    except Exception as error:  # of damaged bytes the package makes whatever they say
        raise InputError(f"{path}: cannot be read as a ULog: {type(error).__name__}: {error}") from None
    if log.file_corruption:
        raise InputError(f"{path}: is damaged: some of its bytes are no messages of a ULog")
    try:
        imu = _inertial(topics)
        received = [topics[name] for name in _FIXES if name in topics]
        gnss, heading = (_fixes(received[0]), _headings(received[0])) if received else (None, None)
        reference = _solution(topics).table()
    except KeyError as missing:
        raise InputError(f"{path}: a topic lacks the field {missing}") from None
    if imu is None and gnss is None and heading is None and reference is None:
        raise InputError(f"{path}: has no IMU, fix or solution: none of the topics {', '.join(_TOPICS)}")
    return Contents(imu=imu, gnss=gnss, heading_aid=heading, reference=reference)


def _inertial(topics: dict[str, Topic]) -> Inertial | None:
    rates, increments = topics.get("sensor_combined"), topics.get("vehicle_imu")
    if increments is not None and (rates is None or len(increments["timestamp"]) > len(rates["timestamp"])):
        time = _time(increments)
        angle, velocity = _three(increments, "delta_angle"), _three(increments, "delta_velocity")
        return Inertial(time, angle, velocity, True, Axes.FORWARD_RIGHT_DOWN)
    if rates is None:
        return None
    turn, force = _three(rates, "gyro_rad"), _three(rates, "accelerometer_m_s2")
    return Inertial(_time(rates), turn, force, False, Axes.FORWARD_RIGHT_DOWN)


def _fixes(received: Topic) -> FixTable | None:
    kept = received["fix_type"] >= _SPATIAL
    if not kept.any():
        return None
    if "latitude_deg" in received:
        latitude, longitude = received["latitude_deg"], received["longitude_deg"]
        height = received["altitude_ellipsoid_m"]
    else:
        latitude, longitude = received["lat"] / 1e7, received["lon"] / 1e7
        height = received["alt_ellipsoid"] / 1e3
    position = np.column_stack((latitude * DEGREE, longitude * DEGREE, height))
    velocity = np.column_stack((received["vel_e_m_s"], received["vel_n_m_s"], -received["vel_d_m_s"]))
    velocity = np.where(received["vel_ned_valid"][:, np.newaxis] > 0, velocity, np.nan)
    sigma = np.column_stack((received["eph"], received["eph"], received["epv"]))
    speed_sigma = np.column_stack([received["s_variance_m_s"]] * 3)  # [m/s], whatever the field is called
    time, first = np.unique(_time(received)[kept], return_index=True)
    tables = (table[kept][first] for table in (position, velocity, sigma, speed_sigma))
    return FixTable(time, *tables)


def _headings(received: Topic) -> HeadingTable | None:
    heading = received.get("heading")
    if heading is None or not (kept := np.isfinite(heading)).any():
        return None
    accuracy = received.get("heading_accuracy", np.zeros(len(heading)))
    sigma = np.where(np.isfinite(accuracy), accuracy, 0.0)
    time, first = np.unique(_time(received)[kept], return_index=True)
    return HeadingTable(time, heading[kept][first] % math.tau, sigma[kept][first])


def _solution(topics: dict[str, Topic]) -> References:
    said = References()
    if (attitude := topics.get("vehicle_attitude")) is not None:
        w, x, y, z = (attitude[f"q[{i}]"] for i in range(4))
        valid = w**2 + x**2 + y**2 + z**2 > 0
        turns = Rotation.from_quat(np.column_stack((x, y, z, w))[valid])
        yaw, pitch, roll = turns.as_euler("ZYX").T
        _say(said.attitude, _time(attitude)[valid], (roll, pitch, yaw % math.tau))
    if (place := topics.get("vehicle_global_position")) is not None:
        height = place.get("alt_ellipsoid", np.full(len(place["timestamp"]), np.nan))
        _say(said.position, _time(place), (place["lat"] * DEGREE, place["lon"] * DEGREE, height))
    if (local := topics.get("vehicle_local_position")) is not None:
        known = (local["v_xy_valid"] > 0) & (local["v_z_valid"] > 0)
        columns = (local["vy"][known], local["vx"][known], -local["vz"][known])
        _say(said.velocity, _time(local)[known], columns)
    return said


def _say(say: Callable[..., None], time: Array, columns: Iterable[Array]) -> None:
    for stamp, *values in zip(time.tolist(), *(column.tolist() for column in columns), strict=True):
        say(stamp, *values)


def _time(topic: Topic) -> Array:
    """When the samples were taken [s]; in old logs, and where it is not told, when they were published."""
    published: NDArray[np.uint64] = topic["timestamp"]
    taken: NDArray[np.uint64] = topic.get("timestamp_sample", published)
    time: Array = np.where(taken > 0, taken, published) / _MICROSECONDS
    return time


def _three(topic: Topic, name: str) -> Array:
    return np.column_stack([topic[f"{name}[{i}]"] for i in range(3)])


def _quiet(topic: Topic) -> Topic:
    return {name: doubles(column) if column.dtype.kind == "f" else column for name, column in topic.items()}
