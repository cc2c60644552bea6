"""PSINS files, written here as the toolbox writes them, come back as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from damage import CASES, refusals
from scipy.io import savemat
from written.psins import GRAVITY, PERIOD, counted

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import psins
from sim_scenarios.recordings.readers.contents import Axes, Clock
from sim_scenarios.recordings.tables import Array

ARCSEC = np.pi / 180 / 3600


def increments(count: int = 50, start: float = 0.0) -> Array:
    """Delta angles, delta velocities, time: the toolbox's IMU array."""
    random = np.random.default_rng(7)
    noise = random.normal(0, 1e-5, (count, 6))
    noise[:, 5] += 9.8 * PERIOD
    return np.column_stack((noise, start + PERIOD * np.arange(count)))


def counts(columns: int = 6, count: int = 50) -> Array:
    random = np.random.default_rng(8)
    table = random.integers(-9, 10, (count, columns)).astype(float)
    table[:, 5] += 80
    return table


def test_counts_are_bit_equal(tmp_path: Path) -> None:
    table = counts()
    contents = psins.read(counted(tmp_path / "gyro.imu", table, start=100.0))
    assert contents.clock is Clock.OWN
    assert contents.imu is not None
    imu = contents.imu
    assert imu.axes is Axes.RIGHT_FORWARD_UP
    assert imu.increments
    np.testing.assert_allclose(imu.time, 100 + PERIOD * np.arange(1, 51), rtol=1e-15)
    np.testing.assert_array_equal(np.rint(imu.angular / (0.1 * ARCSEC)), table[:, :3])
    np.testing.assert_allclose(imu.angular, table[:, :3] * 0.1 * ARCSEC, rtol=1e-15)
    np.testing.assert_allclose(imu.force, table[:, 3:] * 125 * 1e-6 * GRAVITY, rtol=1e-15)


def test_intervals_that_were_not_kept(tmp_path: Path) -> None:
    table = counts(7)
    table[:, 6] = 0
    table[3, 6] = 250  # us
    imu = psins.read(counted(tmp_path / "gyro.imu", table)).imu
    assert imu is not None
    expected = np.full(49, PERIOD)
    expected[2] += 250e-6
    np.testing.assert_allclose(np.diff(imu.time), expected, atol=1e-12)


def test_rows_have_their_places(tmp_path: Path) -> None:
    assert psins.read(counted(tmp_path / "gyro.imu", counts())).place("imu", 3) == "line 10"
    (tmp_path / "imu.bin").write_bytes(increments().tobytes())
    assert psins.read(tmp_path / "imu.bin").place("imu", 3) == "row 4"
    savemat(tmp_path / "run.mat", {"mimu": increments()})
    assert psins.read(tmp_path / "run.mat").place("imu", 3) == "mimu: row 4"


def test_settings_that_cannot_be(tmp_path: Path) -> None:
    path = counted(tmp_path / "gyro.imu", counts())
    path.write_text(path.read_text().replace("10.00000000 9.780327", "0.0 9.780327"))
    with pytest.raises(InputError, match=r"interval \(0 ms\)"):
        psins.read(path)


@pytest.mark.parametrize("dtype", ["<f8", "<f4"])
def test_binary_is_bit_equal(tmp_path: Path, dtype: str) -> None:
    table = increments().astype(dtype)
    path = tmp_path / "imu.bin"
    path.write_bytes(table.tobytes())
    assert psins.recognises(path)
    imu = psins.read(path).imu
    assert imu is not None
    np.testing.assert_array_equal(imu.time, table[:, 6])
    np.testing.assert_array_equal(imu.angular, table[:, 0:3])
    np.testing.assert_array_equal(imu.force, table[:, 3:6])
    path.write_bytes(table.tobytes()[:-3])
    with pytest.raises(InputError, match=r"imu.bin: row 50 is cut short"):
        psins.read(path)


def test_binary_of_something_else(tmp_path: Path) -> None:
    path = tmp_path / "random.bin"
    path.write_bytes(np.random.default_rng(9).bytes(5600))
    assert not psins.recognises(path)
    with pytest.raises(InputError, match="no increments of an IMU"):
        psins.read(path)


