"""KF-GINS text, written here by its README, comes back as it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from written.kf_gins import written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import kf_gins
from sim_scenarios.recordings.readers.contents import Axes, Clock
from sim_scenarios.recordings.tables import Array

PERIOD = 0.005
SECOND = 116450.0003270007
"""Of an ADIS16465 in the wild: stamps are on no grid."""


def increments(count: int = 40) -> Array:
    random = np.random.default_rng(5)
    time = SECOND + PERIOD * np.arange(count) + random.uniform(0, 1e-4, count)
    angle = random.normal(0, 1e-5, (count, 3))
    velocity = random.normal(0, 1e-4, (count, 3)) - [0, 0, 9.8 * PERIOD]
    return np.column_stack((time, angle, velocity))


def fixes(count: int = 20) -> Array:
    random = np.random.default_rng(6)
    place = np.column_stack(
        (30 + random.random(count), 114 + random.random(count), 20 + random.random(count))
    )
    return np.column_stack((456250.0 + np.arange(count), place, random.uniform(0.01, 0.05, (count, 3))))


def test_imu_is_bit_equal(tmp_path: Path) -> None:
    table = increments()
    contents = kf_gins.read(written(tmp_path / "imu.txt", table))
    assert contents.clock is Clock.OWN
    assert contents.gnss is None
    assert contents.imu is not None
    assert contents.imu.axes is Axes.FORWARD_RIGHT_DOWN
    assert contents.imu.increments
    np.testing.assert_array_equal(contents.imu.time, table[:, 0])
    np.testing.assert_array_equal(contents.imu.angular, table[:, 1:4])
    np.testing.assert_array_equal(contents.imu.force, table[:, 4:7])


def test_positions(tmp_path: Path) -> None:
    table = fixes()
    contents = kf_gins.read(written(tmp_path / "gnss.txt", table))
    assert contents.imu is None
    assert contents.gnss is not None
    fix = contents.gnss
    np.testing.assert_array_equal(fix.time, table[:, 0])
    np.testing.assert_allclose(np.degrees(fix.position[:, :2]), table[:, 1:3], rtol=1e-15)
    np.testing.assert_array_equal(fix.position[:, 2], table[:, 3])
    np.testing.assert_array_equal(fix.position_sigma, table[:, [5, 4, 6]])  # north, east, down
    assert np.isnan(fix.velocity).all()
    assert not fix.velocity_sigma.any()


def test_positions_and_velocities(tmp_path: Path) -> None:
    velocity = np.tile([1.0, 2.0, 3.0, 0.1, 0.2, 0.3], (20, 1))
    contents = kf_gins.read(written(tmp_path / "gnss.txt", np.hstack((fixes(), velocity))))
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.velocity[0], [2, 1, -3])
    np.testing.assert_array_equal(contents.gnss.velocity_sigma[0], [0.2, 0.1, 0.3])


def test_reference(tmp_path: Path) -> None:
    row = [2017, 116454.0, 30.5, 114.25, 19.5, -0.5, 1.5, 0.25, 1.75, -1.5, 107.25]
    later = [2017, 116455.0, *row[2:]]
    contents = kf_gins.read(written(tmp_path / "truth.nav", np.array([row, later])))
    assert contents.clock is Clock.GPS
    assert contents.epoch == 2017 * 604800
    assert contents.reference is not None
    truth = contents.reference
    np.testing.assert_array_equal(truth.time, [116454.0, 116455.0])
    np.testing.assert_allclose(truth.position[0], [np.radians(30.5), np.radians(114.25), 19.5], rtol=1e-15)
    np.testing.assert_array_equal(truth.velocity[0], [1.5, -0.5, -0.25])
    np.testing.assert_allclose(np.degrees(truth.attitude[0]), [1.75, -1.5, 107.25], rtol=1e-15)


def test_a_new_week(tmp_path: Path) -> None:
    table = increments()
    table[:, 0] = (604800 - 0.1 + PERIOD * np.arange(len(table))) % 604800
    imu = kf_gins.read(written(tmp_path / "imu.txt", table)).imu
    assert imu is not None
    np.testing.assert_allclose(np.diff(imu.time), PERIOD, atol=1e-9)


def test_rows_have_their_lines(tmp_path: Path) -> None:
    path = written(tmp_path / "imu.txt", increments())
    path.write_text("# comment\n\n" + path.read_text())
    assert kf_gins.read(path).place("imu", 6) == "line 9"


def test_rows_that_are_none(tmp_path: Path) -> None:
    path = written(tmp_path / "imu.txt", increments())
    lines = path.read_text().splitlines()
    lines[4] = lines[4].rsplit(maxsplit=1)[0]
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"imu.txt: line 5: has 6 numbers, where the first row has 7"):
        kf_gins.read(path)
    lines[4] += " abc"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"imu.txt: line 5: 'abc' is not a finite number"):
        kf_gins.read(path)


def test_another_table_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="7 columns that are neither"):
        kf_gins.read(written(tmp_path / "x.txt", np.ones((5, 7)) * -3))


def test_recognised(tmp_path: Path) -> None:
    assert kf_gins.recognises(written(tmp_path / "imu.txt", increments(400)))
    assert kf_gins.recognises(written(tmp_path / "gnss.txt", fixes()))
    assert not kf_gins.recognises(written(tmp_path / "rates.txt", increments() * [1, 1, 1, 1, 200, 200, 200]))
    # What is no sigma of a fix, and comes faster than any receiver measures.
    assert not kf_gins.recognises(written(tmp_path / "large.txt", fixes() + np.eye(7)[5] * 100))
    assert not kf_gins.recognises(written(tmp_path / "fast.txt", fixes() * [1e-4, 1, 1, 1, 1, 1, 1]))
    (tmp_path / "headed.csv").write_text("time gx gy gz ax ay az\n1 2 3 4 5 6 7\n")
    assert not kf_gins.recognises(tmp_path / "headed.csv")
    (tmp_path / "empty").write_text("")
    assert not kf_gins.recognises(tmp_path / "empty")
    assert not kf_gins.recognises(tmp_path / "there is none")


def test_damaged_files(tmp_path: Path) -> None:
    assert len(refusals(kf_gins.read, written(tmp_path / "imu.txt", increments(10)))) > 50
