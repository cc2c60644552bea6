"""PX4 logs, written here by the format's description, come back as they were."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from scipy.spatial.transform import Rotation
from written.ulog import FLAGS, IMU, INCREMENTS, MOTION, NEW_FIX, Rows, written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import ulog
from sim_scenarios.recordings.readers.contents import Axes, Clock

pytest.importorskip("pyulog", reason="reading ULog needs pyulog")

ATTITUDE = "uint64_t timestamp_sample;float[4] q"
GLOBAL = "double lat;double lon;float alt;float alt_ellipsoid"
LOCAL = "float vx;float vy;float vz;bool v_xy_valid;bool v_z_valid"
OLD_FIX = f"int32_t lat;int32_t lon;int32_t alt;int32_t alt_ellipsoid;{MOTION};{FLAGS}"
MOVING = (1.5, 2.5, 0.25, 3.0, 4.0, -0.5, 0.75)
NO_HEADING = (*MOVING[:-1], float("nan"))


def rates(count: int = 10) -> Rows:
    values = np.random.default_rng(3).normal(0, 1, (count, 6)).astype(np.float32)
    return [(20_000_000 + 4000 * k, (*v[:3], 4000, *v[3:], 4000)) for k, v in enumerate(values.tolist())]


def test_rates_are_bit_equal(tmp_path: Path) -> None:
    rows = rates()
    contents = ulog.read(written(tmp_path / "log.ulg", {"sensor_combined": (IMU, rows)}))
    assert contents.clock is Clock.OWN
    assert contents.imu is not None
    assert contents.imu.axes is Axes.FORWARD_RIGHT_DOWN
    assert not contents.imu.increments
    np.testing.assert_allclose(contents.imu.time, 20 + 0.004 * np.arange(10), rtol=1e-15)
    np.testing.assert_array_equal(contents.imu.angular, [values[:3] for _, values in rows])
    np.testing.assert_array_equal(contents.imu.force, [values[4:7] for _, values in rows])


def test_increments_only_where_there_are_more_of_them(tmp_path: Path) -> None:
    """By default a log has vehicle_imu twice a second, each of 5 ms."""
    values = np.random.default_rng(4).normal(0, 1, (20, 6)).astype(np.float32).tolist()
    many: Rows = [(20_000_500 + 4000 * k, (20_000_000 + 4000 * k, *v, 4000)) for k, v in enumerate(values)]
    few = many[::10]
    path = tmp_path / "log.ulg"
    sparse = ulog.read(
        written(path, {"vehicle_imu": (INCREMENTS, few), "sensor_combined": (IMU, rates())})
    ).imu
    assert sparse is not None
    assert not sparse.increments
    full = ulog.read(
        written(path, {"vehicle_imu": (INCREMENTS, many), "sensor_combined": (IMU, rates())})
    ).imu
    assert full is not None
    assert full.increments
    np.testing.assert_allclose(full.time, 20 + 0.004 * np.arange(20), rtol=1e-15)  # when they were taken
    np.testing.assert_array_equal(full.angular, [v[:3] for v in values])
    np.testing.assert_array_equal(full.force, [v[3:] for v in values])


def test_fixes_of_old_logs(tmp_path: Path) -> None:
    rows: Rows = [
        (1_000_000, (0, 0, 0, 0, *NO_HEADING, 0, True)),  # no fix yet
        (2_000_000, (634170503, 104082203, 63889, 103841, *NO_HEADING, 3, True)),
        (3_000_000, (634170503, 104082203, 63889, 103841, *NO_HEADING, 3, False)),
    ]
    contents = ulog.read(written(tmp_path / "log.ulg", {"vehicle_gps_position": (OLD_FIX, rows)}))
    assert contents.heading_aid is None
    assert contents.gnss is not None
    fix = contents.gnss
    np.testing.assert_array_equal(fix.time, [2, 3])
    np.testing.assert_allclose(
        fix.position[0], [np.radians(63.4170503), np.radians(10.4082203), 103.841], rtol=1e-15
    )
    np.testing.assert_array_equal(fix.velocity, [[4, 3, 0.5], [np.nan] * 3])
    np.testing.assert_array_equal(fix.position_sigma[0], [1.5, 1.5, 2.5])
    np.testing.assert_array_equal(fix.velocity_sigma[0], [0.25] * 3)


def test_fixes_and_headings_of_new_logs(tmp_path: Path) -> None:
    place = (47.397742, 8.5455938, 487.99, 535.25)
    rows: Rows = [
        (2_000_000, (1_900_000, *place, *MOVING, 0.0625, 6, True)),
        (3_000_000, (0, *place, *NO_HEADING, 0.0, 3, True)),
    ]
    contents = ulog.read(written(tmp_path / "log.ulg", {"sensor_gps": (NEW_FIX, rows)}))
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    np.testing.assert_array_equal(contents.gnss.time, [1.9, 3])  # valid; received, where that is all it says
    expected = [np.radians(47.397742), np.radians(8.5455938), 535.25]
    np.testing.assert_allclose(contents.gnss.position[0], expected, rtol=1e-15)
    np.testing.assert_array_equal(contents.heading_aid.time, [1.9])
    np.testing.assert_array_equal(contents.heading_aid.heading, [0.75])
    np.testing.assert_array_equal(contents.heading_aid.sigma, [0.0625])


def test_the_autopilot_s_own_solution(tmp_path: Path) -> None:
    """The quaternion turns forward, right, down to north, east, down."""
    roll, pitch, yaw = 0.1, -0.2, 4.0
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()
    topics: dict[str, tuple[str, Rows]] = {
        "vehicle_attitude": (ATTITUDE, [(1_000_000, (1_000_000, w, x, y, z))]),
        "vehicle_global_position": (GLOBAL, [(2_000_000, (47.5, 8.5, 488.0, 535.5))]),
        "vehicle_local_position": (
            LOCAL,
            [(2_000_000, (1, 2, 3, True, True)), (3_000_000, (1, 2, 3, False, True))],
        ),
    }
    contents = ulog.read(written(tmp_path / "log.ulg", topics))
    assert contents.imu is None
    assert contents.reference is not None
    truth = contents.reference
    np.testing.assert_array_equal(truth.time, [1, 2])
    np.testing.assert_allclose(truth.attitude[0], [roll, pitch, yaw], atol=1e-6)  # float32
    np.testing.assert_allclose(truth.position[1], [np.radians(47.5), np.radians(8.5), 535.5], rtol=1e-15)
    np.testing.assert_array_equal(truth.velocity[1], [2, 1, -3])
    assert np.isnan(truth.position[0]).all()
    assert np.isnan(truth.attitude[1]).all()


def test_height_above_mean_sea_level_alone_is_none(tmp_path: Path) -> None:
    rows: Rows = [(2_000_000, (47.5, 8.5, 488.0))]
    path = written(
        tmp_path / "log.ulg", {"vehicle_global_position": ("double lat;double lon;float alt", rows)}
    )
    truth = ulog.read(path).reference
    assert truth is not None
    np.testing.assert_array_equal(np.isnan(truth.position), [[False, False, True]])


def test_nothing_that_is_read(tmp_path: Path) -> None:
    path = written(tmp_path / "log.ulg", {"battery_status": ("float voltage_v", [(1, (12.5,))])})
    with pytest.raises(InputError, match="has no IMU, fix or solution"):
        ulog.read(path)
    written(path, {"sensor_combined": ("float[3] gyro_rad", [(1, (1, 2, 3))])})
    with pytest.raises(InputError, match=r"a topic lacks the field 'accelerometer_m_s2\[0\]'"):
        ulog.read(path)


def test_a_log_that_was_cut_short_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    path = written(tmp_path / "log.ulg", {"sensor_combined": (IMU, rates())})
    path.write_bytes(path.read_bytes()[:-20])
    imu = ulog.read(path).imu
    assert imu is not None
    assert len(imu.time) == 9


def test_recognised(tmp_path: Path) -> None:
    assert ulog.recognises(written(tmp_path / "a", {"sensor_combined": (IMU, rates())}))
    (tmp_path / "b").write_bytes(b"ULog")
    assert not ulog.recognises(tmp_path / "b")
    assert not ulog.recognises(tmp_path / "there is none")


def test_a_log_whose_messages_lead_back_comes_to_an_end(tmp_path: Path) -> None:
    """The package goes back by the size that a message of no kind claims, not by what was there of it."""
    path = written(tmp_path / "log.ulg", {})
    path.write_bytes(path.read_bytes()[:16] + struct.pack("<HB", 200, 0) + bytes(100))
    with pytest.raises(InputError, match="its messages do not end"):
        ulog.read(path)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("topic", ["sensor_combined", "vehicle_attitude", "sensor_gps"])
def test_bytes_that_are_a_signalling_nan_are_not_measured(tmp_path: Path, topic: str) -> None:
    """Such as one bit of a float makes of another; the processor complains where it is computed with."""
    place = (47.4, 8.5, 488.0, 535.0)
    topics: dict[str, tuple[str, Rows]] = {
        "sensor_combined": (IMU, rates()),
        "vehicle_attitude": (ATTITUDE, [(stamp, (stamp, 0.8, 0.6, 0, 0)) for stamp in (1, 2)]),
        "sensor_gps": (NEW_FIX, [(stamp, (stamp, *place, *MOVING, 0.8, 6, True)) for stamp in (1, 2)]),
    }
    (_, values), *_ = topics[topic][1]
    path = written(tmp_path / "log.ulg", {"sensor_combined": topics["sensor_combined"], topic: topics[topic]})
    numbers = [value for value in values if isinstance(value, float)]
    spoilt = path.read_bytes()
    for value in numbers:
        spoilt = spoilt.replace(struct.pack("<f", value), b"\0\0\xa0\x7f")
        spoilt = spoilt.replace(struct.pack("<d", value), b"\0\0\0\0\0\0\xf4\x7f")
    assert spoilt != path.read_bytes()
    path.write_bytes(spoilt)
    contents = ulog.read(path)
    assert contents.imu is not None
    assert np.isnan(contents.imu.angular[0]).all() == (topic == "sensor_combined")
    assert contents.reference is None
    assert contents.gnss is None or np.isnan(contents.gnss.position).all()


def test_damaged_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    topics = {"sensor_combined": (IMU, rates()), "vehicle_gps_position": (OLD_FIX, [])}
    assert len(refusals(ulog.read, written(tmp_path / "log.ulg", topics))) > 50
    assert capsys.readouterr().out == ""
