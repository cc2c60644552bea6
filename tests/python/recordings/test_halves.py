"""Gyros and accelerometers in two files, each with stamps of its own, are one IMU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from plant_signals import as_table, sensed, told_as_in

import sim_scenarios
from sim_scenarios import Start, toml
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings.checks import doubts
from sim_scenarios.recordings.drafting import draft
from sim_scenarios.recordings.feed import feed
from sim_scenarios.recordings.halves import joined
from sim_scenarios.recordings.readers.contents import Inertial
from sim_scenarios.recordings.stamps import intervals
from sim_scenarios.recordings.tables import Array, Recording
from sim_scenarios.units import DEGREE

SECONDS = 60.0
FIXES = """
[gnss]
file = "gnss.csv"
columns.time = "gnss_time"
columns.position = ["gnss_latitude", "gnss_longitude", "gnss_height"]
columns.velocity = ["gnss_velocity_east", "gnss_velocity_north", "gnss_velocity_up"]
"""
INCREMENTS = f"""
[imu]
file = "gyro.csv"
[accelerometer]
file = "acc.csv"
{FIXES}
"""
RATES = f"""
[imu]
file = "gyro.csv"
axes = "forward-right-down"
columns = {{ time = "t", angular = ["gx", "gy", "gz"] }}
units = {{ angular = "deg/s" }}
[accelerometer]
file = "acc.csv"
columns = {{ time = "t", force = ["ax", "ay", "az"] }}
units = {{ time = "ms", force = "g" }}
{FIXES}
"""


@pytest.fixture(scope="module")
def ship(all_fmus: Fmus) -> Recording:
    return replace(sensed(all_fmus, "swaying_ship", SECONDS), reference=None)


@pytest.fixture(scope="module")
def finely(all_fmus: Fmus) -> Recording:
    """At 200 Hz."""
    settings = {"plant.imu.rate": 200.0, "communication_step": 0.005}
    return sensed(all_fmus, "swaying_ship", SECONDS, settings=settings)


def written(folder: Path, gyros: pd.DataFrame, forces: pd.DataFrame, ship: Recording, toml: str) -> Path:
    fixes = as_table(ship).filter(like="gnss").dropna()
    for name, table in (("gyro", gyros), ("acc", forces), ("gnss", fixes)):
        table.to_csv(folder / f"{name}.csv", index=False, float_format="%.17g")
    path = folder / "recording.toml"
    path.write_text(toml)
    return path


def increments(ship: Recording) -> tuple[pd.DataFrame, pd.DataFrame]:
    table = as_table(ship)
    return table.filter(regex="^time|angle"), table.filter(regex="^time|delta_velocity")


def rates(ship: Recording) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Forward, right, down; deg/s, and g with stamps in ms."""
    time, parts = ship.imu.time, (ship.imu.delta_angle / DEGREE, ship.imu.delta_velocity / 9.80665)
    covers = np.diff(time, prepend=0.0)[:, None]
    turns, forces = (part[:, [1, 0, 2]] * [1, 1, -1] / covers for part in parts)
    return (
        pd.DataFrame(np.column_stack((time, turns)), columns=["t", "gx", "gy", "gz"]),
        pd.DataFrame(np.column_stack((1e3 * time, forces)), columns=["t", "ax", "ay", "az"]),
    )


