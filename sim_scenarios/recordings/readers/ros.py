"""ROS 1 bags, ROS 2 bags (a folder, a .db3 or .mcap file), with the package rosbags.

    sensor_msgs/Imu                              rates [rad/s], specific forces [m/s2]
    sensor_msgs/NavSatFix                        positions with the diagonal of their covariance
    geometry_msgs/Twist(WithCovariance)Stamped   in the frame of the fixes or in `map`: velocity of the
                                                 antenna, east, north, up; else velocity of the body
    nav_msgs/Odometry                            its twist: velocity of the body

A twist of a topic that is called a command or a setpoint is what was wanted, and is left out.
Of several topics of one kind the one with the most messages is read, then the first by name; of Imu one that
has rates and forces before those that have one of both. Drivers that publish gyros and accelerometers apart
have 0 in the place of the other half, or say by a covariance of -1 that there is none: two such topics are
one IMU. By REP 103 axes point forward, left, up, which frames called ..._ned and ..._optical(_frame) do not
keep; by REP 145 an Imu at rest feels gravity upwards. Pose and orientation are not read: what they refer to
is north only by agreement. A velocity with a variance that is not positive has no sigma, nor has a position
whose covariance is unknown (type 0).

Stamps are those of the headers, seconds since 1970 (Clock.UNIX), or since the start of a simulation
(Clock.OWN) where they lie before the year 2000.

Source: common_interfaces (messages), REP 103, 105 and 145.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Axes, Clock, Contents, Inertial
from sim_scenarios.recordings.readers.epochs import BodyVelocities, Fixes
from sim_scenarios.recordings.readers.extras import needed
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.recordings.tables import Array
from sim_scenarios.units import DEGREE

_IMU: Final = "sensor_msgs/msg/Imu"
_FIX: Final = "sensor_msgs/msg/NavSatFix"
_TWISTS: Final = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/TwistWithCovarianceStamped")
_ODOMETRY: Final = "nav_msgs/msg/Odometry"
_MAGIC: Final = (b"#ROSBAG V2.0", b"\x89MCAP0\r\n", b"SQLite format 3\x00")
_COMMANDS: Final = ("cmd", "command", "setpoint")
"""Of which one is a part of a topic's name that says what a vehicle shall do."""
_OTHER_AXES: Final = ("_ned", "_optical", "_optical_frame")
_MAP: Final = "map"
_YEAR_2000: Final = 946684800  # s since 1970


def recognises(path: Path) -> bool:
    """Whether a file begins like a bag, or a folder has the description of one."""
    if path.is_dir():
        return b"rosbag2_bagfile_information" in beginning(path / "metadata.yaml")
    return beginning(path).startswith(_MAGIC)


def read(path: Path) -> Contents:
    """IMU, fixes and velocities of a bag.

    Raises
    ------
    InputError
        If the bag is damaged, or has none of the messages.
    """
    highlevel = needed("rosbags.highlevel", "rosbags", "reading ROS bags")
    types = needed("rosbags.typesys", "rosbags", "reading ROS bags")
    if not path.is_dir():
        whole(path)  # says what cannot be opened
    try:
        store = types.get_typestore(types.Stores.ROS2_HUMBLE)
        with highlevel.AnyReader([path], default_typestore=store) as bag:
            return _contents(path, bag)
    except InputError:
        raise
    except Exception as error:  # of damaged bytes the package makes whatever they say
        raise InputError(f"{path}: cannot be read as a ROS bag: {type(error).__name__}: {error}") from None


def _contents(path: Path, bag: Any) -> Contents:
    said = _Said()
    antenna = {_MAP}
    for message in _messages(bag, _FIX):
        antenna.add(message.header.frame_id)
        said.position(message)
    for kind in _TWISTS:
        for message in _messages(bag, kind):
            if message.header.frame_id in antenna:
                said.velocity(message)
            else:
                said.of_body(message)
    for message in _messages(bag, _ODOMETRY):
        said.of_body(message)
    units = ((topic, said.inertial(_of_topic(bag, _IMU, topic))) for topic in _topics(bag, _IMU))
    taken = _one_imu({topic: unit for topic, unit in units if unit is not None})
    imu = next((half for half in taken.values() if not np.isnan(half.angular).all()), None)
    accelerometer = next((half for half in taken.values() if half is not imu), None)
    gnss, body = said.fixes.table(), said.body.table()
    if all(table is None for table in (imu, accelerometer, gnss, body)):
        names = ", ".join((_IMU, _FIX, *_TWISTS, _ODOMETRY))
        raise InputError(f"{path}: has no message of {names} that is no command")
    return Contents(
        Clock.UNIX if said.epoch else Clock.OWN,
        float(said.epoch or 0),
        imu=imu,
        accelerometer=accelerometer,
        gnss=gnss,
        body_velocity=body,
        place=lambda table, row: f"{'Imu message' if table == 'imu' else f'{table} row'} {row + 1}",
        remarks=tuple(_not_read(path, bag, taken)),
    )


