"""Text files of cells in all their habits: read alike, or refused with the line and the rule."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from damage import refusals

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import delimited, layouts, plain, sheets
from sim_scenarios.recordings.readers.columns import likely
from sim_scenarios.units import DEGREE

COLUMNS = ["time", *(f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz")]
ROWS = 40


@pytest.fixture
def cells() -> pd.DataFrame:
    rng = np.random.default_rng(3)
    values = 1e-3 * rng.standard_normal((ROWS, 7))
    values[:, 0] = 0.01 * np.arange(1, ROWS + 1)
    values[:, 6] += 0.098
    return pd.DataFrame(values, columns=COLUMNS)


def written(cells: pd.DataFrame, **options: object) -> str:
    return cells.to_csv(index=False, float_format="%.17g", **options)


HABITS = {
    "as we write it": lambda c: written(c),
    "semicolons": lambda c: written(c, sep=";"),
    "semicolons and decimal commas": lambda c: written(c, sep=";", decimal=",").replace(".", ","),
    "tabs": lambda c: written(c, sep="\t"),
    "blanks": lambda c: c.to_string(index=False, float_format=lambda x: f"{x:.17g}"),
    "a blank after the comma": lambda c: written(c).replace(",", ", "),
    "a comment above": lambda c: "# logger 7, firmware 1.2\n#\n" + written(c),
    "comments in between": lambda c: written(c).replace("\n0.02", "\n# a pause\n\n0.02", 1),
    "the header in a comment": lambda c: "# " + written(c),
    "percent signs": lambda c: "% a comment, with commas\n% " + written(c),
    "capitals": lambda c: written(c.rename(columns=str.upper)),
    "quoted names": lambda c: written(c).replace(",".join(COLUMNS), ",".join(f'"{n}"' for n in COLUMNS)),
    "a separator at the end": lambda c: written(c).replace("\n", ",\n"),
    "lines of Windows": lambda c: written(c).replace("\n", "\r\n"),
    "a byte order mark": lambda c: "\ufeff" + written(c),
    "columns in another order, and others": lambda c: written(c.assign(note="ok")[["note", *COLUMNS[::-1]]]),
}


@pytest.mark.parametrize("habit", HABITS.values(), ids=HABITS.keys())
@pytest.mark.parametrize("packed", [False, True])
def test_habits_make_no_difference(cells: pd.DataFrame, tmp_path: Path, habit, packed: bool) -> None:
    text = habit(cells).encode()
    path = tmp_path / ("x.csv.gz" if packed else "x.csv")
    path.write_bytes(gzip.compress(text) if packed else text)
    assert plain.recognises(path)
    imu = plain.read(path).imu
    np.testing.assert_array_equal(imu.time, cells["time"])
    np.testing.assert_array_equal(imu.angular, cells[COLUMNS[1:4]])
    np.testing.assert_array_equal(imu.force, cells[COLUMNS[4:]])
    assert imu.increments


@pytest.mark.parametrize("packed", [False, True])
def test_a_degree_sign_of_windows_is_one(cells: pd.DataFrame, tmp_path: Path, packed: bool) -> None:
    text = written(cells.assign(**{"pitch [°]": 1.5})).replace("\n0.02", "\nx0.02", 1)
    path = tmp_path / ("x.csv.gz" if packed else "x.csv")
    path.write_bytes(gzip.compress(text.encode("cp1252")) if packed else text.encode("cp1252"))
    sheet = sheets.read(path)
    np.testing.assert_array_equal(sheet.numbers("pitch [°]"), np.full(ROWS, 1.5))
    with pytest.raises(InputError, match=r"line 3: column time holds 'x0\.02"):
        sheet.numbers("time")


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_bytes(b"time,a\xb0\n1,2\n\0\xff\n")
    with pytest.raises(InputError, match="cannot be read as a text file"):
        sheets.read(path)


def test_without_a_header_columns_have_numbers(cells: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_text(written(cells, header=False, sep="\t"))
    columns = layouts.ImuColumns(time=1, angular=(2, 3, 4), force=(5, 6, "-7"))
    imu = delimited.imu(sheets.read(path), columns, layouts.ImuUnits()).imu
    np.testing.assert_array_equal(imu.force, cells[COLUMNS[4:]] * [1, 1, -1])
    with pytest.raises(
        InputError, match=r"no column time; there is no header, and its 7 columns are called 1 to 7"
    ):
        plain.read(path)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda lines: [*lines[:9], lines[9].replace("0.08", "abc", 1)], "line 10: column time holds 'abc"),
        (
            lambda lines: ["# one", *lines[:9], "nan" + lines[9][lines[9].index(",") :]],
            "line 11: time must be",
        ),
        (
            lambda lines: [*lines[:5], "", "# two", "inf" + lines[5][lines[5].index(",") :]],
            "line 8: time must be",
        ),
        (lambda lines: [*lines[:5], ",1,2,3,4,5,6"], "line 6: time must be a finite number, and is 'nan'"),
        (lambda lines: [*lines[:5], "1,2,3,4,5,6,7,8,9"], "line 6"),
        (lambda lines: [lines[0].replace("angle_x", "angle_y"), *lines[1:]], "delta_angle_y stands twice"),
        (lambda _: [""], "there is no row of cells"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_line(
    cells: pd.DataFrame, tmp_path: Path, spoil, words: str
) -> None:
    path = tmp_path / "x.csv"
    path.write_text("\n".join(spoil(written(cells).splitlines())))
    with pytest.raises(InputError) as refused:
        plain.read(path)
    assert words in str(refused.value)
    assert str(refused.value).startswith(f"{path}: ")


def test_columns_of_another_name_get_a_hint(cells: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    names = ["time_s", "gyro_x", "gyro_y", "gyro_z", "acc_x", "acc_y", "acc_z"]
    path.write_text(written(cells.set_axis(names, axis=1)))
    with pytest.raises(InputError) as refused:
        plain.read(path)
    sentence = str(refused.value)
    assert "there is no column time; time_s seems to be the time" in sentence
    path.write_text(written(cells.set_axis(["time", *names[1:]], axis=1)))
    with pytest.raises(InputError) as refused:
        plain.read(path)
    sentence = str(refused.value)
    assert "gyro_x, gyro_y, gyro_z seem to be angular rates or delta angles" in sentence
    assert "acc_x, acc_y, acc_z seem to be forces or delta velocities" in sentence
    assert "`truenorth import x.csv`" in sentence


NAMES = [
    ("time_gpst_s,ax_g,ay_g,az_g,gx_dps,gy_dps,gz_dps", "gx_dps gy_dps gz_dps", "ax_g ay_g az_g"),
    ("Time,GyroX,GyroY,GyroZ,AccX,AccY,AccZ", "GyroX GyroY GyroZ", "AccX AccY AccZ"),
    ("t,wx,wy,wz,fx,fy,fz", "wx wy wz", "fx fy fz"),
    (
        "stamp,angular_velocity.x,angular_velocity.y,angular_velocity.z,linear_acceleration.x,linear_acceleration.y,"
        "linear_acceleration.z",
        "angular_velocity.x angular_velocity.y angular_velocity.z",
        "linear_acceleration.x linear_acceleration.y linear_acceleration.z",
    ),
    (
        "tow,dtheta_x,dtheta_y,dtheta_z,dvel_x,dvel_y,dvel_z",
        "dtheta_x dtheta_y dtheta_z",
        "dvel_x dvel_y dvel_z",
    ),
    (
        "SystemTov,DeltaTheta[0],DeltaTheta[1],DeltaTheta[2],DeltaVelocity[0],DeltaVelocity[1],DeltaVelocity[2]",
        "DeltaTheta[0] DeltaTheta[1] DeltaTheta[2]",
        "DeltaVelocity[0] DeltaVelocity[1] DeltaVelocity[2]",
    ),
    ("gpsTow,accX,accY,accZ,gyroX,gyroY,gyroZ", "gyroX gyroY gyroZ", "accX accY accZ"),
]


@pytest.mark.parametrize(("header", "angular", "force"), NAMES)
def test_names_of_loggers_are_understood(header: str, angular: str, force: str) -> None:
    found = likely(header.split(","))
    assert found["time"] == (header.split(",")[0],)
    assert found["angular"] == tuple(angular.split())
    assert found["force"] == tuple(force.split())


def test_a_velocity_down_is_turned() -> None:
    assert likely(["t", "lat", "lon", "alt", "vel_n", "vel_e", "vel_d"])["velocity"] == (
        "vel_e",
        "vel_n",
        "-vel_d",
    )


FIXES = [  # as an integrated unit, an autopilot and a receiver write them
    (
        "SystemTov,GpsTov,GnssLatitude,GnssLongitude,GnssAltitudeAboveEllipsoid,GnssVelocityN,GnssVelocityE,GnssVelocityD,"
        "GnssStdvLat,GnssStdvLon,GnssStdvAlt,GnssStdvN,GnssStdvE,GnssStdvD",
        {
            "time": "SystemTov",
            "position": "GnssLatitude GnssLongitude GnssAltitudeAboveEllipsoid",
            "velocity": "GnssVelocityE GnssVelocityN -GnssVelocityD",
            "position_sigma": "GnssStdvLon GnssStdvLat GnssStdvAlt",
            "velocity_sigma": "GnssStdvE GnssStdvN GnssStdvD",
        },
    ),
    (
        "timestamp,lat,lon,alt,VelocityNED[0],VelocityNED[1],VelocityNED[2],VelocityStdvNED[0],VelocityStdvNED[1],"
        "VelocityStdvNED[2]",
        {
            "time": "timestamp",
            "velocity": "VelocityNED[1] VelocityNED[0] -VelocityNED[2]",
            "velocity_sigma": "VelocityStdvNED[1] VelocityStdvNED[0] VelocityStdvNED[2]",
        },
    ),
    (
        "time,latitude,longitude,height,sdn,sde,sdu,vn,ve,vu,sdvn,sdve,sdvu",
        {"position_sigma": "sde sdn sdu", "velocity_sigma": "sdve sdvn sdvu", "velocity": "ve vn vu"},
    ),
]


@pytest.mark.parametrize(("header", "expected"), FIXES)
def test_names_of_fixes_are_understood(header: str, expected: dict[str, str]) -> None:
    found = likely(header.split(","))
    assert {key: found[key] for key in expected} == {
        key: tuple(names.split()) for key, names in expected.items()
    }


@pytest.mark.parametrize(
    "header", ["SystemTov,EulerAttitude[0],EulerAttitude[1],EulerAttitude[2]", "t,rpy_1,rpy_2,rpy_3"]
)
def test_an_attitude_may_be_counted(header: str) -> None:
    assert likely(header.split(","))["attitude"] == tuple(header.split(",")[1:])


@pytest.mark.parametrize("header", ["t,w1,w2,w3,a1,a2,a3", "t,acc_0,acc_1,gyro_0,gyro_1"])
def test_numbers_alone_are_no_axes(header: str) -> None:
    """Speeds of wheels, channels of a logger, two of three axes."""
    assert likely(header.split(",")).keys() == {"time"}


UNITS = [
    ("deg/s", "g", DEGREE, 9.80665, False),
    ("rad/s", "m/s2", 1.0, 1.0, False),
    ("0.061 deg/s", "0.488 mg", 0.061 * DEGREE, 0.488e-3 * 9.80665, False),
    ("deg", "g*s", DEGREE, 9.80665, True),
    ("arcsec", "mm/s", DEGREE / 3600, 1e-3, True),
]


@pytest.mark.parametrize(("angular", "force", "rad", "metres", "increments"), UNITS)
def test_units_decide_between_rates_and_increments(
    cells: pd.DataFrame, tmp_path: Path, angular: str, force: str, rad: float, metres: float, increments: bool
) -> None:
    path = tmp_path / "x.csv"
    path.write_text(written(cells))
    units = layouts.ImuUnits(angular=angular, force=force)
    imu = delimited.imu(sheets.read(path), layouts.ImuColumns(), units).imu
    assert imu.increments == increments
    np.testing.assert_allclose(imu.angular, cells[COLUMNS[1:4]] * rad, rtol=1e-14)
    np.testing.assert_allclose(imu.force, cells[COLUMNS[4:]] * metres, rtol=1e-14)


@pytest.mark.parametrize(
    ("angular", "force", "words"),
    [
        ("deg/s", "m/s", "deg/s and m/s do not go together"),
        ("rad", "g", "rad and g do not go together"),
    ],
)
def test_units_that_contradict_each_other_are_refused(
    cells: pd.DataFrame, tmp_path: Path, angular: str, force: str, words: str
) -> None:
    path = tmp_path / "x.csv"
    path.write_text(written(cells))
    with pytest.raises(InputError, match=words):
        delimited.imu(sheets.read(path), layouts.ImuColumns(), layouts.ImuUnits(angular=angular, force=force))


@pytest.mark.parametrize(
    ("angular", "force", "words"),
    [
        ("degrees", "g", "'degrees' is not in a unit of this quantity: rad, mrad, deg"),
        ("rad", "0 m/s", "must be finite and not 0"),
        ("rad", "m", "'m' is not in a unit of this quantity: m/s"),
    ],
)
def test_what_is_no_unit_is_refused_before_a_file_is_read(angular: str, force: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        layouts.ImuUnits(angular=angular, force=force)


STAMPS = {
    "s": (lambda t: [f"{x:.6f}" for x in t], 0.0),
    "ms": (lambda t: [f"{1000 * x:.3f}" for x in t], 0.0),
    "ns": (lambda t: [str(1_735_760_058_000_000_000 + round(x * 1e9)) for x in t], 1_735_760_058.0),
    "iso": (lambda t: [f"2025-01-01T19:34:{18 + x:09.6f}Z" for x in t], 1_735_760_058.0),
    "h:m:s": (lambda t: [f"19:34:{18 + x:09.6f}" for x in t], 19 * 3600 + 34 * 60 + 18.0),
}


@pytest.mark.parametrize("unit", STAMPS)
def test_stamps_are_read_to_the_nanosecond(cells: pd.DataFrame, tmp_path: Path, unit: str) -> None:
    """That of a double at seconds since 1970 is 240."""
    path = tmp_path / "x.csv"
    write, begin = STAMPS[unit]
    written_stamps = cells.assign(time=write(cells["time"]))
    path.write_text(written(written_stamps))
    read = delimited.imu(sheets.read(path), layouts.ImuColumns(), layouts.ImuUnits(time=unit))
    whole = np.round(read.epoch - begin) + read.imu.time
    np.testing.assert_allclose(whole, cells["time"], atol=2e-11 if unit == "h:m:s" else 1e-11)


def test_date_and_time_may_stand_in_two_columns(cells: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text(written(cells.assign(date="2025/01/01", time=STAMPS["h:m:s"][0](cells["time"]))))
    columns = layouts.ImuColumns(time=("date", "time"))
    read = delimited.imu(sheets.read(path), columns, layouts.ImuUnits(time="iso"))
    np.testing.assert_allclose(read.epoch + read.imu.time - 1_735_760_058, cells["time"], atol=1e-6)


def test_a_stamp_that_is_no_date_is_refused_with_its_line(cells: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    stamps = STAMPS["iso"][0](cells["time"])
    stamps[7] = "2025-13-01T00:00:00"
    path.write_text(written(cells.assign(time=stamps)))
    with pytest.raises(
        InputError, match=r"line 9: time must be such as 2025-01-01T19:34:18\.499, and is '2025-13"
    ):
        delimited.imu(sheets.read(path), layouts.ImuColumns(), layouts.ImuUnits(time="iso"))


def test_aids_of_the_plain_form_have_their_own_rows(cells: pd.DataFrame, tmp_path: Path) -> None:
    cells["gnss_velocity_east"] = np.where(np.arange(ROWS) % 10 == 4, 1.5, np.nan)
    cells["gnss_latitude"] = np.where(np.arange(ROWS) % 20 == 4, 45.0, np.nan)
    cells["gnss_time"] = cells["time"] - 0.004
    cells["body_velocity_forward"] = np.where(np.arange(ROWS) % 5 == 0, 2.0, np.nan)
    cells["heading_aid"] = np.where(np.arange(ROWS) == 7, 90.0, np.nan)
    cells["heading_aid_sigma"] = 2.0
    cells["height_aid"] = np.where(np.arange(ROWS) == 9, 12.0, np.nan)
    path = tmp_path / "x.csv"
    path.write_text(written(cells))
    read = plain.read(path)
    np.testing.assert_allclose(read.gnss.time, cells["time"][4::10] - 0.004)
    np.testing.assert_array_equal(read.gnss.velocity, [[1.5, np.nan, np.nan]] * 4)
    np.testing.assert_allclose(read.gnss.position[:, 0], [np.pi / 4, np.nan] * 2)
    np.testing.assert_array_equal(read.gnss.position_sigma, np.zeros((4, 3)))
    np.testing.assert_array_equal(read.body_velocity.velocity[:, 1], np.full(8, 2.0))
    assert (read.heading_aid.heading[0], read.heading_aid.sigma[0]) == pytest.approx((np.pi / 2, 2 * DEGREE))
    assert (read.height_aid.time[0], read.height_aid.height[0]) == (cells["time"][9], 12.0)
    assert read.place("gnss", 1) == "line 16"
    assert read.reference is None


@pytest.mark.parametrize("begin", [0.0, 1_735_760_058.0])
def test_aids_have_the_clock_of_the_imu(cells: pd.DataFrame, tmp_path: Path, begin: float) -> None:
    """Also where a fix has a time of its own, which is empty in most rows."""
    cells["time"] += begin
    cells["gnss_velocity_east"] = np.where(np.arange(ROWS) % 10 == 4, 1.5, np.nan)
    cells["heading_aid"] = cells["gnss_velocity_east"]
    cells["gnss_time"] = cells["time"].where(cells["heading_aid"].notna()) - 2.0
    path = tmp_path / "x.csv"
    path.write_text(written(cells))
    read = plain.read(path)
    np.testing.assert_array_equal(read.epoch + read.imu.time, cells["time"])
    np.testing.assert_array_equal(read.epoch + read.gnss.time, cells["time"][4::10] - 2.0)
    np.testing.assert_array_equal(read.epoch + read.heading_aid.time, cells["time"][4::10])


def test_fixes_that_are_held_count_once(cells: pd.DataFrame, tmp_path: Path) -> None:
    cells["gnss_velocity_east"] = 1.0 + np.arange(ROWS) // 10
    path = tmp_path / "x.csv"
    path.write_text(written(cells))
    read = plain.read(path)
    np.testing.assert_array_equal(read.gnss.velocity[:, 0], [1, 2, 3, 4])
    np.testing.assert_array_equal(read.gnss.time, cells["time"][::10])
    assert "4 of 40 are new" in read.remarks[0]


@pytest.mark.parametrize("packed", [False, True])
def test_damaged_files(cells: pd.DataFrame, tmp_path: Path, packed: bool) -> None:
    cells["gnss_velocity_east"] = np.where(np.arange(ROWS) % 10 == 4, 1.5, np.nan)
    text = written(cells[:15]).encode()
    path = tmp_path / ("x.csv.gz" if packed else "x.csv")
    path.write_bytes(gzip.compress(text) if packed else text)
    assert len(refusals(plain.read, path)) > 50