@pytest.mark.parametrize(
    ("halves", "toml"), [(increments, INCREMENTS), (rates, RATES)], ids=["increments", "rates"]
)
def test_at_the_same_stamps_they_are_as_in_one_file(
    halves, toml: str, ship: Recording, all_fmus: Fmus, tmp_path: Path
) -> None:
    path = written(tmp_path, *halves(ship), ship, toml)
    read = load_recording(path)
    np.testing.assert_array_equal(read.imu.time, ship.imu.time)
    np.testing.assert_allclose(read.imu.delta_angle, ship.imu.delta_angle, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(read.imu.delta_velocity, ship.imu.delta_velocity, rtol=0, atol=1e-11)
    assert not read.remarks
    told = told_as_in("swaying_ship", all_fmus)
    of_one, of_two = (
        sim_scenarios.replay(recording, Start(0.0), set=told, fmus=all_fmus) for recording in (ship, path)
    )
    for name in ("nav.heading", "nav.velocity", "heading_sigma", "nis"):
        np.testing.assert_allclose(of_two[name], of_one[name], rtol=1e-9, atol=1e-9, err_msg=name)


def test_each_has_a_clock_of_its_own(ship: Recording, tmp_path: Path) -> None:
    gyros, forces = increments(ship)
    gyros, forces = gyros.assign(time=gyros.time + 2 * 86400), forces.assign(time=forces.time - 5.0)
    toml = INCREMENTS.replace('"gyro.csv"', '"gyro.csv"\nclock = "gps-week"')
    toml = toml.replace('"acc.csv"', '"acc.csv"\nclock = "gps-day"\noffset = 5.0')
    read = load_recording(written(tmp_path, gyros, forces, ship, f'{toml}clock = "gps-day"'))
    np.testing.assert_array_equal(read.imu.delta_angle, ship.imu.delta_angle)
    # Forces change by less than 1 m/s2 in a second, and stamps of a week are resolved to 3e-11 s.
    np.testing.assert_allclose(read.imu.delta_velocity, ship.imu.delta_velocity, rtol=0, atol=10 * 6e-11)


def test_an_offset_of_the_imu_is_of_both_halves_unless_one_has_its_own(
    ship: Recording, tmp_path: Path
) -> None:
    gyros, forces = (half.assign(time=half.time + 0.3) for half in increments(ship))
    toml = INCREMENTS.replace('"gyro.csv"', '"gyro.csv"\noffset = -0.3')
    read = load_recording(written(tmp_path, gyros, forces, ship, toml))
    np.testing.assert_allclose(read.imu.time, ship.imu.time, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.imu.delta_velocity, ship.imu.delta_velocity, rtol=0, atol=1e-11)
    assert not read.remarks
    own = toml.replace('"acc.csv"', '"acc.csv"\noffset = 0.0')
    read = load_recording(written(tmp_path, gyros, increments(ship)[1], ship, own))
    np.testing.assert_allclose(read.imu.delta_velocity, ship.imu.delta_velocity, rtol=0, atol=1e-11)
    assert not read.remarks


def test_two_topics_of_a_bag_are_one_imu(ship: Recording, tmp_path: Path) -> None:
    """As drivers of cameras publish them, each with zeros in the place of what the other measured."""
    ros = pytest.importorskip("written.ros", reason="reading ROS bags needs rosbags")
    imu, nothing = ship.imu, np.zeros(3)
    turns, forces = (
        part[:, [1, 0, 2]] * [1, -1, 1] / intervals(imu.time)[:, None]
        for part in (imu.delta_angle, imu.delta_velocity)
    )
    gyros = [("/gyro", ros.IMU, ros.inertial(t, w, nothing)) for t, w in zip(imu.time, turns, strict=True)]
    accelerometers = [
        ("/accel", ros.IMU, ros.inertial(t, nothing, f)) for t, f in zip(imu.time, forces, strict=True)
    ]

    def check(path: Path) -> None:
        read = load_recording(path)
        assert len(read.imu.time) == len(imu.time)
        np.testing.assert_allclose(read.imu.delta_angle, imu.delta_angle, rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(read.imu.delta_velocity, imu.delta_velocity, rtol=1e-6, atol=1e-7)

    bag = ros.written(tmp_path, "mcap", gyros + accelerometers)
    check(bag)
    text, _ = draft([bag], tmp_path)
    path = tmp_path / "recording.toml"
    path.write_text(text)
    assert list(toml.read(path)) == ["imu", "accelerometer"]
    check(path)
    apart = [ros.written(tmp_path, "sqlite", gyros), ros.written(tmp_path, "one.bag", accelerometers)]
    path.write_text(draft(apart, tmp_path)[0])
    check(path)
    with pytest.raises(InputError, match=r"sqlite: its angular rates are of an IMU, and there are no spec"):
        draft(apart[:1], tmp_path)
    with pytest.raises(InputError, match=r"one\.bag: its specific forces are of an IMU, and there are no a"):
        draft(apart[1:], tmp_path)
    with pytest.raises(InputError, match="sqlite, imu: has no specific forces; a table accelerometer says"):
        load_recording(apart[0])


IRREGULAR = np.cumsum(np.random.default_rng(1).integers(1, 4, 12_000))


@pytest.mark.parametrize(
    ("of_gyros", "of_forces"),
    [
        (np.arange(1, 12_000, 2), np.arange(2, 12_000, 3)),
        (np.arange(1, 12_000, 3), np.arange(0, 12_000, 2)),
        (np.arange(3, 12_000, 4), np.arange(0, 12_000)),
        (np.arange(0, 12_000), np.arange(3, 12_000, 4)),
        (np.arange(1, 12_000, 2), IRREGULAR[IRREGULAR < 12_000]),
    ],
    ids=["100 and 67 Hz", "67 and 100 Hz", "50 and 200 Hz", "200 and 50 Hz", "100 Hz and irregularly"],
)
def test_nothing_is_lost_between_other_stamps(of_gyros: Array, of_forces: Array, finely: Recording) -> None:
    """Between its knots, n steps apart, a sum leaves its chord by n^2 / 8 of the largest change of a step."""
    imu = finely.imu
    angle, velocity = (np.cumsum(part, axis=0) for part in (imu.delta_angle, imu.delta_velocity))

    def half(rows: Array, of_rows: Array) -> Inertial:
        """Sums over the steps between rows; the first row covers as many steps as most do."""
        before = np.concatenate(([rows[0] - round(np.mean(np.diff(rows)))], rows[:-1]))
        grown = of_rows[rows] - np.where(before[:, None] >= 0, of_rows[before], 0.0)
        nothing = np.full_like(grown, np.nan)
        parts = (grown, nothing) if of_rows is angle else (nothing, grown)
        return Inertial(imu.time[rows], *parts, increments=True)

    gyros, forces = half(of_gyros, angle), half(of_forces, velocity)
    one, remarks = joined(gyros, forces)
    assert len(one.time) >= len(gyros.time) - 4
    assert all("left out" in remark for remark in remarks)
    rows = np.searchsorted(imu.time, one.time)
    np.testing.assert_array_equal(one.angular, gyros.angular[np.isin(gyros.time, one.time)])
    widest = np.max(np.diff(of_forces))
    off_the_chord = widest**2 / 8 * np.max(np.abs(np.diff(imu.delta_velocity, axis=0)))
    truth = velocity[rows]
    np.testing.assert_allclose(one.force[1:], np.diff(truth, axis=0), rtol=0, atol=2 * off_the_chord)
    gained = np.cumsum(one.force[1:], axis=0)
    np.testing.assert_allclose(gained, truth[1:] - truth[0], rtol=0, atol=2 * off_the_chord)


def test_what_one_half_alone_measured_is_left_out_and_told(ship: Recording, tmp_path: Path) -> None:
    """The accelerometers begin a second later, end two seconds earlier, and lose half a second in between."""
    gyros, forces = increments(ship)
    time = forces["time"]
    kept = (time > 1.005) & (time < 58.005) & ~((time > 30.005) & (time < 30.505))
    path = written(tmp_path, gyros, forces[kept], ship, INCREMENTS)
    read = load_recording(path)
    both = kept.to_numpy()
    np.testing.assert_array_equal(read.imu.time, ship.imu.time[both])
    np.testing.assert_allclose(read.imu.delta_velocity, ship.imu.delta_velocity[both], atol=1e-11)
    words = "samples of the gyros were left out: the other half of the IMU was not measured then"
    assert read.remarks == (f"{path}: 350 {words}",)
    assert doubts(read)[0] == read.remarks[0]
    assert feed(read).columns["imu.sample"][-1] == len(read.imu.time) + 50
    swapped = written(tmp_path, gyros[kept], forces, ship, INCREMENTS)
    read = load_recording(swapped)
    np.testing.assert_array_equal(read.imu.time, ship.imu.time[both])
    assert read.remarks == (f"{path}: 300 {words.replace('gyros', 'accelerometers')}",)


def test_that_most_of_a_half_is_left_out_is_told(ship: Recording, tmp_path: Path) -> None:
    gyros, forces = increments(ship)
    read = load_recording(written(tmp_path, gyros[:600], forces, ship, INCREMENTS))
    assert " samples of the accelerometers, 90% of them all, were left out" in read.remarks[0]


def test_halves_that_make_no_imu_are_refused(ship: Recording, tmp_path: Path) -> None:
    gyros, forces = increments(ship)
    path = written(tmp_path, gyros, forces[:1], ship, INCREMENTS)
    with pytest.raises(InputError, match="accelerometer: has 1 samples"):
        load_recording(path)
    written(tmp_path, gyros, forces.assign(time=forces.time + 1e3), ship, INCREMENTS)
    with pytest.raises(InputError, match=r"gyro\.csv.*acc\.csv.*do not overlap"):
        load_recording(path)
    for short, long, cut in ((forces, gyros, "acc"), (gyros, forces, "gyro")):
        for part in (short[1000:1001], short[1000:1004]):
            both = (long, part) if cut == "acc" else (part, long)
            written(tmp_path, *both, ship, INCREMENTS)
            with pytest.raises(InputError, match=rf"^\S*{cut}\.csv, \w+: .* many"):
                load_recording(path)
    twice = INCREMENTS.replace('"gyro.csv"', '"gyro.csv"\ncolumns.force = ["a", "b", "c"]')
    with pytest.raises(
        InputError, match=r"imu\.columns\.force: there is a table accelerometer; say one of both"
    ):
        load_recording(written(tmp_path, gyros, forces, ship, twice))
