"""Recordings that contradict physics: each fault is injected, and its cause must be what is named."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from town_drive import TownDrive

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import Recording, load
from sim_scenarios.recordings.checks import doubts, refuse
from sim_scenarios.recordings.tables import FixTable, ImuTable
from sim_scenarios.units import DEGREE

GOOD = TownDrive().recording()
CAR = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "car_drive")
PARKED = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "parked_vehicle_rlg.csv.gz")
MOUNTING = "[[-0.98866, -0.092586, 0.118231], [-0.093239, 0.995644, 0], [-0.117716, -0.011024, -0.992986]]"


def imu(**changes: object) -> Recording:
    return replace(GOOD, imu=replace(GOOD.imu, **changes))


def fixes(**changes: object) -> Recording:
    return replace(GOOD, gnss=replace(GOOD.gnss, **changes))


def turned(order: list[int], signs: list[int]) -> Recording:
    return imu(
        delta_angle=GOOD.imu.delta_angle[:, order] * signs,
        delta_velocity=GOOD.imu.delta_velocity[:, order] * signs,
    )


POSITION, VELOCITY = GOOD.gnss.position, GOOD.gnss.velocity
ANGLE, FORCE = GOOD.imu.delta_angle, GOOD.imu.delta_velocity

REFUSED: dict[str, tuple[Callable[[], Recording], str]] = {
    "rates": (lambda: imu(delta_velocity=FORCE * 100), "seems to hold rates, not increments"),
    "milliseconds": (
        lambda: replace(GOOD, gnss=None, imu=replace(GOOD.imu, time=GOOD.imu.time * 1000)),
        "time seems to be in ms",
    ),
    "g": (lambda: imu(delta_velocity=FORCE / 9.80665), r"delta velocities seem to be in g\*s"),
    "counts": (
        lambda: imu(delta_velocity=FORCE * 1e-5),
        "m/s2 in the mean, but an IMU on Earth feels about 9.8",
    ),
    "nothing": (lambda: imu(delta_velocity=FORCE * np.nan), "no sample has a delta velocity"),
    "forward-right-down": (lambda: turned([1, 0, 2], [1, 1, -1]), "points down.*axes = 'forward-right-down'"),
    "degrees": (
        lambda: imu(delta_angle=ANGLE / DEGREE),
        "delta angles seem to be in degrees: the course turns 5.",
    ),
    "radians": (
        lambda: imu(delta_angle=ANGLE * DEGREE),
        "radians read as degrees: the course turns 5. times more",
    ),
    "a gyro the other way round": (lambda: imu(delta_angle=-ANGLE), "turn rates are against the course"),
    "leap seconds late": (lambda: fixes(time=GOOD.gnss.time + 18), r"offset = -18\.0"),
    "leap seconds early": (lambda: fixes(time=GOOD.gnss.time - 18), r"leap seconds.*offset = 18\.0"),
    "five seconds": (
        lambda: fixes(time=GOOD.gnss.time - 5),
        r"course turns 5\.0 s before the IMU.*offset = 5\.0",
    ),
    "north, east, down": (
        lambda: fixes(velocity=VELOCITY[:, [1, 0, 2]] * [1, 1, -1]),
        "if velocities are north, east, down",
    ),
    "velocities down": (
        lambda: fixes(velocity=VELOCITY * [1, 1, -1]),
        "heights fall while vertical velocities",
    ),
    "latitudes in radians": (
        lambda: fixes(position=POSITION * [DEGREE, DEGREE, 1]),
        "if latitudes and longitudes are radians read as degrees",
    ),
    "latitudes in degrees": (
        lambda: fixes(position=POSITION / [DEGREE, DEGREE, 1]),
        "between -90 and 90 deg",
    ),
    "km/h": (lambda: fixes(velocity=VELOCITY * [3.6, 3.6, 1]), "if velocities are km/h read as m/s"),
    "knots": (lambda: fixes(velocity=VELOCITY * [1.944, 1.944, 1]), "if velocities are knots read as m/s"),
    "fixes in ms": (lambda: fixes(velocity=VELOCITY * [1e3, 1e3, 1]), "if time is in ms read as s"),
}


def test_a_good_recording_is_beyond_doubt() -> None:
    refuse(GOOD, Path("x"))
    assert doubts(GOOD) == []


@pytest.mark.parametrize("fault", REFUSED)
def test_what_is_certainly_wrong_is_refused_with_its_cause(fault: str) -> None:
    make, words = REFUSED[fault]
    with pytest.raises(InputError, match=rf"x\.csv: .*{words}"):
        refuse(make(), Path("x.csv"))


def test_turns_that_repeat_tell_no_time() -> None:
    """A zigzag of 14 s: 18 s are as good as 4, so that nothing is said of the clock."""
    time, at = GOOD.imu.time, GOOD.gnss.time
    zigzag = 0.5 * np.sin(2 * np.pi * time / 14)
    angle = np.zeros((len(time), 3))
    angle[:, 2] = -np.diff(zigzag, prepend=0.0)
    heading = 0.5 * np.sin(2 * np.pi * (at - 4) / 14)
    velocity = 8 * np.stack([np.sin(heading), np.cos(heading), 0 * heading], axis=-1)
    nowhere = np.full((len(at), 3), np.nan)
    late = Recording(
        "zigzag",
        replace(GOOD.imu, delta_angle=angle),
        replace(GOOD.gnss, velocity=velocity, position=nowhere),
    )
    refuse(late, Path("x"))


def rolling(lead: float, band: float) -> Recording:
    """A ship at 5 m/s whose antenna is 20 m up a mast: a roll of 8 deg and a yaw of 2 deg every 9 s or so.

    The antenna goes sideways as fast as the ship ahead, so that the course shows the roll; the yaw leads it
    by a phase, in a sea of a relative band.
    """
    time = np.arange(0, 900, 0.02)
    angular = 2 * np.pi / 9 * (1 + band * np.linspace(-2.0, 2.0, 41))
    sizes = np.exp(-(np.linspace(-2.0, 2.0, 41) ** 2) / 2)
    phases = 2 * np.pi * np.arange(41) ** 2 / 41  # of a chirp: waves that come and go

    def wave(ahead: float, order: int = 0) -> np.ndarray:
        waves = np.exp(1j * (np.outer(time, angular) + phases + ahead))
        return np.real(waves @ (sizes * (1j * angular) ** order)) / np.linalg.norm(sizes)

    roll, yaw = 8 * DEGREE * wave(0.0), 2 * DEGREE * wave(lead)
    rolls, yaws = 8 * DEGREE * wave(0.0, 1), 2 * DEGREE * wave(lead, 1)
    angle = 0.02 * np.stack([0 * time, rolls, -yaws], axis=-1)
    force = 0.02 * 9.80665 * np.stack([-np.sin(roll), 0 * time, np.cos(roll)], axis=-1)
    sideways = 20 * rolls
    velocity = np.stack(
        [5 * np.sin(yaw) + sideways * np.cos(yaw), 5 * np.cos(yaw) - sideways * np.sin(yaw), 0 * time],
        axis=-1,
    )[::50]
    zero = np.zeros_like(velocity)
    gnss = FixTable(time[::50], np.full_like(velocity, np.nan), velocity, zero, zero)
    return Recording("ship", ImuTable(time, angle, force), gnss)


@pytest.mark.parametrize("lead", [-90.0, 0.0, 90.0, 180.0])
@pytest.mark.parametrize("band", [0.0, 0.05, 0.25, 0.35])
def test_an_antenna_on_a_mast_turns_no_gyro_round(lead: float, band: float) -> None:
    refuse(rolling(lead * DEGREE, band), Path("x"))


def test_vibration_is_no_wrong_unit() -> None:
    """White, of 15 m/s2 on each axis, as on a drone: the size of a sample is 25 m/s2."""
    shaken = FORCE + 0.01 * np.random.default_rng(1).normal(0, 15, FORCE.shape)
    refuse(imu(delta_velocity=shaken), Path("x"))


def wobbling(unit: float) -> Recording:
    """A ship that rolls by 10 deg every 8 s: no fixes, and a force that says how far it turns."""
    time = 0.01 * np.arange(1, 12_001)
    roll = 10 * DEGREE * np.sin(2 * np.pi * time / 8)
    angle = np.zeros((len(time), 3))
    angle[:, 1] = np.diff(roll, prepend=0.0) * unit
    force = 0.0980665 * np.stack([-np.sin(roll), np.zeros_like(roll), np.cos(roll)], axis=-1)
    return Recording("ship", ImuTable(time, angle, force))


def test_degrees_are_seen_without_fixes() -> None:
    refuse(wobbling(1.0), Path("x"))
    with pytest.raises(InputError, match=r"seem to be in degrees: the specific force turns 5. times less"):
        refuse(wobbling(1 / DEGREE), Path("x"))


DOUBTED = {
    "sideways": (lambda: turned([2, 0, 1], [1, 1, 1]), "points sideways"),
    "forward-left-up": (lambda: turned([1, 0, 2], [1, -1, 1]), "speed is gained along 1.00, "),
    "a scale": (
        lambda: imu(delta_angle=ANGLE * 2),
        "the course turns 0.50 times as far as the delta angles say",
    ),
    "twice and the other way round": (
        lambda: imu(delta_angle=ANGLE * -2),
        "the course turns -0.50 times as far as the delta angles say",
    ),
    "velocities of nobody": (
        lambda: fixes(velocity=VELOCITY[::-1]),
        "positions do not move as the velocities say",
    ),
    "left out": (lambda: replace(GOOD, remarks=("one row left out",)), "one row left out"),
}


@pytest.mark.parametrize("fault", DOUBTED)
def test_what_is_likely_wrong_is_said(fault: str) -> None:
    make, words = DOUBTED[fault]
    assert any(words in doubt for doubt in doubts(make()))
    refuse(make(), Path("x"))


def test_a_parked_vehicle_in_radians_is_doubted() -> None:
    still = FixTable(
        *(np.repeat(part[:1], 50, axis=0) for part in (GOOD.gnss.time, POSITION, 0 * VELOCITY)),
        np.zeros((50, 3)),
        np.zeros((50, 3)),
    )
    still = replace(still, time=np.arange(1.0, 51.0))
    assert doubts(replace(GOOD, gnss=still)) == []
    doubt = doubts(replace(GOOD, gnss=replace(still, position=still.position * DEGREE)))
    assert "are they radians read as degrees?" in doubt[0]


@pytest.mark.skipif(not PARKED.exists(), reason=f"no {PARKED.name} in the folder TRUENORTH_RECORDINGS")
def test_a_real_vehicle_that_stands_is_beyond_doubt() -> None:
    assert doubts(load(PARKED)) == []


def car(folder: Path, clock: str = "gps-day", axes: str = "FRD", angular: str = "deg/s") -> Path:
    path = folder / "car.toml"
    path.write_text(f"""
