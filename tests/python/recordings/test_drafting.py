"""Drafts of descriptions: whatever the habits of a logger, what is drafted reads back as what was driven."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from town_drive import TownDrive, fix_cells, imu_cells
from typer.testing import CliRunner, Result

from sim_scenarios import toml
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import load
from sim_scenarios.recordings.checks import doubts
from sim_scenarios.recordings.drafting import draft
from sim_scenarios.recordings.stamps import intervals
from sim_scenarios.units import DEGREE

CAR = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "car_drive")
WHOLE = TownDrive().recording(120.0)
UNIX = 1_741_046_400.0  # 2025-03-04
G = 9.80665


def drafted(folder: Path, *files: Path) -> tuple[Path, dict[str, dict[str, object]]]:
    path = folder / "recording.toml"
    text, guesses = draft(files, folder)
    path.write_text(text)
    assert len(guesses) == sum(line.startswith("# ") for line in text.splitlines()) - 4  # title and mounting
    return path, toml.read(path)


def sensor(
    matrix: np.ndarray, angle: float, force: float, names: list[str], period: float = 0.01
) -> pd.DataFrame:
    """IMU in other axes and units; a period of 1 leaves increments."""
    cells = imu_cells(WHOLE.imu)
    parts = [cells.filter(like="angle") / period / angle, cells.filter(like="velocity") / period / force]
    values = np.hstack([part.to_numpy() @ np.array(matrix).T for part in parts])
    return pd.DataFrame(np.column_stack([cells["time"], values]), columns=names)


FLU = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
FRD = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
BRU = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
UFL = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])


def named(angular: str, force: str, unit: str = "") -> list[str]:
    return ["time", *(f"{angular}{axis}{unit}" for axis in "xyz"), *(f"{force}{axis}" for axis in "xyz")]


GYRO = named("gyro_", "acc_")
LOGGERS = {
    "deg/s and g by name": (FLU, DEGREE, G, named("g", "a", "_dps"), 0.01),
    "rad/s and m/s2, down": (FRD, 1.0, 1.0, GYRO, 0.01),
    "mg, backward": (BRU, DEGREE, 1e-3 * G, named("Gyro", "Acc", " (deg/s)"), 0.01),
    "increments, first axis up": (UFL, 1.0, 1.0, named("dtheta_", "dv_", "_rad"), 1.0),
    "increments in deg and g*s": (FLU, DEGREE, G, named("delta_angle_", "delta_v_", "_deg"), 1.0),
}
EXPECTED = {
    "deg/s and g by name": ("forward-left-up", "deg/s", "g"),
    "rad/s and m/s2, down": ("forward-right-down", "rad/s", "m/s2"),
    "mg, backward": ("backward-right-up", "deg/s", "mg"),
    "increments, first axis up": ("up-forward-left", "rad", "m/s"),
    "increments in deg and g*s": ("forward-left-up", "deg", "g*s"),
}


@pytest.mark.parametrize("logger", LOGGERS)
def test_a_drive_in_two_files_reads_back(tmp_path: Path, logger: str) -> None:
    """With stamps in milliseconds of a day beside seconds since 1970."""
    matrix, angle, force, names, period = LOGGERS[logger]
    cells = sensor(matrix, angle, force, names, period)
    cells[names[0]] = np.round((3600 + WHOLE.imu.time) * 1000).astype(int)
    cells.to_csv(tmp_path / "imu.csv", index=False, sep=";")
    fixes = fix_cells(WHOLE.gnss)
    fixes["time"] += UNIX + 3600
    fixes.rename(columns={"time": "unix_time"}).to_csv(
        tmp_path / "gnss.csv", index=False, float_format="%.12f"
    )
    path, said = drafted(tmp_path, tmp_path / "gnss.csv", tmp_path / "imu.csv")
    axes, angular, force_unit = EXPECTED[logger]
    assert said["imu"]["axes"] == axes
    assert said["imu"]["units"] == {"time": "ms", "angular": angular, "force": force_unit}
    assert said["imu"]["clock"] == "utc-day"
    assert said["gnss"]["clock"] == "unix"
    read = load(path)
    assert doubts(read) == []
    np.testing.assert_allclose(read.imu.time, WHOLE.imu.time + 3618, atol=1e-9)
    np.testing.assert_allclose(read.gnss.time, WHOLE.gnss.time + 3618, atol=1e-6)
    np.testing.assert_allclose(read.imu.delta_angle, WHOLE.imu.delta_angle, atol=1e-12)
    np.testing.assert_allclose(read.imu.delta_velocity, WHOLE.imu.delta_velocity, atol=1e-10)


def test_degrees_are_told_from_radians_without_a_name(tmp_path: Path) -> None:
    """By the speed of the turns: 20 deg/s are ordinary, 20 rad/s are not."""
    for unit, si in (("deg/s", DEGREE), ("rad/s", 1.0)):
        sensor(FLU, si, 1.0, GYRO).to_csv(tmp_path / "imu.csv", index=False)
        fix_cells(WHOLE.gnss).to_csv(tmp_path / "gnss.csv", index=False, float_format="%.12f")
        path, said = drafted(tmp_path, tmp_path / "imu.csv", tmp_path / "gnss.csv")
        assert said["imu"]["units"]["angular"] == unit
        assert doubts(load(path)) == []


@pytest.mark.parametrize(("unit", "si"), [("deg/s", DEGREE), ("rad/s", 1.0)])
@pytest.mark.parametrize("times", [0.02, 1.0, 3.0])
def test_degrees_are_told_from_radians_by_the_course(
    tmp_path: Path, unit: str, si: float, times: float
) -> None:
    """Where tilts tell nothing and the size something else, as of a drone that turns all the time."""
    cells = sensor(FLU, si, 1.0, GYRO)
    rates = ["gyro_x", "gyro_y", "gyro_z"]
    cells[["gyro_x", "gyro_y"]] += np.random.default_rng(1).normal(0, times / si, (len(cells), 2))
    cells[["acc_x", "acc_y"]] = 0.0
    cells["acc_z"] = G
    assert np.median(np.linalg.norm(cells[rates], axis=1)) > 0.05 or unit == "rad/s"
    cells.to_csv(tmp_path / "imu.csv", index=False)
    fix_cells(WHOLE.gnss).to_csv(tmp_path / "gnss.csv", index=False, float_format="%.12f")
    text, _ = draft([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    (tmp_path / "recording.toml").write_text(text)
    said = toml.read(tmp_path / "recording.toml")
    assert said["imu"]["units"]["angular"] == unit


def test_without_a_header_size_and_steadiness_tell(tmp_path: Path) -> None:
    cells = sensor(FLU, 1.0, 1.0, GYRO)[["time", "acc_x", "acc_y", "acc_z", "gyro_x", "gyro_y", "gyro_z"]]
    cells.to_csv(tmp_path / "imu.csv", index=False, header=False)
    path, said = drafted(tmp_path, tmp_path / "imu.csv")
    assert said["imu"]["columns"] == {"time": "1", "angular": ["5", "6", "7"], "force": ["2", "3", "4"]}
    np.testing.assert_allclose(load(path).imu.delta_velocity, WHOLE.imu.delta_velocity, atol=1e-12)


def test_counts_are_scaled_by_gravity(tmp_path: Path) -> None:
    sensor(FLU, 1.0, G / 16384, GYRO).to_csv(tmp_path / "imu.csv", index=False)
    path, _ = drafted(tmp_path, tmp_path / "imu.csv")
    assert "check: counts?" in path.read_text()
    seconds = load(path).imu.delta_velocity.reshape(-1, 100, 3).mean(axis=1)
    size = np.linalg.norm(seconds, axis=1).mean()
    assert size == pytest.approx(G * 0.01, rel=1e-5)


def test_fixes_in_radians_with_a_velocity_down_in_one_file(tmp_path: Path) -> None:
    cells = sensor(FLU, 1.0, 1.0, GYRO)
    fixes = fix_cells(WHOLE.gnss)
    fixes[["lat", "lon"]] *= DEGREE
    fixes["vd"] = -fixes.pop("vu")
    cells = pd.concat([cells, fixes.drop(columns="time").set_axis(cells.index[49::50])], axis=1)
    cells.to_csv(tmp_path / "all.csv", index=False, float_format="%.15g")
    path, said = drafted(tmp_path, tmp_path / "all.csv")
    assert said["gnss"]["columns"]["velocity"] == ["ve", "vn", "-vd"]
    assert said["gnss"]["units"]["position"] == "rad"
    assert "file" not in said["gnss"]
    np.testing.assert_allclose(load(path).gnss.velocity, WHOLE.gnss.velocity, atol=1e-12)
    np.testing.assert_allclose(load(path).gnss.position, WHOLE.gnss.position, rtol=1e-12)


def test_other_aids_are_found_by_their_names(tmp_path: Path) -> None:
    sensor(FLU, 1.0, 1.0, GYRO).to_csv(tmp_path / "imu.csv", index=False)
    others = pd.DataFrame(
        {"time": WHOLE.gnss.time, "wheel_speed": 12.0, "heading_deg": 90.0, "baro_alt": 500.0}
    )
    others.to_csv(tmp_path / "aids.csv", index=False)
    path, said = drafted(tmp_path, tmp_path / "imu.csv", tmp_path / "aids.csv")
    read = load(path)
    np.testing.assert_array_equal(read.body_velocity.velocity[0], [np.nan, 12.0, np.nan])
    assert read.heading_aid.heading[0] == pytest.approx(np.pi / 2)
    assert read.height_aid.height[0] == 500.0
    assert said["body_velocity"]["lever_arm"] == [0.0, 0.0, 0.0]


def test_positions_alone_are_fixes(tmp_path: Path) -> None:
    """In whole numbers of 1e-7 deg, as receivers put them out."""
    sensor(FLU, 1.0, 1.0, GYRO).to_csv(tmp_path / "imu.csv", index=False)
    fixes = fix_cells(WHOLE.gnss)[["time", "lat", "lon", "height"]]
    fixes[["lat", "lon"]] = np.round(fixes[["lat", "lon"]] * 1e7).astype(int)
    fixes.to_csv(tmp_path / "gnss.csv", index=False)
    path, _ = drafted(tmp_path, tmp_path / "imu.csv", tmp_path / "gnss.csv")
    read = load(path)
    np.testing.assert_allclose(read.gnss.position[:, :2], WHOLE.gnss.position[:, :2], atol=0.6e-7 * DEGREE)
    assert np.isnan(read.gnss.velocity).all()


def test_a_file_with_an_attitude_is_a_reference(tmp_path: Path) -> None:
    sensor(FLU, 1.0, 1.0, GYRO).to_csv(tmp_path / "imu.csv", index=False)
    solution = fix_cells(WHOLE.gnss).assign(roll=1.0, pitch=-2.0, yaw=270.0)
    solution.to_csv(tmp_path / "ins.csv", index=False, float_format="%.12f")
    path, said = drafted(tmp_path, tmp_path / "imu.csv", tmp_path / "ins.csv")
    assert set(said) == {"imu", "reference"}
    read = load(path)
    np.testing.assert_allclose(read.reference.attitude[3] / DEGREE, [1, -2, 270])
    np.testing.assert_allclose(read.reference.position, WHOLE.gnss.position, rtol=1e-11)


def test_what_has_no_imu_is_refused(tmp_path: Path) -> None:
    fix_cells(WHOLE.gnss).to_csv(tmp_path / "gnss.csv", index=False)
    with pytest.raises(InputError, match=r"gnss\.csv: none has an IMU"):
        draft([tmp_path / "gnss.csv"], tmp_path)
    (tmp_path / "x.csv").write_text("time,a,b\n1,2,3\n2,3,4\n")
    with pytest.raises(InputError, match=r"x\.csv: has neither an IMU nor an aid"):
        draft([tmp_path / "x.csv"], tmp_path)


@pytest.mark.parametrize(("kind", "lacks"), [("gyro", "specific forces"), ("acc", "angular rates")])
def test_half_an_imu_is_refused_with_what_it_lacks(tmp_path: Path, kind: str, lacks: str) -> None:
    """Loggers write gyros and accelerometers into files of their own."""
    sensor(FLU, 1.0, 1.0, GYRO).filter(regex=f"time|{kind}").to_csv(tmp_path / "half.csv", index=False)
    with pytest.raises(InputError, match=rf"half\.csv: {kind}_x, .* of an IMU, and there are no {lacks}"):
        draft([tmp_path / "half.csv"], tmp_path)


def test_columns_of_which_an_axis_is_missing_are_named(tmp_path: Path) -> None:
    sensor(FLU, 1.0, 1.0, GYRO).drop(columns="gyro_y").to_csv(tmp_path / "imu.csv", index=False)
    said = "no angular rates beside them but gyro_x, gyro_z, which are not along three axes: name the file"
    with pytest.raises(InputError, match=said):
        draft([tmp_path / "imu.csv"], tmp_path)


def test_two_halves_of_an_imu_are_one(tmp_path: Path) -> None:
    """At 100 Hz and 50 Hz, as phones log them; fixes tell degrees and which way is ahead."""
    cells = sensor(FRD, DEGREE, 1.0, GYRO)
    gyro, force = cells.filter(regex="time|gyro"), cells.filter(regex="time|acc")
    force = force.rolling(2).mean().assign(time=force["time"])[1::2]
    files = [tmp_path / f"{name}.csv" for name in ("acc", "gnss", "gyro")]
    for path, table in zip(files, (force, fix_cells(WHOLE.gnss), gyro), strict=True):
        table.to_csv(path, index=False)
    path, told = drafted(tmp_path, *files)
    assert told["imu"]["file"] == "gyro.csv"
    assert told["imu"]["columns"] == {"time": "time", "angular": ["gyro_x", "gyro_y", "gyro_z"]}
    assert told["imu"]["axes"] == "forward-right-down"
    assert told["imu"]["units"]["angular"] == "deg/s"
    assert told["accelerometer"]["units"] == {"time": "s", "force": "m/s2"}
    read = load(path)
    np.testing.assert_allclose(read.imu.delta_angle, WHOLE.imu.delta_angle, rtol=1e-9, atol=1e-12)
    pairs = read.imu.delta_velocity.reshape(-1, 2, 3).sum(axis=1)
    np.testing.assert_allclose(pairs, WHOLE.imu.delta_velocity.reshape(-1, 2, 3).sum(axis=1), atol=1e-9)
    cells.to_csv(tmp_path / "whole.csv", index=False)
    text, _ = draft([*files, tmp_path / "whole.csv"], tmp_path)
    assert "# imu of gyro.csv: left out, whole.csv has it too" in text
    assert "# accelerometer of acc.csv: left out, whole.csv has one too" in text
    assert 'file = "whole.csv"' in text


def two_files(folder: Path, force: pd.DataFrame, gyro: pd.DataFrame | None = None) -> list[Path]:
    gyro = sensor(FRD, DEGREE, 1.0, GYRO).filter(regex="time|gyro") if gyro is None else gyro
    for name, table in (("gyro", gyro), ("acc", force)):
        table.to_csv(folder / f"{name}.csv", index=False)
    return [folder / "gyro.csv", folder / "acc.csv"]


@pytest.mark.parametrize("kind", ["gyro", "acc"])
def test_a_half_with_too_little_in_it_is_refused_by_its_name(tmp_path: Path, kind: str) -> None:
    cells = sensor(FRD, DEGREE, 1.0, GYRO)
    gyro, force = (cells.filter(regex=f"time|{half}") for half in ("gyro", "acc"))

    def refused(change: Callable[[pd.DataFrame], pd.DataFrame]) -> str:
        halves = (force, change(gyro)) if kind == "gyro" else (change(force), gyro)
        with pytest.raises(InputError, match=rf"^\S*{kind}\.csv: ") as refusal:
            draft(two_files(tmp_path, *halves), tmp_path)
        return str(refusal.value)

    assert "has 1 samples" in refused(lambda half: half[:1])
    assert f"column {kind}_y has no number in it" in refused(
        lambda half: half.assign(**{f"{kind}_y": np.nan})
    )
    names = f"{kind}_x, {kind}_y, {kind}_z"
    nowhere = {f"{kind}_x": [1.0, np.nan] * (len(cells) // 2), f"{kind}_y": [np.nan, 1.0] * (len(cells) // 2)}
    assert f"no row has a number in each of the columns {names}" in refused(
        lambda half: half.assign(**nowhere)
    )
    assert "unit of its time" in refused(lambda half: half.assign(time=half.time / 1000))


def test_further_columns_do_not_hide_a_half(tmp_path: Path) -> None:
    cells = sensor(FRD, DEGREE, 1.0, GYRO)
    force = cells.filter(regex="time|acc").assign(heading=90.0)
    gyro = cells.filter(regex="time|gyro").assign(baro_height=5.0)
    path, told = drafted(tmp_path, *two_files(tmp_path, force, gyro))
    assert set(told) == {"imu", "accelerometer", "heading", "height"}
    np.testing.assert_allclose(load(path).imu.delta_velocity, WHOLE.imu.delta_velocity, atol=1e-9)
    files = two_files(tmp_path, force.assign(lat=45.0, lon=9.0), gyro)
    with pytest.raises(InputError, match="beside positions, velocities or an attitude they are no half"):
        draft(files, tmp_path)


@pytest.mark.parametrize("step", [50, 97])
def test_slow_gyros_are_not_taken_for_stamps_in_milliseconds(tmp_path: Path, step: int) -> None:
    """At 2 Hz, and at about 1 Hz."""
    cells = sensor(FRD, DEGREE, 1.0, GYRO)
    gyro = cells.filter(regex="time|gyro")[step - 1 :: step]
    path, told = drafted(tmp_path, *two_files(tmp_path, cells.filter(regex="time|acc"), gyro))
    assert told["imu"]["units"]["time"] == "s"
    assert len(load(path).imu.time) == len(gyro)


def test_a_name_tells_seconds_of_an_imu_of_one_hertz(tmp_path: Path) -> None:
    cells = sensor(FRD, DEGREE, 1.0, GYRO)
    gyro, force = (cells.filter(regex=f"time|{half}") for half in ("gyro", "acc"))
    gyro = gyro[99::100].rename(columns={"time": "time_s"})
    path, told = drafted(tmp_path, *two_files(tmp_path, force, gyro))
    assert told["imu"]["units"]["time"] == "s"
    assert len(load(path).imu.time) == len(gyro)
    nameless = cells[99::100].astype({"time": int})
    nameless.to_csv(tmp_path / "nameless.csv", index=False)
    text, _ = draft([tmp_path / "nameless.csv"], tmp_path)
    assert '# with steps of 1, 1000 Hz; check: or are they seconds?\nunits.time = "ms"' in text


@pytest.mark.parametrize(
    ("files", "unit"),
    [
        (("Gyroscope.csv", "TotalAcceleration.csv"), ("", "")),
        (("phone_gyr.csv", "phone_acc.csv"), (" (rad/s)", " (m/s^2)")),
        (("1.csv", "2.csv"), (" (rad/s)", " (m/s^2)")),
        (("angular velocity.csv", "accel_x_y_z.csv"), ("_axis", "_axis")),
    ],
)
def test_axes_without_a_name_are_those_of_the_sensor_of_the_file(
    tmp_path: Path, files: tuple[str, str], unit: tuple[str, str]
) -> None:
    """As phones log them, also in another order."""
    cells = sensor(FRD, 1.0, 1.0, GYRO)
    paths = [tmp_path / "gnss.csv"]
    fix_cells(WHOLE.gnss).to_csv(paths[0], index=False)
    for name, half, ending in zip(files, ("gyro", "acc"), unit, strict=True):
        of_half = cells.filter(regex=f"time|{half}").rename(
            columns={f"{half}_{axis}": f"{axis.upper()}{ending}" for axis in "xyz"}
        )
        paths.append(tmp_path / name)
        of_half[of_half.columns[[0, 3, 1, 2]]].to_csv(paths[-1], index=False)
    path, told = drafted(tmp_path, *paths)
    assert told["imu"]["columns"]["angular"] == [f"{axis}{unit[0]}" for axis in "XYZ"]
    assert told["accelerometer"]["columns"]["force"] == [f"{axis}{unit[1]}" for axis in "XYZ"]
    read = load(path)
    np.testing.assert_allclose(read.imu.delta_angle, WHOLE.imu.delta_angle, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(read.imu.delta_velocity, WHOLE.imu.delta_velocity, atol=1e-9)


@pytest.mark.parametrize("names", [("x", "y", "z"), ("x_m", "y_m", "z_m"), ("x", "y_dps", "w")])
def test_axes_of_which_nothing_tells_the_sensor_are_none(tmp_path: Path, names: tuple[str, ...]) -> None:
    """A magnetometer, a place."""
    cells = sensor(FRD, 1.0, 1.0, GYRO).filter(regex="time|acc")
    cells.set_axis(["time", *names], axis=1).to_csv(tmp_path / "field.csv", index=False)
    with pytest.raises(
        InputError, match=f"neither an IMU nor an aid .* columns are time, {', '.join(names)}"
    ):
        draft([tmp_path / "field.csv"], tmp_path)


@pytest.mark.parametrize(
    "change",
    [
        lambda cells: cells.assign(time=cells["time"].astype(int)),
        lambda cells: cells[::-1],
        lambda cells: cells.assign(gyro_x=[np.inf, *cells["gyro_x"][1:]]),
    ],
    ids=["whole seconds", "backwards", "infinite"],
)
def test_odd_rows_are_drafted_without_a_warning(
    tmp_path: Path, recwarn: pytest.WarningsRecorder, change: Callable[[pd.DataFrame], pd.DataFrame]
) -> None:
    change(sensor(FLU, 1.0, 1.0, GYRO)).to_csv(tmp_path / "imu.csv", index=False)
    fix_cells(WHOLE.gnss).to_csv(tmp_path / "gnss.csv", index=False)
    text, _ = draft([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    assert 'axes = "forward-left-up"' in text
    assert not recwarn.list


@pytest.mark.parametrize("kept", [0.0, 1.0])
@pytest.mark.parametrize("half", ["acc", "gyro|acc"])
def test_accelerations_without_gravity_are_refused(tmp_path: Path, kept: float, half: str) -> None:
    """As phones log them beside those that an IMU feels; and what is 0 throughout."""
    cells = sensor(FLU, 1.0, 1.0, GYRO)
    cells["acc_z"] -= cells["acc_z"].mean()
    cells[["acc_x", "acc_y", "acc_z"]] *= kept
    cells.filter(regex=f"time|{half}").to_csv(tmp_path / "imu.csv", index=False)
    with pytest.raises(InputError, match=r"acc_x, acc_y, acc_z are .* in the mean: gravity is not in them"):
        draft([tmp_path / "imu.csv"], tmp_path)


def test_a_line_of_units_below_the_header_is_refused_with_its_line(tmp_path: Path) -> None:
    head, *rows = sensor(FLU, 1.0, 1.0, GYRO).to_csv(index=False).splitlines()
    (tmp_path / "imu.csv").write_text("\n".join([head, "s" + 6 * ",SI", *rows]))
    with pytest.raises(InputError, match="line 2: time holds 's', and numbers below it: take out the second"):
        draft([tmp_path / "imu.csv"], tmp_path)


def test_fixes_without_a_number_are_refused_without_a_warning(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    sensor(FLU, 1.0, 1.0, GYRO).to_csv(tmp_path / "imu.csv", index=False)
    fixes = fix_cells(WHOLE.gnss)
    fixes.assign(**dict.fromkeys(fixes.columns[1:], np.nan)).to_csv(tmp_path / "gnss.csv", index=False)
    with pytest.raises(InputError, match=r"gnss\.csv: no row has anything for gnss"):
        draft([tmp_path / "imu.csv", tmp_path / "gnss.csv"], tmp_path)
    assert not recwarn.list


def test_vibration_does_not_pass_for_gravity(tmp_path: Path) -> None:
    """White, of 15 m/s2 on each axis, as on a drone: the size of a sample is 25 m/s2."""
    cells = sensor(FLU, 1.0, 1.0, GYRO)
    shaken = np.random.default_rng(1).normal(0, 15, (len(cells), 3))
    cells[["acc_x", "acc_y", "acc_z"]] += shaken
    cells.to_csv(tmp_path / "imu.csv", index=False)
    path, said = drafted(tmp_path, tmp_path / "imu.csv")
    assert said["imu"]["units"]["force"] == "m/s2"
    np.testing.assert_allclose(
        load(path).imu.delta_velocity, WHOLE.imu.delta_velocity + 0.01 * shaken @ FLU, atol=1e-12
    )


def dates(time: np.ndarray) -> list[str]:
    return [stamp.isoformat() for stamp in pd.Timestamp("2025-03-04") + pd.to_timedelta(time, unit="s")]


@pytest.mark.parametrize(("column", "clock", "ahead"), [("gps_time", "gps", 0), ("time", "unix", 18)])
def test_dates_of_a_column_of_gps_are_gps_time(tmp_path: Path, column: str, clock: str, ahead: int) -> None:
    cells = sensor(FLU, 1.0, 1.0, [column, *GYRO[1:]])
    cells[column] = dates(3600 + WHOLE.imu.time)
    cells.to_csv(tmp_path / "imu.csv", index=False)
    fixes = fix_cells(WHOLE.gnss)
    fixes["time"] += UNIX + 3600 - 18 + ahead
    fixes.rename(columns={"time": "unix_time"}).to_csv(
        tmp_path / "gnss.csv", index=False, float_format="%.12f"
    )
    path, said = drafted(tmp_path, tmp_path / "imu.csv", tmp_path / "gnss.csv")
    assert said["imu"]["clock"] == clock
    assert "# check: the dates" in path.read_text()
    read = load(path)
    assert doubts(read) == []
    np.testing.assert_allclose(read.imu.time, WHOLE.imu.time + 3600 + ahead, atol=1e-6)
    np.testing.assert_allclose(read.gnss.time, WHOLE.gnss.time + 3600 + ahead, atol=1e-6)


def test_files_of_different_times_are_drafted_all_the_same(tmp_path: Path) -> None:
    for name, cells, later in (
        ("imu.csv", sensor(FLU, 1.0, 1.0, ["unix_time", *GYRO[1:]]), 0),
        ("gnss.csv", fix_cells(WHOLE.gnss).rename(columns={"time": "unix_time"}), 14400),
    ):
        cells["unix_time"] += UNIX + later
        cells.to_csv(tmp_path / name, index=False, float_format="%.12f")
    told = run(tmp_path / "imu.csv", tmp_path / "gnss.csv", "-o", tmp_path / "recording.toml")
    assert told.exit_code == 0, told.output
    assert toml.read(tmp_path / "recording.toml")["imu"]["axes"] == "forward-left-up"
    assert "do not overlap" in told.stderr
    assert "offset = -14400" in told.stderr


def test_fixes_of_a_file_of_their_own_come_before_those_of_an_imu(tmp_path: Path) -> None:
    cells = sensor(FLU, 1.0, 1.0, GYRO)
    copied = fix_cells(WHOLE.gnss).drop(columns="time").set_axis(cells.index[49::50])
    pd.concat([cells, copied], axis=1).to_csv(tmp_path / "all.csv", index=False, float_format="%.15g")
    fix_cells(WHOLE.gnss).to_csv(tmp_path / "receiver.csv", index=False, float_format="%.12f")
    text, guesses = draft([tmp_path / "all.csv", tmp_path / "receiver.csv"], tmp_path)
    said = "gnss of all.csv: left out, receiver.csv has it too"
    assert guesses[0] == said
    assert f"# {said}" in text
    path, tables = drafted(tmp_path, tmp_path / "all.csv", tmp_path / "receiver.csv")
    assert (tables["imu"]["file"], tables["gnss"]["file"]) == ("all.csv", "receiver.csv")
    np.testing.assert_array_equal(load(path).gnss.time, WHOLE.gnss.time)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["import", *map(str, arguments)])


def test_the_command_writes_what_it_says_and_replaces_nothing(tmp_path: Path) -> None:
    imu_cells(WHOLE.imu).to_csv(tmp_path / "imu.csv", index=False)
    output = tmp_path / "out" / "recording.toml"
    first = run(tmp_path / "imu.csv", "-o", output)
    assert first.exit_code == 0, first.output
    assert "imu.format" in first.output
    assert len(load(output).imu.time) == len(WHOLE.imu.time)
    output.write_text("mine")
    second = run(tmp_path / "imu.csv", "-o", output)
    assert second.exit_code == 2
    assert "exists; replace it with --force" in " ".join(second.stderr.split())
    assert output.read_text() == "mine"
    assert run(tmp_path / "imu.csv", "-o", output, "--force").exit_code == 0
    assert output.read_text() != "mine"


@pytest.mark.skipif(not CAR.exists(), reason="no car_drive in the folder TRUENORTH_RECORDINGS")
def test_a_real_drive_needs_its_mounting_and_lever_arm_alone(tmp_path: Path) -> None:
    path, said = drafted(tmp_path, CAR / "gnss.pos.gz", CAR / "imu.csv.gz")
    assert said["imu"]["axes"] == "backward-right-up"
    assert said["imu"]["clock"] == "gps-day"
    text = path.read_text().replace('axes = "backward-right-up"', 'axes = "forward-right-down"')
    mounting = (
        "[[-0.98866, -0.092586, 0.118231], [-0.093239, 0.995644, 0], [-0.117716, -0.011024, -0.992986]]"
    )
    text = text.replace("# mounting = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", f"mounting = {mounting}")
    path.write_text(text.replace("lever_arm = [0.0, 0.0, 0.0]", "lever_arm = [-0.05, 0.0, 0.0]"))
    read = load(path)
    moved = doubts(read)
    assert len(moved) == 1
    assert "the stamps of imu were moved by -0.0" in moved[0]
    assert read.lever_arms.gnss == (-0.05, 0.0, 0.0)
    standing = read.imu.time < read.imu.time[0] + 20
    force = read.imu.delta_velocity[standing].sum(axis=0) / intervals(read.imu.time)[standing].sum()
    # A MEMS accelerometer of 0.1 m/s2, a mounting that is known to a degree or two.
    np.testing.assert_allclose(force, [0, 0, 9.8], atol=0.3)
    assert read.imu.time[0] < read.gnss.time[50] < read.gnss.time[-1] < read.imu.time[-1]


def test_a_name_of_a_file_is_a_name_whatever_is_in_it(tmp_path: Path) -> None:
    """A line of a name does not become one of the draft, nor a character that TOML does not take."""
    path = tmp_path / "imu\nrate = 1\x1b[2J\x7f.csv"
    imu_cells(WHOLE.imu).to_csv(path, index=False)
    text, _ = draft([path], tmp_path)
    (tmp_path / "recording.toml").write_text(text, encoding="utf-8")
    read = toml.read(tmp_path / "recording.toml")
    assert read["imu"]["file"] == path.name
    assert "rate" not in read
