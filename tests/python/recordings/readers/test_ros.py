"""ROS bags, written by the package that reads them, come back as they were."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damage import CASES, refusals

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import ros
from sim_scenarios.recordings.readers.contents import Axes, Clock

pytest.importorskip("rosbags", reason="reading ROS bags needs rosbags")
from written.ros import (
    FIX,
    IMU,
    ODOMETRY,
    START,
    TWIST,
    UNCERTAIN,
    fix,
    header,
    inertial,
    uncertain_twist,
    vector,
    written,
)

KINDS = ["one.bag", "sqlite", "mcap"]


def imu(k: int, frame: str = "imu_link", start: int = START) -> dict[str, Any]:
    rates = np.random.default_rng(k).normal(0, 1, 6)
    rates[5] += 9.8
    return inertial(0.25 * k, rates[:3], rates[3:], frame, start)


def twist(seconds: float, frame: str) -> dict[str, Any]:
    return {"header": header(seconds, frame), "twist": {"linear": vector([1.0, 2.0, 3.0])}}


@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_bit_equal(tmp_path: Path, kind: str) -> None:
    messages = [imu(k) for k in range(5)]
    path = written(tmp_path, kind, [("/imu", IMU, message) for message in messages])
    assert ros.recognises(path)
    contents = ros.read(path)
    assert contents.clock is Clock.UNIX
    assert contents.imu is not None
    assert contents.imu.axes is Axes.FORWARD_LEFT_UP
    assert not contents.imu.increments
    assert contents.epoch == START
    np.testing.assert_array_equal(contents.imu.time, 0.25 * np.arange(5))
    for values, name in (
        (contents.imu.angular, "angular_velocity"),
        (contents.imu.force, "linear_acceleration"),
    ):
        np.testing.assert_array_equal(values, [list(message[name].values()) for message in messages])


@pytest.mark.parametrize("told", [True, False])
def test_gyros_and_accelerometers_of_two_topics(tmp_path: Path, told: bool) -> None:
    """The half that a driver does not measure is 0, or its covariance says that there is none."""
    nothing = {"covariance": np.array([-1.0, *[0.0] * 8])} if told else {}
    gyros: list[dict[str, Any]] = []
    accelerometers: list[dict[str, Any]] = []
    for k in range(3):
        whole = imu(k, "camera_imu_optical_frame")
        for messages, lacks in ((gyros, "linear_acceleration"), (accelerometers, "angular_velocity")):
            none = {f"{lacks}_{key}": value for key, value in nothing.items()}
            messages.append({**whole, **none, lacks: vector(np.ones(3) if told else np.zeros(3))})
    topics = [("/gyro", IMU, gyro) for gyro in gyros] + [("/acc", IMU, acc) for acc in accelerometers[:2]]
    contents = ros.read(written(tmp_path, "mcap", topics))
    assert contents.imu is not None
    assert contents.accelerometer is not None
    assert contents.imu.axes is None
    assert not contents.remarks
    assert np.isnan(contents.imu.force).all()
    assert np.isnan(contents.accelerometer.angular).all()
    np.testing.assert_array_equal(
        contents.imu.angular, [list(gyro["angular_velocity"].values()) for gyro in gyros]
    )
    np.testing.assert_array_equal(
        contents.accelerometer.force,
        [list(acc["linear_acceleration"].values()) for acc in accelerometers[:2]],
    )
    whole = ros.read(written(tmp_path, "one.bag", [*topics, ("/imu", IMU, imu(0))]))
    assert whole.imu is not None
    assert whole.accelerometer is None
    assert len(whole.imu.time) == 1
    assert len(whole.remarks) == 2


@pytest.mark.parametrize("kind", ["sqlite", "mcap"])
def test_the_file_of_a_bag_alone(tmp_path: Path, kind: str) -> None:
    """What is passed on is often the file without its folder's description."""
    folder = written(tmp_path, kind, [("/imu", IMU, imu(k)) for k in range(3)])
    [path] = [file for file in folder.iterdir() if file.name != "metadata.yaml"]
    assert ros.recognises(path)
    contents = ros.read(path)
    assert contents.imu is not None
    assert len(contents.imu.time) == 3


@pytest.mark.parametrize("kind", KINDS)
def test_fixes(tmp_path: Path, kind: str) -> None:
    messages = [fix(0), fix(1, covariance_type=0), fix(2, status=-1)]
    contents = ros.read(written(tmp_path, kind, [("/fix", FIX, message) for message in messages]))
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.time, [0, 1])
    expected = [np.radians(51.5), np.radians(-114.25), 1047.25]
    np.testing.assert_allclose(contents.gnss.position, [expected] * 2, rtol=1e-15)
    np.testing.assert_allclose(contents.gnss.position_sigma, [[0.2, 0.3, 0.4], [0, 0, 0]], rtol=1e-15)
    assert np.isnan(contents.gnss.velocity).all()


