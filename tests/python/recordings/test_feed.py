"""What a filter is fed of a recording: counts, stamps, and which measurement when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.feed import feed
from sim_scenarios.recordings.tables import BodyVelocityTable, FixTable, HeightTable, ImuTable, Recording


def recording(time: list[float] | np.ndarray) -> Recording:
    time = np.asarray(time, dtype=float)
    increments = np.arange(3.0 * len(time)).reshape(-1, 3) + 1
    return Recording("made", ImuTable(time, increments, -increments))


def fixes(time: list[float], **changes: np.ndarray) -> FixTable:
    count = np.arange(1.0, len(time) + 1)[:, None]
    zero = np.zeros((len(time), 3))
    each = count + np.array([0.1, 0.2, 0.3])
    table = FixTable(np.array(time), each, -each, zero, zero)
    return replace(table, **changes)


def test_increments_and_stamps_are_those_of_the_recording() -> None:
    made = recording([1.0, 1.01, 1.02])
    fed = feed(made)
    np.testing.assert_allclose(fed.time, [0.99, 1.0, 1.01, 1.02], atol=1e-12)
    np.testing.assert_array_equal(fed.columns["imu.sample"], [0, 1, 2, 3])
    np.testing.assert_array_equal(fed.columns["imu.time"], fed.time)
    np.testing.assert_array_equal(fed.columns["imu.delta_angle[2]"], [0, 2, 5, 8])
    np.testing.assert_array_equal(fed.columns["imu.delta_velocity[3]"], [0, -3, -6, -9])


def test_a_gap_is_a_jump_of_the_sample_counter() -> None:
    fed = feed(recording([1.0, 1.01, 1.02, 1.06, 1.07]))
    np.testing.assert_array_equal(fed.columns["imu.sample"], [0, 1, 2, 3, 7, 8])
    assert fed.time[0] == pytest.approx(0.99)


@pytest.mark.parametrize(
    ("rate", "grid", "origin"),
    [(300.0, 1e-6, 0.0), (400.0, 1e-3, 0.0), (187.5, 1e-3, 0.0), (1000.0, 2e-7, 1.7e9), (152.0, 1e-3, 0.0)],
)
def test_stamps_on_a_grid_invent_no_missing_samples(rate: float, grid: float, origin: float) -> None:
    """Each was counted by its median step once, which found up to 32,999 samples missing."""
    stamps = origin + np.round(np.arange(1, 20_001) / rate / grid) * grid
    fed = feed(recording(stamps))
    np.testing.assert_array_equal(fed.columns["imu.sample"], np.arange(20_001))


def test_a_fix_enters_with_the_first_sample_not_before_it() -> None:
    made = replace(recording([1.0, 1.01, 1.02, 1.03]), gnss=fixes([0.5, 1.005, 1.02, 1.021, 9.0]))
    fed = feed(made)
    np.testing.assert_array_equal(fed.columns["gnss.sample"], [0, 0, 1, 2, 3])
    np.testing.assert_allclose(fed.columns["gnss.time"], [1.005, 1.005, 1.005, 1.02, 1.021])
    np.testing.assert_allclose(fed.columns["gnss.latitude"], [2.1, 2.1, 2.1, 3.1, 4.1])
    np.testing.assert_allclose(fed.columns["gnss.velocity[3]"], [-2.3, -2.3, -2.3, -3.3, -4.3])


def test_rounding_of_a_stamp_does_not_keep_a_fix_back() -> None:
    made = replace(recording(np.arange(1, 31) * 0.1), gnss=fixes([0.3]))
    assert made.imu.time[2] != 0.3
    np.testing.assert_array_equal(feed(made).columns["gnss.sample"][:5], [0, 0, 0, 1, 1])


def test_sigmas_are_fed_where_they_are_told_and_unmeasured_components_as_they_are() -> None:
    told = np.full((2, 3), 0.5)
    gnss = fixes([1.0, 1.01], position_sigma=told, velocity=np.array([[1.0, np.nan, np.nan], [1, 2, 3]]))
    columns = feed(replace(recording([1.0, 1.01, 1.02]), gnss=gnss)).columns
    np.testing.assert_array_equal(columns["gnss.fix_position_sigma[3]"], 0.5)
    assert "gnss.fix_velocity_sigma[1]" not in columns
    np.testing.assert_array_equal(columns["gnss.velocity[2]"], [np.nan, np.nan, 2.0, 2.0])


def test_aids_have_counts_of_their_own() -> None:
    speeds = np.array([[0.0, 5.0, 0.0], [0.1, 6.0, 0.2]])
    log = BodyVelocityTable(np.array([1.0, 1.015]), speeds, np.zeros((2, 3)))
    barometer = HeightTable(np.array([1.01]), np.array([30.0]), np.array([2.0]))
    made = replace(recording([1.0, 1.01, 1.02]), body_velocity=log, height_aid=barometer)
    columns = feed(made).columns
    np.testing.assert_array_equal(columns["body_velocity.sample"], [0, 1, 1, 2])
    np.testing.assert_array_equal(columns["body_velocity.velocity[2]"], [5, 5, 5, 6])
    np.testing.assert_array_equal(columns["height_aid.sample"], [0, 0, 1, 1])
    np.testing.assert_array_equal(columns["height_aid.sigma"], 2.0)
    assert not any(name.startswith("heading_aid") for name in columns)
    np.testing.assert_array_equal(columns["gnss.sample"], 0)


def test_what_precedes_the_start_is_not_fed() -> None:
    made = replace(recording([1.0, 1.01, 1.02, 1.03]), gnss=fixes([1.0, 1.01, 1.025]))
    fed = feed(made, begin=1.01)
    np.testing.assert_array_equal(fed.time, [1.01, 1.02, 1.03])
    np.testing.assert_array_equal(fed.columns["imu.delta_angle[1]"], [0, 7, 10])
    np.testing.assert_array_equal(fed.columns["gnss.sample"], [0, 0, 1])


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(InputError, match=r"1 IMU samples follow 1\.02 s; at least 2 must"):
        feed(recording([1.0, 1.01, 1.02, 1.03]), begin=1.02)


def test_a_gap_that_no_counter_covers_is_refused() -> None:
    with pytest.raises(InputError, match="must be at most 2147483647, those that are missing included"):
        feed(recording([*np.arange(1, 200) * 0.01, 1e8]))


def jittered(late: float, rates: bool) -> tuple[np.ndarray, Recording]:
    """The steady clock of a sensor at rest, and a recording stamped up to a part of a period late."""
    steady = 0.01 * np.arange(1, 3001)
    time = steady + 0.01 * late * np.random.default_rng(4).uniform(0.0, 1.0, len(steady))
    covers = np.diff(time, prepend=0.0) if rates else np.full(len(steady), 0.01)
    force = np.array([0.0, 0.0, 9.8]) + 0.5 * np.sin(steady)[:, None]  # as waves have it
    return steady, Recording("made", ImuTable(time, 1e-4 * np.ones((3000, 3)), force * covers[:, None]))


@pytest.mark.parametrize("late", [0.45, 0.9])
def test_increments_that_were_stamped_late_go_by_the_clock_of_the_sensor(late: float) -> None:
    steady, made = jittered(late, rates=False)
    fed = feed(made)
    np.testing.assert_allclose(np.diff(fed.time[1:]), 0.01, rtol=0.02)
    np.testing.assert_allclose(
        fed.time[1:] - steady, 0.005 * late, atol=0.1 * 0.01 * late
    )  # late in the mean
    np.testing.assert_array_equal(fed.columns["imu.sample"], np.arange(3001))
    assert "moved onto its own steady clock" in fed.remark


@pytest.mark.parametrize(("late", "rates"), [(0.1, False), (0.9, True)])
def test_stamps_that_filters_can_go_by_are_left_alone(late: float, rates: bool) -> None:
    """Little jitter; and increments made of rates, which cover just the step of their stamps."""
    _, made = jittered(late, rates)
    fed = feed(made)
    np.testing.assert_array_equal(fed.time[1:], made.imu.time)
    assert fed.remark == ""


def test_stamps_that_follow_no_steady_clock_stay_as_they_are() -> None:
    """A sensor that slows down from 100 Hz to 5 Hz, with stamps up to nine tenths of a period late."""
    _, made = jittered(0.9, rates=False)
    time = np.concatenate([made.imu.time[:1000], made.imu.time[999] + 20 * (made.imu.time[1000:] - 10.0)])
    made = replace(made, imu=replace(made.imu, time=time))
    fed = feed(made)
    np.testing.assert_array_equal(fed.time[1:], time)
    assert "stay as recorded: stamps near" in fed.remark