def _one_imu(units: Mapping[str, Inertial]) -> dict[str, Inertial]:
    """The IMU, or its gyros and its accelerometers if they were published apart, by topic."""
    turning, heavy = (
        [topic for topic, unit in units.items() if np.nan_to_num(getattr(unit, half)).any()]
        for half in ("angular", "force")
    )
    if whole := [topic for topic in turning if topic in heavy]:
        return {whole[0]: units[whole[0]]}
    gyros = {topic: replace(units[topic], force=_nowhere(units[topic].force)) for topic in turning[:1]}
    forces = {topic: replace(units[topic], angular=_nowhere(units[topic].angular)) for topic in heavy[:1]}
    return {**gyros, **forces}


def _nowhere(values: Array) -> Array:
    return np.full_like(values, np.nan)


def _is_command(connection: Any) -> bool:
    """Whether a topic says what velocity shall be, by its name."""
    topic = connection.topic.casefold()
    return connection.msgtype in _TWISTS and any(command in topic for command in _COMMANDS)


def _topics(bag: Any, kind: str) -> list[str]:
    """Topics of a kind that were measured, the fullest first, then by name."""
    counts: dict[str, int] = {}
    for connection in bag.connections:
        if connection.msgtype == kind and not _is_command(connection):
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
    return sorted(counts, key=lambda topic: (-counts[topic], topic))


def _not_read(path: Path, bag: Any, imus: Container[str]) -> Iterator[str]:
    """Sentences on the topics that were left out, of those of IMUs all but the ones that were taken."""
    for topic in sorted({connection.topic for connection in bag.connections if _is_command(connection)}):
        yield f"{path}: {topic} is left out: by its name it is a command"
    for kind in (_IMU, _FIX, *_TWISTS, _ODOMETRY):
        topics = _topics(bag, kind)
        for topic in topics:
            if topic not in (imus if kind == _IMU else topics[:1]):
                yield f"{path}: {topic} is left out: another topic has more {kind} or comes before it by name"


def _messages(bag: Any, kind: str) -> Iterator[Any]:
    """Messages of the first topic of a kind."""
    for topic in _topics(bag, kind)[:1]:
        yield from _of_topic(bag, kind, topic)


def _of_topic(bag: Any, kind: str, topic: str) -> Iterator[Any]:
    of_topic = [c for c in bag.connections if c.topic == topic and c.msgtype == kind]
    for _, _, raw in bag.messages(connections=of_topic):
        yield bag.deserialize(raw, kind)


class _Said:
    """What the messages have said so far."""

    def __init__(self) -> None:
        self.epoch: int | None = None
        """Second of the first message, since a double holds no nanoseconds since 1970; 0 of a simulation."""
        self.fixes, self.body = Fixes(), BodyVelocities()

    def inertial(self, messages: Iterable[Any]) -> Inertial | None:
        rows = array("d")
        other = False
        for message in messages:
            turn = _told(message.angular_velocity, message.angular_velocity_covariance)
            force = _told(message.linear_acceleration, message.linear_acceleration_covariance)
            rows.extend((self._time(message), *turn, *force))
            other |= message.header.frame_id.endswith(_OTHER_AXES)
        if not rows:
            return None
        table = np.array(rows).reshape(-1, 7)
        axes = None if other else Axes.FORWARD_LEFT_UP
        return Inertial(table[:, 0], table[:, 1:4], table[:, 4:7], False, axes)

    def position(self, message: Any) -> None:
        if message.status.status < 0:
            return
        time = self._time(message)
        self.fixes.position(time, message.latitude * DEGREE, message.longitude * DEGREE, message.altitude)
        if message.position_covariance_type > 0:
            variance = message.position_covariance[::4]
            self.fixes.position_sigma(time, *np.sqrt(np.maximum(variance, 0.0)))

    def velocity(self, message: Any) -> None:
        time, (twist, sigma) = self._time(message), _twist(message)
        self.fixes.velocity(time, *twist)
        self.fixes.velocity_sigma(time, *sigma)

    def of_body(self, message: Any) -> None:
        time, ((forward, left, up), sigma) = self._time(message), _twist(message)
        self.body.velocity(time, -left, forward, up)
        self.body.sigma(time, sigma[1], sigma[0], sigma[2])

    def _time(self, message: Any) -> float:
        stamp = message.header.stamp
        if self.epoch is None:
            self.epoch = int(stamp.sec) if stamp.sec > _YEAR_2000 else 0
        return int(stamp.sec) - self.epoch + float(stamp.nanosec) / 1e9


def _twist(message: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Linear velocity and its standard deviations, 0 where they are not told."""
    twist = message.twist
    if not hasattr(twist, "covariance"):
        return _three(twist.linear), (0.0, 0.0, 0.0)
    x, y, z = twist.covariance[:21:7]
    told = x > 0 and y > 0 and z > 0
    sigma = (math.sqrt(x), math.sqrt(y), math.sqrt(z)) if told else (0.0, 0.0, 0.0)
    return _three(twist.twist.linear), sigma


def _told(vector: Any, covariance: Any) -> tuple[float, float, float]:
    """A vector, not a number where its covariance says that there is none."""
    return (math.nan, math.nan, math.nan) if covariance[0] == -1 else _three(vector)


def _three(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z
