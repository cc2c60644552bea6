"""From where a filter sets out on a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim_scenarios.attitude import dcm
from sim_scenarios.earth import displaced, displacement
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.start import ROUGH, UNKNOWN, Start, beginning, level
from sim_scenarios.recordings.tables import FixTable, HeadingTable, ImuTable, LeverArms, Recording
from sim_scenarios.units import DEGREE, STANDARD_GRAVITY

GRAVITY = np.array([0.0, 0.0, STANDARD_GRAVITY])
ANGLES = [(0.0, 0.0, 0.3), (0.1, -0.2, 2.0), (-1.0, 0.5, 4.0)]
HOME = np.array([0.7, 0.2, 100.0])


def accelerating(roll: float, pitch: float, heading: float, acceleration: float) -> Recording:
    """A vehicle that goes ahead faster and faster from 10 s on, at an attitude that it keeps."""
    time = 0.01 * np.arange(1, 3001)
    ahead = np.array([np.sin(heading), np.cos(heading), 0.0])
    moves = np.where(time[:, None] > 10.0, acceleration, 0.0) * ahead
    force = (moves + GRAVITY) @ dcm(roll, pitch, heading)
    stamps = 0.25 * np.arange(1, 120)
    since = np.maximum(stamps - 10.0, 0.0)[:, None]
    position = displaced(np.broadcast_to(HOME, (len(stamps), 3)), 0.5 * acceleration * since**2 * ahead)
    zero = np.zeros((len(stamps), 3))
    return Recording(
        "made",
        ImuTable(time, np.zeros((3000, 3)), 0.01 * force),
        FixTable(stamps, position, acceleration * since * ahead, zero, zero),
    )


@pytest.mark.parametrize(("roll", "pitch", "heading"), [*ANGLES, (3.0, 0.1, 0.0)])
def test_levelling_finds_roll_and_pitch(roll: float, pitch: float, heading: float) -> None:
    force = dcm(roll, pitch, heading).T @ [0, 0, 9.8]
    assert level(force) == pytest.approx((roll, pitch))


@pytest.mark.parametrize(("roll", "pitch", "heading"), ANGLES)
def test_levelling_allows_for_an_acceleration(roll: float, pitch: float, heading: float) -> None:
    acceleration = np.array([1.0, 3.0, -0.5])  # right, forward, up
    force = dcm(roll, pitch, heading).T @ dcm(0.0, 0.0, heading) @ (acceleration + GRAVITY)
    assert level(force, acceleration) == pytest.approx((roll, pitch), abs=1e-12)


@pytest.mark.parametrize(("roll", "pitch", "heading"), ANGLES)
def test_a_start_on_the_course(roll: float, pitch: float, heading: float) -> None:
    begun = beginning(accelerating(roll, pitch, heading, 2.0), Start(course_above=3.0))
    assert begun.time == pytest.approx(11.5)  # 3 m/s after 1.5 s of 2 m/s2
    assert begun.knows_heading
    found = [begun.values[f"initial.{angle}"] for angle in ("roll", "pitch", "heading")]
    wrapped = (np.array(found) - [roll, pitch, heading] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(wrapped, 0.0, atol=1e-6)
    speed = [begun.values[f"initial.velocity[{i}]"] for i in (1, 2, 3)]
    np.testing.assert_allclose(speed, 3 * np.array([np.sin(heading), np.cos(heading), 0]), atol=1e-9)


def test_the_course_comes_from_positions_where_no_velocity_was_measured() -> None:
    made = accelerating(0.0, 0.0, 1.0, 2.0)
    made = replace(made, gnss=replace(made.gnss, velocity=np.full((119, 3), np.nan)))
    begun = beginning(made, Start(course_above=3.0))
    assert begun.values["initial.heading"] == pytest.approx(1.0, abs=1e-4)
    assert begun.values["initial.pitch"] == pytest.approx(0.0, abs=0.01)


def test_a_vehicle_that_is_never_fast_has_no_course() -> None:
    with pytest.raises(
        InputError, match=r"no fix of the IMU's time is as fast as 30 m/s; the fastest has 19\.8 m"
    ):
        beginning(accelerating(0, 0, 0, 1.0), Start(course_above=30.0))
    bare = replace(accelerating(0, 0, 0, 1.0), gnss=None)
    with pytest.raises(InputError, match="has no fixes, and so no course to start on"):
        beginning(bare, Start(course_above=3.0))


def test_what_is_known_of_the_heading() -> None:
    made = accelerating(0.0, 0.0, 1.0, 0.0)
    told, unknown = beginning(made, Start(2.0)), beginning(made, Start())
    assert (told.values["initial.heading"], told.values["prior.heading_sigma"]) == (2.0, ROUGH)
    assert told.knows_heading
    assert not unknown.knows_heading
    assert unknown.values["prior.heading_sigma"] == UNKNOWN == pytest.approx(103.92 * DEGREE, abs=1e-4)
    compass = HeadingTable(np.array([0.5]), np.array([1.1]), np.array([0.02]))
    aided = beginning(replace(made, heading_aid=compass), Start())
    assert (aided.values["initial.heading"], aided.values["prior.heading_sigma"]) == (1.1, 0.02)
    assert aided.knows_heading


def test_the_imu_is_not_where_the_antenna_is() -> None:
    made = replace(accelerating(0.0, 0.0, np.pi / 2, 0.0), lever_arms=LeverArms(gnss=(1.0, 2.0, 3.0)))
    values = beginning(made, Start(np.pi / 2)).values
    place = np.array([values[f"initial.{name}"] for name in ("latitude", "longitude", "height")])
    np.testing.assert_allclose(displacement(place, HOME), [-2.0, 1.0, -3.0], atol=1e-6)  # facing east


def test_the_first_fix_of_the_imu_counts_not_one_of_before() -> None:
    made = accelerating(0.0, 0.0, 0.0, 0.0)
    gnss = made.gnss
    early = FixTable(*(np.concatenate((values[:1], values)) for values in vars(gnss).values()))
    early.time[0] = -500.0
    early.position[0, 0] += 0.01
    early.velocity[0] = 7.0
    values = beginning(replace(made, gnss=early), Start(0.0)).values
    assert values["initial.latitude"] == HOME[0]
    assert values["initial.velocity[1]"] == 0.0


def later(made: Recording, seconds: float) -> Recording:
    """Without the fixes before a time."""
    since = made.gnss.time >= seconds
    return replace(made, gnss=FixTable(*(values[since] for values in vars(made.gnss).values())))


def test_a_start_waits_for_a_first_fix_that_is_late() -> None:
    """Faster and faster from 10 s on: the first fix, at 15 s, does not tell where the vehicle was at 0."""
    made = later(accelerating(0.0, 0.0, 0.0, 2.0), 15.0)
    compass = HeadingTable(np.array([0.5, 15.5]), np.array([1.1, 0.2]), np.array([0.02, 0.02]))
    begun = beginning(replace(made, heading_aid=compass), Start())
    assert begun.time == pytest.approx(15.0)
    assert begun.values["initial.velocity[2]"] == pytest.approx(10.0)
    assert begun.values["initial.heading"] == 0.2
    assert "at 15 s, where the first fix is" in begun.words


def test_a_start_does_not_wait_for_a_fix_that_is_soon_or_not_needed() -> None:
    made = accelerating(0.0, 0.0, 0.0, 2.0)
    assert beginning(later(made, 4.0), Start()).time == 0.0
    assert beginning(later(made, 15.0), Start(position=(40.0, 10.0, 0.0))).time == 0.0


def test_levelling_leaves_out_what_is_not_a_number() -> None:
    made = accelerating(0.1, -0.2, 0.0, 0.0)
    made.imu.delta_velocity[3, 0] = np.nan
    values = beginning(made, Start(0.0)).values
    assert (values["initial.roll"], values["initial.pitch"]) == pytest.approx((0.1, -0.2))
    made.imu.delta_velocity[:100] = np.nan
    with pytest.raises(InputError, match="levelling = 1 s: no sample from 0 s to 1 s has a delta velocity"):
        beginning(made, Start(0.0))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"heading": np.nan}, "heading = nan: must be finite"),
        ({"heading": 0.0, "heading_sigma": -1.0}, "must be at least 0"),
        ({"position": (0.0, np.inf, 0.0)}, "position = .*: must be finite"),
        ({"course_above": 0.0}, "course_above = 0 m/s: must be greater than 0"),
        ({"course_above": 3.0, "heading": 1.0}, "only one can be"),
    ],
)
def test_a_start_that_is_none_is_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Start(**options)


@pytest.mark.parametrize("span", [0.0, -1.0, 0.004])
def test_levelling_covers_a_sample(span: float) -> None:
    with pytest.raises(
        InputError, match=rf"levelling = {span:g} s: must cover at least one sample \(0.01 s\)"
    ):
        beginning(accelerating(0, 0, 0, 0.0), Start(0.0, levelling=span))
