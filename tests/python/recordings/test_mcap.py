"""A navigation as MCAP: our own reader and rosbags itself find in it what the data set has."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios.attitude import dcm
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import mcap
from sim_scenarios.recordings.exports import Format, check, export
from sim_scenarios.recordings.readers import ros
from sim_scenarios.recordings.readers.contents import Clock

highlevel = pytest.importorskip("rosbags.highlevel", reason="reading MCAP needs rosbags")

Array = NDArray[np.float64]

ROWS = 40


@pytest.fixture
def run() -> xr.Dataset:
    """What a filter might have said, of random attitudes, as `recordings.replay` has it."""
    random = np.random.default_rng(5)
    time = 86399.5 + 0.1 * np.arange(ROWS)
    angles = {"roll": random.uniform(-1, 1, ROWS), "pitch": random.uniform(-1, 1, ROWS)}
    angles["heading"] = random.uniform(0, 2 * np.pi, ROWS)
    data = {f"nav.{name}": ("time", values) for name, values in angles.items()}
    data |= {
        "nav.latitude": ("time", -0.6 + 1e-6 * np.arange(ROWS)),
        "nav.longitude": ("time", 3.2 + 1e-6 * np.arange(ROWS)),  # beyond the date line
        "nav.height": ("time", random.normal(0, 100, ROWS)),
        "nav.velocity": (("time", "axis3"), random.normal(0, 10, (ROWS, 3))),
        "position_sigma": (("time", "axis3"), random.uniform(0.1, 2, (ROWS, 3))),
        "velocity_sigma": (("time", "axis3"), np.full((ROWS, 3), 0.25)),
        "heading_sigma": ("time", random.uniform(0.001, 0.1, ROWS)),
    }
    return xr.Dataset(data, coords={"time": time})


def test_our_own_reader_finds_positions_and_velocities(run: xr.Dataset, tmp_path: Path) -> None:
    contents = ros.read(export(run, tmp_path / "track.mcap"))
    assert contents.clock is Clock.OWN
    assert contents.imu is None
    gnss, body = contents.gnss, contents.body_velocity
    assert gnss is not None
    assert body is not None
    for table in (gnss, body):
        np.testing.assert_allclose(contents.epoch + table.time, run["time"], atol=1e-9)
    place = np.column_stack([run[f"nav.{name}"] for name in ("latitude", "longitude", "height")])
    place[:, 1] -= 2 * np.pi
    np.testing.assert_allclose(gnss.position, place, rtol=1e-14)
    np.testing.assert_allclose(gnss.position_sigma, run["position_sigma"], rtol=1e-14)
    C_bn = dcm(*(run[f"nav.{name}"].values for name in ("roll", "pitch", "heading")))
    expected = (np.swapaxes(C_bn, -1, -2) @ run["nav.velocity"].values[..., None])[..., 0]
    np.testing.assert_allclose(body.velocity, expected, atol=1e-12)
    np.testing.assert_allclose(body.sigma, 0.25, rtol=1e-12)  # as large in any direction


@pytest.mark.parametrize("epoch", [1_419_811_200.0, 1_419_811_200.25])
def test_stamps_of_a_dated_recording_are_utc(epoch: float, run: xr.Dataset, tmp_path: Path) -> None:
    """GPS time of 2025-01-03, 18 leap seconds ahead."""
    run.attrs["epoch"] = epoch
    contents = ros.read(export(run, tmp_path / "track.mcap"))
    assert contents.clock is Clock.UNIX
    assert contents.gnss is not None
    begin = (np.datetime64("1980-01-06") - np.datetime64("1970-01-01")) / np.timedelta64(1, "s")
    whole = int(epoch) + int(begin) - 18 - int(contents.epoch)
    expected = whole + (epoch % 1 + run["time"].values)
    np.testing.assert_allclose(contents.gnss.time, expected, atol=2e-9)


def test_the_pose_is_that_of_axes_forward_left_up(run: xr.Dataset, tmp_path: Path) -> None:
    path = export(run, tmp_path / "track.mcap")
    with highlevel.AnyReader([path]) as bag:
        assert {c.topic: c.msgtype for c in bag.connections} == {v: k for k, v in mcap.TOPICS.items()}
        of_pose = [c for c in bag.connections if c.msgtype == mcap.ODOMETRY]
        poses = [bag.deserialize(raw, mcap.ODOMETRY) for _, _, raw in bag.messages(connections=of_pose)]
    assert len(poses) == ROWS
    assert {(p.header.frame_id, p.child_frame_id) for p in poses} == {("map", "base_link")}
    turned = [p.pose.pose.orientation for p in poses]
    attitude = Rotation.from_quat([[q.x, q.y, q.z, q.w] for q in turned]).as_matrix()
    heading, pitch, roll = (run[f"nav.{name}"].values for name in ("heading", "pitch", "roll"))
    forward, left, up = np.moveaxis(attitude, -1, 0)
    expected = [np.sin(heading) * np.cos(pitch), np.cos(heading) * np.cos(pitch), np.sin(pitch)]
    np.testing.assert_allclose(forward, np.transpose(expected), atol=1e-12)
    np.testing.assert_allclose(left[:, 2], np.sin(roll) * np.cos(pitch), atol=1e-12)  # right side down
    np.testing.assert_allclose(up[:, 2], np.cos(roll) * np.cos(pitch), atol=1e-12)
    first, last = poses[0].pose.pose.position, poses[-1].pose.pose.position
    assert (first.x, first.y, first.z) == (0, 0, 0)
    assert last.y == pytest.approx(39e-6 * 6.36e6, rel=2e-3)
    assert last.x == pytest.approx(39e-6 * 6.38e6 * np.cos(0.6), rel=2e-3)
    sigma = [np.sqrt(p.pose.covariance[35]) for p in poses]
    np.testing.assert_allclose(sigma, run["heading_sigma"], rtol=1e-12)


def test_without_rosbags_it_is_refused_before_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    check(Format.csv)
    with pytest.raises(InputError, match="writing MCAP needs the package rosbags: pip install"):
        check(Format.mcap)