def test_twists_in_the_frame_of_the_fixes_are_the_receiver_s(tmp_path: Path) -> None:
    """Drivers of receivers say east, north, up in the frame of the antenna; the rest is of the body."""
    messages = [
        ("/fix", FIX, fix(0)),
        ("/vel", UNCERTAIN, uncertain_twist(0, "gps")),
        ("/dvl", TWIST, twist(0, "base_link")),
    ]
    contents = ros.read(written(tmp_path, "mcap", messages))
    assert contents.gnss is not None
    assert contents.body_velocity is not None
    np.testing.assert_array_equal(contents.gnss.velocity, [[1, 2, 3]])
    np.testing.assert_array_equal(contents.gnss.velocity_sigma, [[0.5, 1, 2]])
    np.testing.assert_array_equal(contents.body_velocity.velocity, [[-2, 1, 3]])  # from forward, left, up
    np.testing.assert_array_equal(contents.body_velocity.sigma, [[0, 0, 0]])


def test_twists_in_the_map_are_velocities_of_the_antenna(tmp_path: Path) -> None:
    contents = ros.read(written(tmp_path, "mcap", [("/vel", TWIST, twist(0, "map"))]))
    assert contents.body_velocity is None
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.velocity, [[1, 2, 3]])
    assert np.isnan(contents.gnss.position).all()


@pytest.mark.parametrize("topic", ["/cmd_vel", "/mavros/setpoint_velocity/out", "/base/velocity_command"])
def test_what_is_wanted_is_not_what_was_measured(tmp_path: Path, topic: str) -> None:
    command = (topic, TWIST, twist(0, "base_link"))
    contents = ros.read(written(tmp_path, "mcap", [("/fix", FIX, fix(0)), command]))
    assert contents.body_velocity is None
    [remark] = contents.remarks
    assert f"{topic} is left out: by its name it is a command" in remark
    measured = ("/dvl", TWIST, twist(0, "base_link"))
    (tmp_path / "both").mkdir()
    contents = ros.read(written(tmp_path / "both", "mcap", [command, command, measured]))
    assert contents.body_velocity is not None
    assert len(contents.body_velocity.time) == 1


def test_odometry_is_of_the_body(tmp_path: Path) -> None:
    odometry = [uncertain_twist(0, "odom"), uncertain_twist(1, "odom", (0.0, 1.0, 4.0))]
    contents = ros.read(written(tmp_path, "one.bag", [("/odom", ODOMETRY, message) for message in odometry]))
    assert contents.gnss is None
    assert contents.body_velocity is not None
    np.testing.assert_array_equal(contents.body_velocity.velocity, [[-2, 1, 3]] * 2)
    np.testing.assert_array_equal(contents.body_velocity.sigma, [[1, 0.5, 2], [0, 0, 0]])


def test_the_fullest_topic_then_the_first_by_name(tmp_path: Path) -> None:
    many = [("/z", IMU, imu(k, "z")) for k in range(4)]
    few = [("/a", IMU, imu(k, "a")) for k in range(3)]
    contents = ros.read(written(tmp_path, "mcap", few + many))
    assert contents.imu is not None
    assert len(contents.imu.time) == 4
    [remark] = contents.remarks
    assert "/a is left out" in remark


@pytest.mark.parametrize(
    ("frame", "axes"), [("imu_ned", None), ("imu_optical", None), ("", Axes.FORWARD_LEFT_UP)]
)
def test_frames_with_axes_of_their_own(tmp_path: Path, frame: str, axes: Axes | None) -> None:
    contents = ros.read(written(tmp_path, "mcap", [("/imu", IMU, imu(k, frame)) for k in range(3)]))
    assert contents.imu is not None
    assert contents.imu.axes is axes


def test_the_clock_of_a_simulation(tmp_path: Path) -> None:
    contents = ros.read(written(tmp_path, "mcap", [("/imu", IMU, imu(k, start=3)) for k in range(3)]))
    assert contents.clock is Clock.OWN
    assert contents.imu is not None
    np.testing.assert_array_equal(contents.imu.time, [3, 3.25, 3.5])


def test_stamps_to_the_nanosecond(tmp_path: Path) -> None:
    messages = [imu(k) for k in range(3)]
    for message in messages:
        message["header"]["stamp"]["nanosec"] += 123_456_789
    contents = ros.read(written(tmp_path, "mcap", [("/imu", IMU, message) for message in messages]))
    assert contents.imu is not None
    np.testing.assert_array_equal(contents.imu.time, [0.123456789, 0.373456789, 0.623456789])
    assert contents.place("imu", 1) == "Imu message 2"
    assert contents.place("gnss", 1) == "gnss row 2"


def test_nothing_that_is_read(tmp_path: Path) -> None:
    name = "std_msgs/msg/String"
    with pytest.raises(InputError, match=r"one\.bag: has no message of sensor_msgs/msg/Imu"):
        ros.read(written(tmp_path, "one.bag", [("/chat", name, {"data": "hello"})]))


def test_recognised(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("time,gyro\n")
    assert not ros.recognises(tmp_path / "other")
    assert not ros.recognises(tmp_path)
    assert not ros.recognises(tmp_path / "there is none")
    with pytest.raises(InputError, match="there is no recording"):
        ros.read(tmp_path / "there is none.bag")


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files(tmp_path: Path, kind: str) -> None:
    path = written(tmp_path, kind, [("/imu", IMU, imu(k)) for k in range(3)])
    if path.is_dir():
        [path] = [file for file in path.iterdir() if file.name != "metadata.yaml"]
    assert len(refusals(ros.read, path, CASES // len(KINDS) + 1)) > 20