[imu]
file = "{CAR / "imu.csv.gz"}"
clock = "{clock}"
axes = "{axes}"
mounting = {MOUNTING}
columns.time = "time_gpst_s"
columns.angular = ["gx_dps", "gy_dps", "gz_dps"]
columns.force = ["ax_g", "ay_g", "az_g"]
units = {{ angular = "{angular}", force = "g" }}
[gnss]
file = "{CAR / "gnss.pos.gz"}"
""")
    return path


@pytest.mark.skipif(not CAR.exists(), reason="no car_drive in the folder TRUENORTH_RECORDINGS")
@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"clock": "utc-day"}, "leap seconds"),
        ({"axes": "RFU"}, "points down"),
        ({"angular": "rad/s"}, "delta angles seem to be in degrees: the course turns 5."),
    ],
)
def test_faults_of_a_real_drive_are_named(tmp_path: Path, wrong: dict[str, str], words: str) -> None:
    velocities, imu = doubts(load(car(tmp_path)))  # a receiver that smooths, and a host that stamps late
    assert "gnss: velocities go with the positions of 0.1" in velocities
    assert "s before their stamps; say velocity_offset = -0.1" in velocities
    assert "imu: its samples go with the fixes with offset = -0.0" in imu
    with pytest.raises(InputError, match=words):
        load(car(tmp_path, **wrong))
