"""Recordings from descriptions and from single files: units, axes, rates, stamps, sigmas, refusals."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from town_drive import TownDrive, fix_cells, imu_cells

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import Recording, load
from sim_scenarios.recordings.checks import doubts
from sim_scenarios.units import DEGREE

DRIVE = TownDrive()
WHOLE = DRIVE.recording(60.0)
GNSS = """
[gnss]
file = "gnss.csv"
columns = { time = "time", position = ["lat", "lon", "height"], velocity = ["ve", "vn", "vu"] }
"""


def write(folder: Path, imu: pd.DataFrame, toml: str, gnss: pd.DataFrame | None = None) -> Path:
    imu.to_csv(folder / "imu.csv", index=False, float_format="%.17g")
    if gnss is not None:
        gnss.to_csv(folder / "gnss.csv", index=False, float_format="%.17g")
    path = folder / "recording.toml"
    path.write_text(toml)
    return path


def rates(imu: pd.DataFrame, period: float = 0.01) -> pd.DataFrame:
    """Sensor axes forward, right, down; deg/s and g."""
    angle, force = (imu.filter(like=kind).to_numpy() / period for kind in ("angle", "velocity"))
    turned = [part[:, [1, 0, 2]] * [1, 1, -1] for part in (angle / DEGREE, force / 9.80665)]
    return pd.DataFrame(np.column_stack([imu["time"], *turned]), columns=["t", *"abcdef"])


RATES = """
[imu]
file = "imu.csv"
axes = "forward-right-down"
columns = { time = "t", angular = ["a", "b", "c"], force = ["d", "e", "f"] }
units = { angular = "deg/s", force = "g" }
"""


def test_a_plain_file_is_what_it_holds(tmp_path: Path) -> None:
    cells = imu_cells(WHOLE.imu)
    fixes = fix_cells(WHOLE.gnss).set_axis(
        [
            "time",
            *(f"gnss_{n}" for n in ("latitude", "longitude", "height")),
            *(f"gnss_velocity_{a}" for a in ("east", "north", "up")),
        ],
        axis=1,
    )
    fixes["time"] = cells["time"].to_numpy()[49::50][: len(fixes)]
    path = tmp_path / "town.csv"
    cells.merge(fixes, on="time", how="left").to_csv(path, index=False, float_format="%.17g")
    read = load(path)
    assert read.name == "town"
    for name in ("time", "delta_angle", "delta_velocity"):
        np.testing.assert_array_equal(getattr(read.imu, name), getattr(WHOLE.imu, name))
    np.testing.assert_array_equal(read.gnss.velocity, WHOLE.gnss.velocity)
    np.testing.assert_allclose(read.gnss.position, WHOLE.gnss.position, rtol=1e-15)
    assert doubts(read) == []


def test_rates_of_other_units_and_axes_are_the_same_recording(tmp_path: Path) -> None:
    path = write(
        tmp_path, rates(imu_cells(WHOLE.imu)), f'name = "a drive"\n{RATES}{GNSS}', fix_cells(WHOLE.gnss)
    )
    read = load(path)
    assert read.name == "a drive"
    np.testing.assert_allclose(read.imu.delta_angle, WHOLE.imu.delta_angle, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(read.imu.delta_velocity, WHOLE.imu.delta_velocity, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(read.gnss.position, WHOLE.gnss.position, rtol=1e-15)


def test_a_rate_covers_the_step_before_it_and_one_period_after_a_gap(tmp_path: Path) -> None:
    cells = imu_cells(WHOLE.imu)
    cells["time"] += 0.002 * np.sin(1e4 * cells["time"])
    told = rates(cells)
    lost = np.delete(told.to_numpy(), slice(1000, 1300), axis=0)
    read = load(write(tmp_path, pd.DataFrame(lost, columns=told.columns), RATES))
    steps = np.diff(lost[:, 0])
    z = -lost[:, 6] * 9.80665
    np.testing.assert_allclose(read.imu.delta_velocity[1:, 2][:999], (z[1:] * steps)[:999])
    period = (steps.sum() - steps[999]) / (len(steps) - 1)
    np.testing.assert_allclose(read.imu.delta_velocity[[0, 1000], 2], z[[0, 1000]] * period)
    assert read.imu.time[1000] - read.imu.time[999] > 2.9


def test_a_mounting_leads_into_the_axes(tmp_path: Path) -> None:
    quarter = "mounting = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]\naxes ="
    told = rates(imu_cells(WHOLE.imu))
    sensor = told.copy()
    sensor[["a", "b", "d", "e"]] = np.column_stack([-told["b"], told["a"], -told["e"], told["d"]])
    read = load(write(tmp_path, sensor, RATES.replace("axes =", quarter)))
    np.testing.assert_allclose(read.imu.delta_velocity, WHOLE.imu.delta_velocity, rtol=1e-9, atol=1e-15)


DAY = datetime(2025, 3, 4, tzinfo=timezone.utc)
UNIX = DAY.timestamp()
GPS = UNIX - 315964800 + 18


def iso(t: float) -> str:
    return (DAY + timedelta(seconds=round(t, 6))).isoformat()


CLOCKS: dict[str, tuple[Callable[[float], object], str]] = {
    "GPS": (lambda t: GPS + t, 'clock = "gps"'),
    "Unix": (lambda t: UNIX + t, 'clock = "unix"'),
    "milliseconds": (lambda t: round((UNIX + t) * 1000), 'clock = "unix"\nunits.time = "ms"'),
    "nanoseconds": (lambda t: round(UNIX) * 10**9 + round(t * 1e9), 'clock = "unix"\nunits.time = "ns"'),
    "ISO": (iso, 'clock = "unix"\nunits.time = "iso"'),
    "ISO in GPS time": (lambda t: iso(18 + t), 'clock = "gps"\nunits.time = "iso"'),
    "ISO of nobody's clock": (iso, 'units.time = "iso"'),
    "week": (lambda t: 2 * 86400 + 18 + t, 'clock = "gps-week"'),
    "day": (lambda t: 18 + t, 'clock = "gps-day"'),
    "day of UTC": (lambda t: t, 'clock = "utc-day"'),
    "an offset": (lambda t: t - 7.0, 'clock = "utc-day"\noffset = 7.0'),
}


@pytest.mark.parametrize("clock", CLOCKS)
def test_two_files_with_two_clocks_are_on_one(tmp_path: Path, clock: str) -> None:
    stamp, said = CLOCKS[clock]
    cells, fixes = imu_cells(WHOLE.imu), fix_cells(WHOLE.gnss)
    cells["time"] += GPS
    fixes["time"] = [stamp(t) for t in WHOLE.gnss.time]
    path = write(tmp_path, cells, f'[imu]\nfile = "imu.csv"\nclock = "gps"\n{GNSS}{said}', fixes)
    read = load(path)
    # From midnight of GPS time, 18 s before that of UTC; a double resolves 2e-7 s since 1980.
    np.testing.assert_allclose(read.imu.time, WHOLE.imu.time + 18, atol=2.4e-7)
    np.testing.assert_allclose(read.gnss.time, WHOLE.gnss.time + 18, atol=2.4e-7)


@pytest.mark.parametrize("clock", CLOCKS)
def test_an_imu_has_any_clock(tmp_path: Path, clock: str) -> None:
    stamp, said = CLOCKS[clock]
    cells, fixes = imu_cells(WHOLE.imu), fix_cells(WHOLE.gnss)
    cells["time"] = [stamp(t) for t in WHOLE.imu.time]
    fixes["time"] += GPS
    read = load(
        write(
            tmp_path,
            cells,
            f'[imu]\nfile = "imu.csv"\ncolumns.time = "time"\n{said}\n{GNSS}clock = "gps"',
            fixes,
        )
    )
    np.testing.assert_allclose(read.imu.time, WHOLE.imu.time + 18, atol=2.4e-7)
    np.testing.assert_allclose(read.gnss.time, WHOLE.gnss.time + 18, atol=2.4e-7)


@pytest.mark.parametrize(
    ("clock", "length"), [("gps-week", 604800.0), ("gps-day", 86400.0), ("utc-day", 86400.0)]
)
def test_two_files_go_on_together_where_a_week_or_a_day_begins_again(
    tmp_path: Path, clock: str, length: float
) -> None:
    """The fixes begin in the new one."""
    cells, late = imu_cells(WHOLE.imu), WHOLE.gnss.time >= 30.0
    fixes = fix_cells(WHOLE.gnss)[late]
    cells["time"], fixes["time"] = (
        np.round(length - 20 + table["time"], 6) % length for table in (cells, fixes)
    )
    said = f'clock = "{clock}"'
    read = load(write(tmp_path, cells, f'[imu]\nfile = "imu.csv"\n{said}\n{GNSS}{said}', fixes))
    assert np.all(np.diff(read.imu.time) > 0)
    np.testing.assert_allclose(np.diff(read.imu.time), 0.01, atol=1e-9)
    since = read.gnss.time - read.imu.time[0]
    np.testing.assert_allclose(since, WHOLE.gnss.time[late] - WHOLE.imu.time[0], atol=1e-9)


def test_clocks_that_do_not_meet_are_refused_with_what_would_join_them(tmp_path: Path) -> None:
    cells, fixes = imu_cells(WHOLE.imu), fix_cells(WHOLE.gnss)
    cells["time"] += GPS
    fixes["time"] += UNIX + 86400
    path = write(tmp_path, cells, f'[imu]\nfile = "imu.csv"\nclock = "gps"\n{GNSS}clock = "unix"', fixes)
    with pytest.raises(
        InputError, match=r"imu.csv.*gnss.csv.*do not overlap.*offset = -86400, that is 1 days"
    ):
        load(path)
    path.write_text(f'[imu]\nfile = "imu.csv"\nclock = "gps"\n{GNSS}')
    with pytest.raises(InputError, match=r"gnss.csv, gnss: its stamps .* count from something.*say clock"):
        load(path)


def spoilt(time: np.ndarray, **changes: object) -> tuple[pd.DataFrame, str]:
    cells = imu_cells(DRIVE.imu(0.01 * np.arange(1, 4001)))
    cells["time"] = time
    return cells, '[imu]\nfile = "imu.csv"\n' + "".join(f"{k} = {v!r}\n" for k, v in changes.items())


GRID = 0.01 * np.arange(1, 4001)


def test_rows_that_stand_twice_are_left_out_and_told(tmp_path: Path) -> None:
    cells, said = spoilt(GRID)
    read = load(write(tmp_path, cells.iloc[np.sort(np.r_[np.arange(4000), 100, 200])], said))
    np.testing.assert_array_equal(read.imu.time, GRID)
    assert read.remarks == (f"{tmp_path / 'imu.csv'}: line 103: 2 rows written twice, left out",)
    assert doubts(read)[0] == read.remarks[0]


@pytest.mark.parametrize(
    ("time", "words"),
    [
        (
            np.where(np.arange(4000) == 100, GRID[99], GRID),
            "line 102: time must increase.* from 1 to 1 s.*'steady'",
        ),
        (
            np.where(np.arange(4000) == 100, 0.5, GRID),
            "line 102: time must increase.* from 1 to 0.5 s.*'sorted'",
        ),
        (
            (604790 + GRID) % 604800,
            r"line 1001: time must increase.*seconds of the week, say clock = 'gps-week'",
        ),
        ((86390 + GRID) % 86400, r"line 1001: time must increase.*seconds of the day, say clock = 'gps-day'"),
        (np.where(np.arange(4000) == 100, np.nan, GRID), "line 102: time must be a finite number"),
    ],
)
def test_stamps_that_do_not_increase_are_refused_with_their_line(
    tmp_path: Path, time: np.ndarray, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        load(write(tmp_path, *spoilt(time)))


def test_what_was_asked_for_mends_them(tmp_path: Path) -> None:
    cells, said = spoilt(GRID, stamps="sorted")
    shuffled = cells.iloc[np.random.default_rng(1).permutation(4000)]
    read = load(write(tmp_path, shuffled, said))
    np.testing.assert_array_equal(read.imu.delta_velocity, cells.filter(like="velocity"))
    read = load(write(tmp_path, *spoilt((604790 + GRID) % 604800, clock="gps-week")))
    np.testing.assert_allclose(read.imu.time, 604790 + GRID)
    coarse = np.floor(GRID / 0.016) * 0.016
    read = load(write(tmp_path, *spoilt(coarse, stamps="steady")))
    np.testing.assert_allclose(np.diff(read.imu.time), 0.01, atol=1e-4)
    assert f"moved by up to {np.abs(read.imu.time - coarse).max():.2g} s" in read.remarks[0]


def test_stamps_are_as_they_were_recorded_unless_asked_otherwise(tmp_path: Path) -> None:
    coarse = np.round(GRID * 1.0003, 3)
    np.testing.assert_array_equal(load(write(tmp_path, *spoilt(coarse))).imu.time, coarse)


def test_all_kinds_of_aids_with_their_sigmas(tmp_path: Path) -> None:
    cells, fixes = imu_cells(WHOLE.imu), fix_cells(WHOLE.gnss)
    fixes["speed"], fixes["hdg"], fixes["baro"], fixes["pitch"] = 10.0, 90.0, 500.0, 2.0
    toml = f"""
