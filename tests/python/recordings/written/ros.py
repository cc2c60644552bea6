"""ROS bags, by the package that reads them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

START = 1_625_094_982
"""From which seconds count [s since 1970]."""
STORES = {version: get_typestore(version) for version in (Stores.ROS1_NOETIC, Stores.ROS2_HUMBLE)}
Messages = Iterable[tuple[str, str, dict[str, Any]]]
"""Topics, types, and what differs from nothing."""
IMU, FIX, ODOMETRY = "sensor_msgs/msg/Imu", "sensor_msgs/msg/NavSatFix", "nav_msgs/msg/Odometry"
TWIST, UNCERTAIN = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/TwistWithCovarianceStamped"


def header(seconds: float, frame: str, start: int = START) -> dict[str, Any]:
    """Of so many seconds after the start."""
    second, nanosecond = divmod(round(seconds * 1e9), 10**9)
    return {"stamp": {"sec": start + second, "nanosec": nanosecond}, "frame_id": frame}


def vector(values: Iterable[float]) -> dict[str, float]:
    """Values by the names of a Vector3."""
    return dict(zip("xyz", values, strict=True))


def inertial(
    seconds: float, turn: Iterable[float], force: Iterable[float], frame: str = "imu_link", start: int = START
) -> dict[str, Any]:
    """Rates [rad/s] and specific forces [m/s2]: forward, left, up."""
    measured = {"angular_velocity": vector(turn), "linear_acceleration": vector(force)}
    return {"header": header(seconds, frame, start), **measured}


def fix(
    seconds: float,
    covariance_type: int = 2,
    status: int = 0,
    place: Iterable[float] = (51.5, -114.25, 1047.25),
) -> dict[str, Any]:
    """Latitude, longitude [deg], height [m]."""
    covariance = np.diag([0.04, 0.09, 0.16]).ravel()
    told = {"position_covariance": covariance, "position_covariance_type": covariance_type}
    where = dict(zip(("latitude", "longitude", "altitude"), place, strict=True))
    return {"header": header(seconds, "gps"), "status": {"status": status}, **where, **told}


def uncertain_twist(
    seconds: float,
    frame: str,
    variances: tuple[float, float, float] = (0.25, 1.0, 4.0),
    velocity: Iterable[float] = (1.0, 2.0, 3.0),
) -> dict[str, Any]:
    """Velocity [m/s]."""
    covariance = np.diag([*variances, 9.0, 9.0, 9.0]).ravel()
    told = {"twist": {"linear": vector(velocity)}, "covariance": covariance}
    return {"header": header(seconds, frame), "twist": told}


def made(store: Any, kind: str, values: dict[str, Any]) -> Any:
    """Message of a type with these values, and nothing elsewhere."""
    fields = {}
    for name, (node, detail) in store.fielddefs[kind][1]:
        if node == 2:
            fields[name] = made(store, detail, values.get(name, {}))
        elif node in (3, 4):
            size = detail[1] if node == 3 else 0
            default: Any = np.zeros(size, np.float64) if detail[0][0] == 1 else []
            fields[name] = np.asarray(values[name]) if name in values else default
        else:
            fields[name] = values.get(name, "" if detail[0] == "string" else 0)
    return store.types[kind](**fields)


def written(folder: Path, kind: str, messages: Messages) -> Path:
    """A bag: one.bag of ROS 1, sqlite or mcap of ROS 2."""
    path = folder / kind
    if kind == "one.bag":
        store = STORES[Stores.ROS1_NOETIC]
        writer: Any = rosbag1.Writer(path)
    else:
        store = STORES[Stores.ROS2_HUMBLE]
        plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=8, storage_plugin=plugin)
    with writer:
        connections: dict[str, Any] = {}
        for number, (topic, name, values) in enumerate(messages):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            message = made(store, name, values)
            encode = store.serialize_ros1 if kind == "one.bag" else store.serialize_cdr
            writer.write(connections[topic], START * 10**9 + number, encode(message, name))
    return path