def test_arrays_are_bit_equal(tmp_path: Path) -> None:
    imu, time = increments(start=185492.5), PERIOD * np.arange(1.0, 21.0)
    avp = np.column_stack((np.random.default_rng(1).normal(0, 0.1, (20, 9)), time))
    gps = np.column_stack((np.random.default_rng(2).normal(0, 0.1, (20, 6)), time))
    path = tmp_path / "run.mat"
    savemat(path, {"imu": imu, "avp": avp, "gps": gps, "eb": np.zeros((3, 1))})
    assert psins.recognises(path)
    contents = psins.read(path)
    assert contents.imu is not None
    assert contents.gnss is not None
    assert contents.reference is not None
    np.testing.assert_array_equal(contents.imu.time, imu[:, 6])
    np.testing.assert_array_equal(contents.imu.angular, imu[:, 0:3])
    np.testing.assert_array_equal(contents.imu.force, imu[:, 3:6])
    np.testing.assert_array_equal(contents.gnss.velocity, gps[:, 0:3])
    np.testing.assert_array_equal(contents.gnss.position, gps[:, 3:6])
    np.testing.assert_array_equal(contents.reference.time, time)
    np.testing.assert_array_equal(contents.reference.attitude[:, :2], avp[:, [1, 0]])  # pitch comes first
    np.testing.assert_allclose(contents.reference.attitude[:, 2], -avp[:, 2] % (2 * np.pi), rtol=1e-15)
    np.testing.assert_array_equal(contents.reference.velocity, avp[:, 3:6])
    np.testing.assert_array_equal(contents.reference.position, avp[:, 6:9])


def test_yaw_is_counterclockwise(tmp_path: Path) -> None:
    """a2mat of the toolbox turns from north to west: its forward axis points west at a yaw of 90 deg."""
    avp = np.zeros((3, 10))
    avp[:, 2], avp[:, 9] = np.pi / 2, [1, 2, 3]
    savemat(tmp_path / "avp.mat", {"avp": avp})
    reference = psins.read(tmp_path / "avp.mat").reference
    assert reference is not None
    np.testing.assert_allclose(np.degrees(reference.attitude[:, 2]), 270)


def test_positions_alone_and_structures(tmp_path: Path) -> None:
    """Trajectories of the toolbox are structures; names of IMUs are anything (mimu, imu1)."""
    time = np.arange(1.0, 6.0)
    gnss = np.column_stack((np.full((5, 3), 0.5), time))
    savemat(tmp_path / "run.mat", {"trj": {"mimu": increments(), "avp0": np.zeros((9, 1))}, "gnss": gnss})
    contents = psins.read(tmp_path / "run.mat")
    assert contents.imu is not None
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.imu.force, increments()[:, 3:6])
    np.testing.assert_array_equal(contents.gnss.position, gnss[:, :3])
    assert np.isnan(contents.gnss.velocity).all()


def test_arrays_of_something_else(tmp_path: Path) -> None:
    savemat(tmp_path / "x.mat", {"ap": np.ones((5, 7)), "name": "ship"})
    with pytest.raises(InputError, match="no array is an IMU"):
        psins.read(tmp_path / "x.mat")


def test_newer_matlab_says_how_to_save(tmp_path: Path) -> None:
    path = tmp_path / "new.mat"
    head = b"MATLAB 7.3 MAT-file".ljust(116) + bytes(8) + b"\x00\x02IM"
    path.write_bytes(head + b"\x89HDF\r\n\x1a\n" + bytes(64))
    with pytest.raises(InputError, match=r"version 7\.3; save it with -v7"):
        psins.read(path)


def test_recognised(tmp_path: Path) -> None:
    assert psins.recognises(counted(tmp_path / "gyro.imu", counts()))
    (tmp_path / "other.imu").write_text("1 2 3 4 5 6 7\n")
    assert not psins.recognises(tmp_path / "other.imu")
    assert not psins.recognises(tmp_path / "there is none.bin")


def test_damaged_files(tmp_path: Path) -> None:
    assert len(refusals(psins.read, counted(tmp_path / "gyro.imu", counts(count=10)))) > 50
    (tmp_path / "imu.bin").write_bytes(increments().tobytes())
    assert len(refusals(psins.read, tmp_path / "imu.bin")) > 50
    savemat(tmp_path / "imu.mat", {"imu": increments()})
    cases = max(CASES // 10, 20)  # each is read by a process of its own
    assert len(refusals(psins.read, tmp_path / "imu.mat", cases)) > cases / 4
