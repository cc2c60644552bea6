"""A reference between its times, and one of another file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim_scenarios.attitude import dcm
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.reference import at, of_file
from sim_scenarios.recordings.tables import ImuTable, Recording, ReferenceTable
from sim_scenarios.units import DEGREE

ANGLES = ("roll", "pitch", "heading")
UNKNOWN = np.full((4, 3), np.nan)


def table(
    attitude: np.ndarray, position: np.ndarray = UNKNOWN, velocity: np.ndarray = UNKNOWN
) -> ReferenceTable:
    return ReferenceTable(np.array([0.0, 1.0, 2.0, 3.0]), attitude, position, velocity)


def test_attitude_turns_the_shortest_way() -> None:
    """Half way between two attitudes, each is as far as the other, and half as far as they are apart."""
    angles = np.array([[0.1, -0.3, 6.2], [0.4, 0.2, 0.3], [0.4, 0.2, 0.3], [0.4, 0.2, 0.3]])
    found = at(table(angles), np.array([0.5]))
    between = dcm(*(found[f"truth.{angle}"][0] for angle in ANGLES))
    first, last = dcm(*angles[0]), dcm(*angles[1])

    def apart(one: np.ndarray, other: np.ndarray) -> float:
        return float(Rotation.from_matrix(one.T @ other).magnitude())

    assert apart(first, between) == pytest.approx(apart(between, last))
    assert apart(first, between) == pytest.approx(apart(first, last) / 2)


def test_a_heading_alone_passes_north() -> None:
    angles = np.full((4, 3), np.nan)
    angles[:, 2] = np.array([358.0, 0.0, 2.0, 4.0]) * DEGREE
    found = at(table(angles), np.array([0.25, 0.75, 2.5]))
    np.testing.assert_allclose(np.unwrap(found["truth.heading"]) / DEGREE % 360, [358.5, 359.5, 3.0])
    assert np.isnan(found["truth.roll"]).all()


def test_a_longitude_passes_the_date_line_and_all_else_goes_straight() -> None:
    position = np.array(
        [[0.1, np.pi - 1e-3, 5.0], [0.2, -np.pi + 1e-3, 7.0], [0.3, -3.1, 9.0], [0.4, -3.0, 11.0]]
    )
    velocity = np.arange(12.0).reshape(4, 3)
    found = at(table(UNKNOWN, position, velocity), np.array([0.5, 2.5]))
    assert abs(found["truth.longitude"][0]) == pytest.approx(np.pi)
    np.testing.assert_allclose(found["truth.latitude"], [0.15, 0.35])
    np.testing.assert_allclose(found["truth.height"], [6.0, 10.0])
    np.testing.assert_allclose(found["truth.velocity[2]"], [2.5, 8.5])
    assert np.isnan(found["truth.heading"]).all()


def test_nothing_is_told_before_after_and_in_gaps() -> None:
    time = np.array([0.0, 1.0, 2.0, 3.0, 9.0, 10.0, 11.0])
    reference = ReferenceTable(time, np.zeros((7, 3)), np.zeros((7, 3)), np.zeros((7, 3)))
    found = at(reference, np.array([-0.1, 0.0, 2.9, 5.0, 9.5, 11.0, 11.1]))
    for values in found.values():
        np.testing.assert_array_equal(np.isfinite(values), [False, True, True, False, True, True, False])


def test_a_file_with_dates_goes_with_a_recording_that_counts_seconds_of_the_day(tmp_path: Path) -> None:
    """Week 2300, Wednesday; the recording begins at noon."""
    noon, time = 43200.0, np.arange(0.0, 50.0)
    rows = [
        f"2300 {3 * 86400 + noon + t:.3f} 30.0 114.0 20.0 1.0 2.0 -3.0 0.5 1.5 {90 + t:.3f}" for t in time
    ]
    (tmp_path / "truth.nav").write_text("\n".join(rows) + "\n")
    stamps = noon + np.arange(0.0, 50.0, 0.1)
    made = Recording("made", ImuTable(stamps, np.zeros((500, 3)), np.zeros((500, 3))))
    found, remarks = of_file(tmp_path / "truth.nav", made)
    assert remarks == []
    np.testing.assert_allclose(found.time, noon + time)
    np.testing.assert_allclose(found.attitude[10] / DEGREE, [0.5, 1.5, 100.0])
    np.testing.assert_allclose(found.velocity[0], [2.0, 1.0, 3.0])
    late = Recording("late", ImuTable(stamps + 3600.0, np.zeros((500, 3)), np.zeros((500, 3))))
    with pytest.raises(InputError, match="do not overlap"):
        of_file(tmp_path / "truth.nav", late)
    day = 2300 * 604800.0 + 3 * 86400
    same, _ = of_file(tmp_path / "truth.nav", replace(made, epoch=day))
    np.testing.assert_array_equal(same.time, found.time)
    with pytest.raises(InputError, match="do not overlap"):
        of_file(tmp_path / "truth.nav", replace(made, epoch=day + 86400))


def test_rows_of_a_file_stand_in_order_and_once(tmp_path: Path) -> None:
    path = tmp_path / "truth.nav"
    rows = [f"2300 {3 * 86400 + t} 30.0 114.0 20.0 1.0 2.0 -3.0 0.5 1.5 {90 + t}\n" for t in range(50)]
    stamps = np.arange(0.0, 50.0, 0.1)
    made = Recording("made", ImuTable(stamps, np.zeros((500, 3)), np.zeros((500, 3))))
    path.write_text("".join([*rows[:10], *rows[9:]]))
    found, remarks = of_file(path, made)
    np.testing.assert_array_equal(found.time, np.arange(50.0))
    assert remarks == [f"{path}: line 11: 1 row written twice, left out"]
    path.write_text("".join([*rows[:10], rows[9].replace(" 99", " 98"), *rows[10:]]))
    with pytest.raises(InputError, match=r"truth.nav: line 11: time must increase"):
        of_file(path, made)


def test_a_file_without_a_reference_is_refused(tmp_path: Path) -> None:
    made = Recording("made", ImuTable(np.arange(1.0, 9.0), np.zeros((8, 3)), np.zeros((8, 3))))
    (tmp_path / "imu.csv").write_text(
        "time,delta_angle_x,delta_angle_y,delta_angle_z,delta_velocity_x,delta_velocity_y,delta_velocity_z\n"
        + "".join(f"{t},0,0,0,0,0,9.8\n" for t in range(1, 9))
    )
    with pytest.raises(InputError, match="has no reference"):
        of_file(tmp_path / "imu.csv", made)
