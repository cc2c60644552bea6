"""Stamps that are late, injected into a drive in closed form: found within their sigmas, and only there."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from town_drive import TownDrive, fix_cells, imu_cells

from sim_scenarios import toml
from sim_scenarios.earth import displaced
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import fixes, load
from sim_scenarios.recordings.drafting import draft
from sim_scenarios.recordings.simultaneity import of_imu, of_velocities
from sim_scenarios.recordings.tables import Array, FixTable, ImuTable

DRIVE = TownDrive()
ORIGIN = (0.0, 0.0, 0.0)
SECONDS = 300.0
LATE = 0.128
"""Seconds by which a receiver's velocities are late."""


def received(seed: int, late: float = 0.0, rate: float = 4.0, ahead: float = 0.0) -> FixTable:
    """Fixes of an antenna ahead of the IMU, of 1 cm and 4 cm/s, with late velocities."""
    random = np.random.default_rng(seed)
    time = np.arange(1.0, SECONDS, 1 / rate)
    fixes_ = DRIVE.fixes(time)
    heading, turn = DRIVE.heading(time), DRIVE.turn(time)
    arm = ahead * np.stack([np.sin(heading), np.cos(heading), 0 * heading], axis=-1)
    swing = ahead * turn[:, None] * np.stack([np.cos(heading), -np.sin(heading), 0 * heading], axis=-1)
    velocity = DRIVE.velocity(time - late) + swing + 0.04 * random.standard_normal((len(time), 3))
    moved = [
        displaced(p, d + 0.01 * random.standard_normal(3)) for p, d in zip(fixes_.position, arm, strict=True)
    ]
    return replace(fixes_, position=np.array(moved), velocity=velocity)


BENCH = (6.6e-5, 1.4e-3)
"""White noise of a MEMS IMU on its bench [rad/s^0.5], [m/s^1.5]."""
ROAD = (1e-3, 2e-2)
"""What vibration makes of it."""


