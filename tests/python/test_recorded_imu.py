"""Recordings through the filter: a synthetic one made by the plant, and a real one where it is present."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sim_scenarios
from sim_scenarios import Start, ZeroVelocity
from sim_scenarios.attitude import dcm
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Instance, Port
from sim_scenarios.recorded_imu import (
    level,
    read_recording,
    recording_named,
    residuals,
    signals_of_imu,
)
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import ARCMIN, DEGREE

REAL = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "parked_vehicle_rlg.csv.gz")
SITE = (34.246048, 108.909664, 380.0)
GOOD_SENSORS = {
    "prior.gyro_bias_sigma": "0.02 deg/h",
    "prior.accelerometer_bias_sigma": "0.1 mg",
    "process.angle_random_walk": "0.001 deg/h^0.5",
    "process.velocity_random_walk": "50 ug/Hz^0.5",
}
IMU = {
    f"delta_{kind}_{axis}": f"imu.delta_{kind}[{i}]"
    for kind in ("angle", "velocity")
    for i, axis in enumerate("xyz", start=1)
}
GNSS = {
    "gnss_velocity_east": ("gnss.velocity[1]", 1.0),
    "gnss_velocity_north": ("gnss.velocity[2]", 1.0),
    "gnss_velocity_up": ("gnss.velocity[3]", 1.0),
    "gnss_latitude": ("gnss.latitude", DEGREE),
    "gnss_longitude": ("gnss.longitude", DEGREE),
    "gnss_height": ("gnss.height", 1.0),
}


def recorded(fmus: Fmus, scenario: str, seconds: float) -> pd.DataFrame:
    """What the IMU and the GNSS receiver of a scenario put out, as a recording."""
    names = ["imu.time", *IMU.values(), "gnss.sample", *(name for name, _ in GNSS.values())]
    instance = Instance(fmus.plant, "recorder", load_scenario(scenario, fmus, seed=21).plant)
    instance.begin_initialisation(0.0, seconds)
    instance.finish_initialisation()
    port = Port(instance, names)
    rows = []
    for step in range(round(100 * seconds)):
        instance.step(0.01 * step, 0.01)
        port.read()
        rows.append([port.signals.value(name) for name in names])
    instance.close()
    signals = pd.DataFrame(rows, columns=names)
    table = pd.DataFrame(
        {"time": signals["imu.time"], **{column: signals[name] for column, name in IMU.items()}}
    )
    fix = signals["gnss.sample"].diff().fillna(0) > 0
    for column, (name, unit) in GNSS.items():
        table[column] = (signals[name] / unit).where(fix)
    return table


@pytest.fixture(scope="module")
def ship_table(fmus: Fmus) -> pd.DataFrame:
    return recorded(fmus, "swaying_ship", 320.0)


def test_a_recording_of_the_plant_gives_what_the_plant_gives(
    ship_table: pd.DataFrame, fmus: Fmus, tmp_path: Path
) -> None:
    """Replay and co-simulation feed the filter the same numbers."""
    path = tmp_path / "ship.csv.gz"
    ship_table.to_csv(path, index=False, float_format="%.17g")
    live = sim_scenarios.run(
        "swaying_ship", seed=21, set={"duration": 320.0, "evaluation.stop": 320.0}, fmus=fmus
    )
    scenario = load_scenario("swaying_ship", fmus, seed=21)
    first = {
        **{
            f"initial.{angle}": float(live[f"nav.{angle}"].values[0])
            for angle in ("roll", "pitch", "heading")
        },
        **{f"initial.{p}": float(live[f"nav.{p}"].values[0]) for p in ("latitude", "longitude", "height")},
        "initial.velocity": live["nav.velocity"].values[0].tolist(),
    }
    replayed = sim_scenarios.replay(path, Start(0.0), set={**scenario.filter, **first}, fmu=fmus.filter)
    np.testing.assert_allclose(replayed["nav.heading"], live["nav.heading"], atol=1e-3 * ARCMIN)
    np.testing.assert_allclose(replayed["fix_time"], live["fix_time"])
    np.testing.assert_allclose(replayed["nis"], live["nis"], rtol=1e-3)


def test_a_parked_vehicle_finds_its_heading(fmus: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "parked.csv"
    recorded(fmus, "parked_vehicle", 320.0)[["time", *IMU]].to_csv(path, index=False, float_format="%.17g")
    run = sim_scenarios.replay(
        path, Start(100.6 * DEGREE), zero_velocity=ZeroVelocity(SITE), set=GOOD_SENSORS, fmu=fmus.filter
    )
    late = run["time"].values >= 300
    error = run["nav.heading"].values[late] / DEGREE - 90.6
    sigma = run["heading_sigma"].values[late] / DEGREE
    assert np.all(np.abs(error) < 3 * sigma)
    assert bool(run["converged"].values[-1])


@pytest.mark.skipif(not REAL.exists(), reason=f"no {REAL.name} in the folder TRUENORTH_RECORDINGS")
def test_the_real_recording_comes_to_its_heading(fmus: Fmus) -> None:
    run = sim_scenarios.replay(
        REAL, Start(100.6 * DEGREE), zero_velocity=ZeroVelocity(SITE), set=GOOD_SENSORS, fmu=fmus.filter
    )
    late = run["nav.heading"].values[run["time"].values >= 300] / DEGREE
    assert np.all(np.abs(late - 90.60) < 0.1)
    assert bool(run["converged"].values[-1])
    assert int(run["rejected_samples"].values[-1]) == 0


@pytest.mark.skipif(not REAL.exists(), reason=f"no {REAL.name} in the folder TRUENORTH_RECORDINGS")
@pytest.mark.parametrize("coarse", [True, False])
@pytest.mark.parametrize("off", [10.0, 80.0, 170.0])
def test_the_real_recording_comes_to_its_heading_from_anywhere(fmus: Fmus, off: float, coarse: bool) -> None:
    """With the coarse stage without any heading: whatever the start says is not used."""
    run = sim_scenarios.replay(
        REAL,
        Start((90.6 + off) * DEGREE, heading_sigma=104 * DEGREE),
        zero_velocity=ZeroVelocity(SITE),
        set={
            **GOOD_SENSORS,
            "error_model": "invariant",
            "predictor": "linearised",
            "corrector": "standard",
            "prior.tilt_sigma": "1 deg",
            "coarse.enabled": coarse,
        },
        fmu=fmus.filter,
    )
    late = run["nav.heading"].values[run["time"].values >= 300] / DEGREE
    assert np.all(np.abs(late - 90.60) < 0.05)
    assert bool(run["converged"].values[-1])


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.1, -0.2), (-1.0, 0.5), (3.0, 0.1)])
def test_levelling_finds_roll_and_pitch(roll: float, pitch: float) -> None:
    force = dcm(roll, pitch, 1.234).T @ [0, 0, 9.8]
    assert level(force) == pytest.approx((roll, pitch))


def test_a_gap_is_a_jump_of_the_sample_counter() -> None:
    table = pd.DataFrame({"time": [1.0, 1.01, 1.02, 1.06, 1.07], **dict.fromkeys(IMU, 0.0)})
    signals = signals_of_imu(table)
    np.testing.assert_array_equal(signals["imu.sample"], [0, 1, 2, 3, 7, 8])
    assert signals["imu.time"][0] == pytest.approx(0.99)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda t: t.drop(columns="delta_angle_y"),
            "there is no column delta_angle_y; did you mean 'delta_angle_",
        ),
        (lambda t: t.iloc[:1], "has 1 samples"),
        (lambda t: t.assign(time=0.0), "line 3: time must increase"),
        (lambda t: t.assign(**{c: 100 * t[c] for c in IMU}), "seems to hold rates, not increments"),
        (lambda t: t.assign(**{c: t[c] / 9.8 for c in IMU}), r"\|delta_velocity\| / dt is (1|0\.99)"),
        (lambda t: t.assign(delta_angle_x="x"), "column delta_angle_x holds something that is not a number"),
    ],
)
def test_bad_recordings_are_refused(ship_table: pd.DataFrame, tmp_path: Path, edit, message: str) -> None:
    path = tmp_path / "bad.csv"
    edit(ship_table.iloc[:100]).to_csv(path, index=False)
    with pytest.raises(InputError, match=message):
        read_recording(path)


def test_what_is_no_recording_is_refused(tmp_path: Path, fmus: Fmus) -> None:
    with pytest.raises(InputError, match="there is no recording"):
        read_recording(tmp_path / "absent.csv")
    (tmp_path / "empty.csv").touch()
    with pytest.raises(InputError, match="cannot be read as a CSV file"):
        read_recording(tmp_path / "empty.csv")
    (tmp_path / "fake.csv.gz").write_text("time")
    with pytest.raises(InputError, match="cannot be read as a CSV file"):
        sim_scenarios.replay(tmp_path / "fake.csv.gz", Start(0.0), fmu=fmus.filter)


def test_missing_or_incomplete_fixes_are_refused(
    ship_table: pd.DataFrame, tmp_path: Path, fmus: Fmus
) -> None:
    def replay(table: pd.DataFrame, **options: object) -> None:
        table.to_csv(tmp_path / "t.csv", index=False)
        sim_scenarios.replay(tmp_path / "t.csv", Start(0.0), fmu=fmus.filter, **options)

    short = ship_table.iloc[:500].copy()
    with pytest.raises(InputError, match=r"no column gnss_velocity_east.*zero-velocity"):
        replay(short[["time", *IMU]])
    with pytest.raises(InputError, match="no row has a fix"):
        replay(short.iloc[:50])
    short.loc[short["gnss_height"].notna(), "gnss_height"] = np.nan
    with pytest.raises(InputError, match=r"line 101: the fix is incomplete"):
        replay(short)
    with pytest.raises(InputError, match="a rate and a sigma greater than 0"):
        replay(short, zero_velocity=ZeroVelocity(SITE, sigma=0.0))
    with pytest.raises(InputError, match=r"did you mean 'robust.gamma'"):
        replay(ship_table.iloc[:500], set={"robust.gama": 1.0})


@pytest.fixture
def shaken(tmp_path: Path) -> tuple[Path, pd.DataFrame]:
    """Sixty seconds at rest, tilting slowly, with noise that is known."""
    time = 0.01 * np.arange(1, 6001)
    rng = np.random.default_rng(8)
    noise = pd.DataFrame(1e-4 * rng.standard_normal((6000, 6)), columns=list(IMU))
    table = noise.copy()
    table["delta_angle_x"] += 1e-6
    table["delta_velocity_x"] += 0.098 * np.sin(1e-4 * time)
    table["delta_velocity_z"] += 0.098
    table.insert(0, "time", time)
    path = tmp_path / "shaken.csv"
    table.to_csv(path, index=False)
    return path, noise


def test_residuals_are_the_noise_without_bias_and_gravity(shaken: tuple[Path, pd.DataFrame]) -> None:
    path, noise = shaken
    found = residuals(path, period=0.01, span=20.0)
    assert list(found) == list(IMU.values())
    for column, name in IMU.items():
        # What the mean over 2000 samples takes along is 1e-4 / 2000^0.5, four times that at worst.
        np.testing.assert_allclose(found[name][1000:-1000], noise[column][1000:-1000], atol=1e-5)


def test_residuals_need_the_samples_of_the_plant(shaken: tuple[Path, pd.DataFrame]) -> None:
    with pytest.raises(InputError, match=r"a sample every 0\.01 s, where 0\.02 s are needed"):
        residuals(shaken[0], period=0.02, span=20.0)


def test_recordings_are_looked_for_in_the_folder_that_is_named(
    shaken: tuple[Path, pd.DataFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = shaken
    monkeypatch.setenv("TRUENORTH_RECORDINGS", str(path.parent))
    assert recording_named(path.name) == path
    assert recording_named("nothing.csv") is None
    monkeypatch.chdir(path.parent)
    monkeypatch.delenv("TRUENORTH_RECORDINGS")
    assert recording_named(path.name) is None