[imu]
file = "imu.csv"
{GNSS}
lever_arm = [0.1, 0.2, 0.3]
position_sigma = "5 cm"
velocity_sigma = [0.1, 0.2, 0.3]
[body_velocity]
file = "gnss.csv"
columns = {{ velocity = ["", "speed", ""] }}
units = {{ velocity = "km/h" }}
sigma = 0.05
lever_arm = [0.0, -1.0, 0.0]
[heading]
file = "gnss.csv"
columns = {{ heading = "hdg" }}
sigma = "0.5 deg"
[height]
file = "gnss.csv"
columns = {{ height = "baro" }}
units = {{ height = "ft" }}
[reference]
file = "gnss.csv"
columns = {{ attitude = ["", "pitch", "hdg"], velocity = ["ve", "vn", "vu"] }}
"""
    read = load(write(tmp_path, cells, toml, fixes))
    assert isinstance(read, Recording)
    np.testing.assert_array_equal(read.gnss.position_sigma[5], [0.05, 0.05, 0.05])
    np.testing.assert_array_equal(read.gnss.velocity_sigma[5], [0.1, 0.2, 0.3])
    assert read.lever_arms.gnss == (0.1, 0.2, 0.3)
    assert read.lever_arms.body_velocity == (0.0, -1.0, 0.0)
    np.testing.assert_allclose(read.body_velocity.velocity[5], [np.nan, 10 / 3.6, np.nan])
    np.testing.assert_array_equal(read.body_velocity.sigma[5], [0.05, 0.05, 0.05])
    np.testing.assert_allclose(
        [read.heading_aid.heading[0], read.heading_aid.sigma[0]], [np.pi / 2, 0.5 * DEGREE]
    )
    np.testing.assert_allclose(read.height_aid.height, 500 * 0.3048)
    np.testing.assert_array_equal(read.height_aid.sigma, np.zeros(120))
    np.testing.assert_allclose(read.reference.attitude[0], [np.nan, 2 * DEGREE, np.pi / 2])
    np.testing.assert_array_equal(read.reference.position, np.full((120, 3), np.nan))


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ("", "recording.toml: imu: field required"),
        ("[imu]\n", "recording.toml: imu.file: field required"),
        ('[imu]\nfile = "imu.csv"\naxis = "FRD"', "imu.axis: there is no such entry; did you mean 'axes'"),
        (
            '[imu]\nfile = "imu.csv"\ncolumns = { tim = 1 }',
            "imu.columns.tim: there is no such entry; did you mean 'time'",
        ),
        ('[imu]\nfile = "no.csv"', "there is no recording .*no.csv"),
        ('[imu]\nfile = "imu.csv"\nformat = "cvs"', "format = 'cvs': must be one of .*did you mean 'csv'"),
        (
            '[imu]\nfile = "imu.csv"\nformat = "ulog"\ncolumns = { time = 1 }',
            "columns are those of a text file",
        ),
        (
            '[imu]\nfile = "imu.csv"\nunits = { time = "ms" }',
            "recording.toml: imu: units are those of columns: say these too",
        ),
        ('[imu]\nfile = "imu.csv"\naxes = "FRU"', "recording.toml: imu: axes = 'FRU': is left-handed"),
        (
            '[imu]\nfile = "imu.csv"\nmounting = [[1,0,0],[0,1,0],[0,0,1]]',
            "imu: mounting: say into which axes",
        ),
        ('[imu]\nfile = "imu.csv"\nclock = "utc"', "imu.clock: input should be 'gps', 'unix'"),
        ('[imu]\nfile = "imu.csv"\n[gnss]\n', "gnss: there is none in .*imu.csv"),
        (
            '[imu]\nfile = "imu.csv"\n[heading]\nsigma = "1 m"',
            "heading.sigma: '1 m' is not in a unit of this",
        ),
        ('[imu]\nfile = "imu.csv"\n[height]\nsigma = -1', "height.sigma: input should be greater than 0"),
        ('[imu]\nfile = "imu.csv"\n[height]\nsigma = inf', "height.sigma: input should be a finite number"),
        (
            '[imu]\nfile = "imu.csv"\noffset = nan',
            "imu.offset: 'nan': must be a finite number of seconds, or",
        ),
        ('[imu]\nfile = "imu.csv"\noffset = "late"', "imu.offset: 'late': must be a finite number of s"),
        ('[imu]\nfile = "imu.csv"\n[gnss]\nlever_arm = [1, 2]', "gnss.lever_arm: there must be more num"),
        (
            '[imu]\nfile = "imu.csv"\n[gnss]\nlever_arm = [inf, 0, 0]',
            "gnss.lever_arm.0: input should be a fi",
        ),
        (
            '[imu]\nfile = "imu.csv"\ncolumns = {}\nunits = { force = "gees" }',
            "recording.toml: imu.units.force: 'gees' is not in a unit of this quantity: m/s,",
        ),
        (
            '[imu]\nfile = "imu.csv"\ncolumns = {}\nunits = { time = "minutes" }',
            "recording.toml: imu.units.time: 'minutes' is not in a unit of this quantity: s,",
        ),
        ('[imu]\nfile = "."\ncolumns = {}', "it is a folder, and must be a file"),
        ('[imu]\nfile = "."', "is a folder, and no ROS 2 bag"),
        ('[imu]\nfile = "recording.toml"', "is a description; .truenorth replay. takes it"),
    ],
)
def test_what_a_description_cannot_say_is_refused(tmp_path: Path, toml: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load(write(tmp_path, imu_cells(WHOLE.imu), toml))


def test_a_file_without_an_imu_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.pos").write_text(
        "%  GPST latitude(deg) longitude(deg) height(m)\n2025/01/01 00:00:01 40 -7 3\n"
    )
    with pytest.raises(InputError, match=r"x\.pos: has no IMU; `truenorth import`"):
        load(tmp_path / "x.pos")
    (tmp_path / "x.xyz").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match=r"x\.xyz: is in none of the formats rtklib, .* csv"):
        load(tmp_path / "x.xyz")
    with pytest.raises(InputError, match="there is no recording"):
        load(tmp_path / "absent.csv")


def test_what_a_receiver_writes_before_its_first_fix_is_left_out(tmp_path: Path) -> None:
    cells = fix_cells(WHOLE.gnss)
    cells.loc[:4, ["lat", "lon", "height", "ve", "vn", "vu"]] = 0.0
    cells.loc[9, ["lat", "lon"]] = 0.0  # a fix is refused by its residual, not left out
    read = load(write(tmp_path, imu_cells(WHOLE.imu), f'[imu]\nfile = "imu.csv"\n{GNSS}', cells))
    np.testing.assert_array_equal(read.gnss.time, WHOLE.gnss.time[5:])
    [remark] = [remark for remark in read.remarks if "before the first fix" in remark]
    assert remark.startswith(f"{tmp_path / 'gnss.csv'}: latitude 0, longitude 0 before the first fix, 5")


def test_a_vehicle_at_latitude_0_longitude_0_has_its_fixes(tmp_path: Path) -> None:
    cells = fix_cells(WHOLE.gnss)
    cells[["lat", "lon", "ve", "vn", "vu"]] = 0.0
    imu = imu_cells(WHOLE.imu)
    imu.loc[:, imu.columns[1:]] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0978]
    read = load(write(tmp_path, imu, f'[imu]\nfile = "imu.csv"\n{GNSS}', cells))
    assert len(read.gnss.time) == len(WHOLE.gnss.time)


@pytest.mark.parametrize(("clock", "epoch"), [("gps", 16432 * 86400.0), ("gps-day", None)])
def test_the_date_is_kept(tmp_path: Path, clock: str, epoch: float | None) -> None:
    """2025-01-01 is 16432 days after 1980-01-06."""
    said = f'[imu]\nfile = "imu.csv"\nclock = "{clock}"\noffset = {16432 * 86400 + 3600}\n'
    read = load(write(tmp_path, imu_cells(WHOLE.imu), said))
    assert read.epoch == epoch
    if epoch is not None:
        np.testing.assert_allclose(read.imu.time, WHOLE.imu.time + 3600, atol=1e-6)