def sensed(seed: int, noise: tuple[float, float] = BENCH) -> ImuTable:
    """Increments of a MEMS IMU with biases."""
    random = np.random.default_rng(seed)
    imu = DRIVE.imu(0.01 * np.arange(1, round(100 * SECONDS) + 1))
    white: Array = 0.1 * random.standard_normal((2, *imu.delta_angle.shape))
    return replace(
        imu,
        delta_angle=imu.delta_angle + 0.01 * np.array([2e-3, -1e-3, 3e-3]) + noise[0] * white[0],
        delta_velocity=imu.delta_velocity + 0.01 * np.array([0.1, -0.05, 0.1]) + noise[1] * white[1],
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_of_a_road_is_taken_for_no_lag(seed: int) -> None:
    lag = of_imu(sensed(seed, ROAD), received(seed, rate=2.0), ORIGIN)
    assert lag is None or not lag.is_certain


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("late", [0.0, LATE, -0.05])
def test_late_velocities_are_found(late: float, seed: int) -> None:
    lag = of_velocities(received(seed, late))
    assert lag is not None
    assert abs(lag.value + late) < 4 * lag.sigma
    assert lag.sigma < 0.003
    assert lag.is_certain == (late != 0)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("late", [0.0, 0.15, -0.2])
def test_an_imu_that_is_stamped_late_is_found(late: float, seed: int) -> None:
    imu = sensed(seed)
    lag = of_imu(replace(imu, time=imu.time + late), received(seed, rate=2.0), ORIGIN)
    assert lag is not None
    assert abs(lag.value + late) < 4 * lag.sigma
    assert lag.is_certain == (late != 0)


@pytest.mark.parametrize("seed", range(1, 9))
@pytest.mark.parametrize(("rate", "sigma"), [(1.0, 0.1), (5.0, 0.03), (10.0, 0.02)])
def test_noise_of_a_vehicle_that_stands_shows_no_lag(rate: float, sigma: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    imu, gnss = sensed(seed), received(seed, rate=rate)
    still = replace(
        imu,
        delta_angle=1e-5 * random.standard_normal(imu.delta_angle.shape),
        delta_velocity=np.array([0.0, 0.0, 0.098]) + 1e-4 * random.standard_normal(imu.delta_angle.shape),
    )
    standing = replace(
        gnss,
        position=gnss.position[:1]
        + np.array([1e-9, 1e-9, 0.01]) * random.standard_normal(gnss.position.shape),
        velocity=sigma * random.standard_normal(gnss.velocity.shape),
    )
    for lag in (of_velocities(standing), of_imu(still, standing, ORIGIN)):
        assert lag is None or not lag.is_certain


@pytest.mark.parametrize("seed", [1, 2])
def test_velocities_without_a_vertical_one_are_found_late_too(seed: int) -> None:
    """As those of NMEA are."""
    gnss = received(seed, LATE)
    level = replace(gnss, velocity=gnss.velocity * np.array([1.0, 1.0, np.nan]))
    lag = of_velocities(level)
    assert lag is not None
    assert lag.is_certain
    assert abs(lag.value + LATE) < 4 * lag.sigma


def test_stamps_that_do_not_increase_show_nothing() -> None:
    imu, gnss = sensed(1), received(1, LATE)
    time = gnss.time.copy()
    time[5] = time[4]
    assert of_velocities(replace(gnss, time=time)) is None
    assert of_imu(imu, replace(gnss, time=time), ORIGIN) is None


def test_velocities_of_every_other_fix_are_moved() -> None:
    gnss = received(1, LATE)
    velocity = gnss.velocity.copy()
    velocity[1::2] = np.nan
    moved = fixes.with_velocities_later(replace(gnss, velocity=velocity), -LATE)
    assert np.isfinite(moved.velocity[2:-2]).all()
    np.testing.assert_allclose(moved.velocity[2:-2], DRIVE.velocity(gnss.time[2:-2]), atol=0.6)


def test_a_lever_arm_is_no_lag() -> None:
    imu, gnss = sensed(1), received(1, ahead=1.5)
    known, unknown = of_imu(imu, gnss, (0.0, 1.5, 0.0)), of_imu(imu, gnss, ORIGIN)
    assert known is not None
    assert unknown is not None
    assert not known.is_certain
    assert abs(unknown.value - known.value) > 0.03  # and so the lever arm has to be told


def test_axes_of_the_imu_do_not_matter() -> None:
    imu, gnss = sensed(1), received(1)
    turned = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    turned *= np.linalg.det(turned)
    elsewhere = ImuTable(imu.time, imu.delta_angle @ turned.T, imu.delta_velocity @ turned.T)
    one, other = (of_imu(replace(i, time=i.time + 0.05), gnss, ORIGIN) for i in (imu, elsewhere))
    assert one is not None
    assert other is not None
    assert other.value == pytest.approx(one.value, abs=1e-4)


def test_what_stands_or_is_short_tells_nothing() -> None:
    imu, gnss = sensed(1), received(1, LATE)
    still = replace(
        gnss, velocity=0 * gnss.velocity, position=np.repeat(gnss.position[:1], len(gnss.time), 0)
    )
    assert of_velocities(still) is None
    assert of_imu(imu, still, ORIGIN) is None
    few = fixes.selected(gnss, gnss.time < 40.0)
    assert of_velocities(few) is None
    assert of_imu(imu, few, ORIGIN) is None


def test_velocities_are_moved_to_when_they_held_but_not_across_a_gap() -> None:
    time = np.array([0.0, 0.25, 0.5, 2.0, 2.25, 2.5])
    velocity = np.stack([2 * time, 1 - time, 0 * time], axis=-1)
    nothing = np.zeros((6, 3))
    gnss = FixTable(time, nothing, velocity, nothing, nothing)
    moved = fixes.with_velocities_later(gnss, -0.1).velocity
    expected = np.stack([2 * (time + 0.1), 1 - (time + 0.1), 0 * time], axis=-1)
    expected[[2, 5]] = np.nan
    np.testing.assert_allclose(moved, expected, atol=1e-12)


def described(folder: Path, late: float, offset: str) -> Path:
    imu = sensed(1)
    imu_cells(replace(imu, time=imu.time + late)).to_csv(folder / "imu.csv", index=False)
    fix_cells(received(1, LATE)).to_csv(folder / "gnss.csv", index=False)
    path = folder / "recording.toml"
    path.write_text(f"""
[imu]
file = "imu.csv"
axes = "right-forward-up"
{offset}
columns.time = "time"
columns.angular = ["delta_angle_x", "delta_angle_y", "delta_angle_z"]
columns.force = ["delta_velocity_x", "delta_velocity_y", "delta_velocity_z"]
units = {{ angular = "rad", force = "m/s" }}
[gnss]
file = "gnss.csv"
velocity_offset = {-LATE}
columns = {{ time = "time", position = ["lat", "lon", "height"], velocity = ["ve", "vn", "vu"] }}
""")
    return path


def test_an_offset_is_found_when_it_is_asked_for_and_else_said(tmp_path: Path) -> None:
    found = load(described(tmp_path, 0.15, 'offset = "found"'))
    assert found.imu.time[0] == pytest.approx(0.01, abs=0.06)
    assert any("the stamps of imu were moved by -0.1" in remark for remark in found.remarks)
    np.testing.assert_allclose(found.gnss.velocity[8:12], DRIVE.velocity(found.gnss.time[8:12]), atol=0.2)
    said = load(described(tmp_path, 0.15, ""))
    assert said.imu.time[0] == pytest.approx(0.16, abs=1e-9)
    assert any("go with the fixes with offset = -0.1" in remark for remark in said.remarks)
    (nothing,) = load(described(tmp_path, 0.0, 'offset = "found"')).remarks
    assert nothing.endswith("stamps stay")
    more = load(described(tmp_path, 0.15, "offset = -0.05"))
    assert any("go with the fixes with offset = -0.1" in remark for remark in more.remarks)


def in_halves(described: Path, offset: str = "") -> Path:
    """The same with a table of its own for the forces."""
    columns = 'columns.force = ["delta_velocity_x", "delta_velocity_y", "delta_velocity_z"]\n'
    table = f'[accelerometer]\nfile = "imu.csv"\n{offset}\ncolumns.time = "time"\n{columns}'
    described.write_text(described.read_text().replace(columns, "") + f'{table}units.force = "m/s"\n')
    return described


def test_the_offset_that_is_told_of_an_imu_in_halves_moves_both(tmp_path: Path) -> None:
    (told,) = load(in_halves(described(tmp_path, 0.15, ""))).remarks
    offset = re.search(r"go with the fixes with (offset = -0\.1\d+) \(sigma", told)[1]
    said = load(in_halves(described(tmp_path, 0.15, offset)))
    assert not said.remarks
    whole = load(described(tmp_path, 0.15, offset))
    np.testing.assert_allclose(said.imu.time, whole.imu.time, rtol=0, atol=1e-9)
    np.testing.assert_allclose(said.imu.delta_velocity, whole.imu.delta_velocity, rtol=0, atol=1e-9)


def test_what_is_told_of_an_imu_in_halves_names_the_offset_that_each_has(tmp_path: Path) -> None:
    remarks = load(in_halves(described(tmp_path, 0.15, "offset = -0.05"), "offset = -0.04")).remarks
    offset = r"offset = (-0\.\d+)"
    of_gyros, of_forces = re.search(
        f"go with the fixes with {offset} and its accelerometers with {offset}", str(remarks)
    ).groups()
    assert float(of_forces) - float(of_gyros) == pytest.approx(0.01, abs=1e-9)
    said = load(in_halves(described(tmp_path, 0.15, f"offset = {of_gyros}"), f"offset = {of_forces}"))
    assert "go with" not in str(said.remarks)


def test_an_offset_is_found_of_imu_and_fixes_alone(tmp_path: Path) -> None:
    path = described(tmp_path, 0.0, "")
    log = 'columns = { time = "time", velocity = ["", "ve", ""] }'
    path.write_text(f'{path.read_text()}[body_velocity]\nfile = "gnss.csv"\noffset = "found"\n{log}\n')
    with pytest.raises(InputError, match="offset = 'found': it is found of the IMU or of the fixes alone"):
        load(path)


def test_a_draft_says_both(tmp_path: Path) -> None:
    described(tmp_path, 0.15, "")
    text, _ = draft([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    (tmp_path / "draft.toml").write_text(text)
    told = toml.read(tmp_path / "draft.toml")
    assert told["imu"]["offset"] == "found"
    assert told["gnss"]["velocity_offset"] == pytest.approx(-LATE, abs=0.01)
    described(tmp_path, 0.0, "")
    text, _ = draft([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    assert 'offset = "found"' not in text
