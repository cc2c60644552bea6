"""Noise derived from recordings: of noises that were made, in closed form and by TruthPlant."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from plant_signals import sensed
from scipy.stats import chi2
from town_drive import TownDrive, imu_cells
from typer.testing import CliRunner

from sim_scenarios import toml
from sim_scenarios.cli.application import app
from sim_scenarios.cli.options import settings
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, Fmus
from sim_scenarios.recordings import from_drive
from sim_scenarios.recordings.allan import allan_deviation
from sim_scenarios.recordings.at_rest import at_rest
from sim_scenarios.recordings.derive import bias_walk, derive
from sim_scenarios.recordings.from_drive import Innovations
from sim_scenarios.recordings.replay import Filter, replay
from sim_scenarios.recordings.scoring import Loss, descend
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.stretches import between, longest_standing
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording
from sim_scenarios.units import DEGREE, HOUR, STANDARD_GRAVITY

Array = NDArray[np.float64]

PERIOD = 0.02  # s
WHITE = {"gyro": 0.0038 * DEGREE, "accelerometer": 140e-6 * STANDARD_GRAVITY}  # a MEMS sensor, of its owner
WALK = {"gyro": 7.6e-5 * DEGREE, "accelerometer": 28e-6 * STANDARD_GRAVITY}
MARKOV = {"gyro": 5 * DEGREE / HOUR, "accelerometer": 5e-4 * STANDARD_GRAVITY}
MARKOV_TIME = 100.0  # s
TWO_HOURS = 7200.0  # s


def standing_then_moving(rest: float = 60.0, move: float = 40.0, seed: int = 1) -> Recording:
    """Noise of a sensor that stands, then turns and shakes."""
    random = np.random.default_rng(seed)
    n = round((rest + move) / PERIOD)
    time = PERIOD * np.arange(1, n + 1)
    angle = WHITE["gyro"] * np.sqrt(PERIOD) * random.standard_normal((n, 3))
    velocity = WHITE["accelerometer"] * np.sqrt(PERIOD) * random.standard_normal((n, 3))
    velocity[:, 2] += STANDARD_GRAVITY * PERIOD
    moving = time > rest
    angle[moving] += 0.1 * PERIOD * np.sin(time[moving])[:, None]
    velocity[moving] += 0.5 * PERIOD * random.standard_normal((np.count_nonzero(moving), 3))
    return Recording("drive", ImuTable(time, angle, velocity))


def at_rest_of_plant(fmus: Fmus, parts: set[str], seconds: float, seed: int) -> Recording:
    """TruthPlant's parked vehicle, motionless, with white noise and other errors."""
    told: dict[str, object] = {"communication_step": 0.1, "motion.settle.angle": 0.0}
    told |= dict.fromkeys(("motion.vibration.angle", "motion.vibration.acceleration"), 0.0)
    for sensor, white in WHITE.items():
        told[f"imu.{sensor}.white_noise"] = white
        if "walk" in parts:
            told[f"imu.{sensor}.bias_random_walk"] = WALK[sensor]
        if "markov" in parts:
            told[f"imu.{sensor}.markov_sigma"] = MARKOV[sensor]
            told[f"imu.{sensor}.markov_time"] = MARKOV_TIME
    return sensed(fmus, "parked_vehicle", seconds, seed=seed, settings=told)


def simulated(sensor: str, parts: set[str]) -> dict[str, float]:
    walk = {"random_walk": WALK[sensor]} if "walk" in parts else {}
    markov = {"markov_sigma": MARKOV[sensor], "markov_time": MARKOV_TIME} if "markov" in parts else {}
    return {"white_noise": WHITE[sensor], **walk, **markov}


class Ladder:
    """Three independent random walks of size q, measured with sigma r once a second, and a Kalman filter."""

    def __init__(self, q: float, r: float, n: int = 2000, seed: int = 1) -> None:
        random = np.random.default_rng(seed)
        self.z = np.cumsum(q * random.standard_normal((n, 3)), axis=0) + r * random.standard_normal((n, 3))

    def __call__(self, parameters: dict[str, float]) -> Innovations:
        q, r = parameters["q"] ** 2, parameters["r"] ** 2
        x, p = np.zeros(3), 100.0
        residual, sigma = np.zeros_like(self.z), np.zeros_like(self.z)
        for k, z in enumerate(self.z):
            p += q
            residual[k], sigma[k] = z - x, np.sqrt(p + r)
            gain = p / (p + r)
            x, p = x + gain * (z - x), (1 - gain) * p
        return Innovations(np.arange(len(self.z), dtype=float), residual, sigma)


def test_descent_finds_the_least_loss_within_bounds() -> None:
    A, b = np.array([[3.0, 1.0], [1.0, 2.0]]), np.array([1.0, -4.0])

    def loss(x: Array) -> Loss:
        return Loss(float(x @ A @ x / 2 - b @ x), A @ x - b, A)

    free, _ = descend(loss, np.zeros(2), np.full(2, -9.0), np.full(2, 9.0), gain=1e-12)
    assert free == pytest.approx(np.linalg.solve(A, b), abs=1e-4)
    bounded, _ = descend(loss, np.zeros(2), np.full(2, -1.0), np.full(2, 1.0), gain=1e-12)
    assert bounded == pytest.approx([2 / 3, -1.0], abs=1e-4)
    held, _ = descend(loss, np.zeros(2), np.full(2, -9.0), np.full(2, 9.0), fixed=0, gain=1e-12)
    assert held == pytest.approx([0.0, -2.0], abs=1e-4)


def test_standing_stretch_is_found() -> None:
    found = longest_standing(standing_then_moving(60.0, 40.0))
    assert found is not None
    assert 0.0 < found.begin <= 3.0
    assert 56.0 <= found.end <= 60.0
    assert found.period == pytest.approx(PERIOD)


def test_gap_ends_a_standing_stretch() -> None:
    imu = standing_then_moving(100.0, 20.0).imu
    later = replace(imu, time=imu.time + 5.0 * (imu.time > 40.0))
    found = longest_standing(Recording("gap", later))
    assert found is not None
    assert found.begin > 45.0
    with pytest.raises(InputError, match="gap"):
        between(Recording("gap", later), 30.0, 60.0)


def test_a_sample_that_is_no_number_ends_a_standing_stretch() -> None:
    recording = standing_then_moving(100.0, 20.0)
    at = int(np.searchsorted(recording.imu.time, 30.0))
    recording.imu.delta_velocity[at, 1] = np.nan
    found = longest_standing(recording)
    assert found is not None
    assert 30.0 < found.begin < 34.0
    assert np.isfinite(found.imu.delta_velocity).all()
    stamp = f"{recording.imu.time[at]:g}"
    with pytest.raises(InputError, match=rf"the IMU sample at {stamp} s is not a number; choose a stretch"):
        between(recording, 20.0, 60.0)
    recording.imu.delta_velocity[:, 1] = np.nan
    assert longest_standing(recording) is None


def test_fixes_that_move_end_a_standing_stretch() -> None:
    recording = standing_then_moving(100.0, 0.0)
    time = np.arange(0.5, 100.0)
    speed = np.zeros((100, 3))
    speed[:30, 1] = 2.0
    fixes = FixTable(time, np.zeros((100, 3)), speed, np.zeros((100, 3)), np.zeros((100, 3)))
    found = longest_standing(replace(recording, gnss=fixes))
    assert found is not None
    assert found.begin >= 30.0


def test_sway_is_not_standing() -> None:
    recording = standing_then_moving(100.0, 0.0)
    sway = 3 * DEGREE * (2 * np.pi / 8) * np.cos(2 * np.pi * recording.imu.time / 8) * PERIOD
    swaying = replace(recording.imu, delta_angle=recording.imu.delta_angle + sway[:, None])
    assert longest_standing(Recording("ship", swaying)) is None
    with pytest.raises(InputError, match="neither stands for a while nor drives"):
        derive(Recording("ship", swaying))


def test_stretch_that_is_too_short_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"drive: from 0 to 5 s there are 4\.\d+ s of IMU samples; at least 10 s"
    ):
        between(standing_then_moving(), 0.0, 5.0)


def test_walk_that_stands_for_other_slow_noises() -> None:
    assert bias_walk({"white_noise": 1.0, "random_walk": 0.3}) == pytest.approx(0.3)
    markov = {"markov_sigma": 0.2, "markov_time": 1000.0}
    early = np.array([1.0])  # long before its correlation time, a Gauss-Markov process is a walk
    walk = {"random_walk": bias_walk({"white_noise": 1.0, **markov})}
    assert allan_deviation(walk, early) == pytest.approx(allan_deviation(markov, early), rel=1e-3)
    flicker = {"bias_instability": 0.2}
    walk = {"random_walk": bias_walk({"white_noise": 1.0, **flicker})}
    where = 1.0 / allan_deviation(flicker, np.array([1.0])) ** 2  # white noise has fallen to it
    assert allan_deviation(walk, where) == pytest.approx(allan_deviation(flicker, where))


def test_innovations_of_a_kalman_filter_tell_its_noises() -> None:
    q, r = 0.3, 2.0
    found = from_drive.fit(Ladder(q, r), {"q": 5.0, "r": 20.0})
    for name, true in (("q", q), ("r", r)):
        estimate = found.estimates[name]
        assert estimate.lower < true < estimate.upper
        assert estimate.value == pytest.approx(true, rel=0.15)
    assert np.mean(found.innovations.standardised**2) == pytest.approx(1.0, abs=0.02)
    assert found.innovations.tail == 1.0


def test_noise_that_innovations_do_not_show_is_not_told() -> None:
    found = from_drive.fit(Ladder(0.0, 2.0), {"q": 0.1, "r": 20.0})
    assert found.estimates["q"].lower == 0.0
    assert found.estimates["r"].lower > 0.0


def test_tails_widen_the_sigmas() -> None:
    z = np.random.default_rng(5).standard_t(3, size=(2000, 3)) / np.sqrt(3)
    heavy = Innovations(np.arange(2000.0), z, np.ones_like(z))
    assert heavy.tail > 1.1
    widened = Innovations(heavy.time, z, heavy.tail * heavy.sigma)
    assert np.mean(np.abs(widened.standardised) > 3) == pytest.approx(0.0027, abs=2e-4)


def test_file_holds_what_was_derived(tmp_path: Path) -> None:
    recording = standing_then_moving(300.0, 0.0)
    for name in (NAVIGATION_FILTER, ALIGNMENT_FILTER):
        found = derive(recording, filter_fmu=name)
        path = tmp_path / f"{name}.toml"
        path.write_text(found.toml(), encoding="utf-8")
        told = settings(None, [path])
        values = {n: v for key, text in told.items() for n, v in found.fmu.assignments(key, text).items()}
        expected = {finding.name: finding.value for finding in found.findings if finding.value is not None}
        assert values == pytest.approx(expected, rel=1e-5)
        assert values["process.angle_random_walk"] == pytest.approx(WHITE["gyro"], rel=0.1)
        assert values["process.velocity_random_walk"] == pytest.approx(WHITE["accelerometer"], rel=0.1)
        assert "at rest, " in found.toml()
        assert "# process.gyro_bias_random_walk: not told" in found.toml() or name == ALIGNMENT_FILTER


def test_slow_noises_of_a_vehicle_that_rocks_are_not_told() -> None:
    recording = standing_then_moving(600.0, 0.0)
    rocking = 20 * WHITE["gyro"] * np.sin(2 * np.pi * recording.imu.time / 12) * PERIOD
    imu = replace(recording.imu, delta_angle=recording.imu.delta_angle + rocking[:, None])
    found = derive(Recording("rocks", imu))
    assert {finding.name for finding in found.findings if finding.value is not None} <= {
        "process.angle_random_walk",
        "process.velocity_random_walk",
    }
    assert "these noises do not explain the scatter" in found.toml()


def test_bias_that_exceeds_the_rate_of_the_earth_is_told() -> None:
    recording = standing_then_moving(300.0, 0.0)
    bias = np.array([0.1, -0.2, 0.3]) * DEGREE
    imu = replace(recording.imu, delta_angle=recording.imu.delta_angle + bias * PERIOD)
    told = {f.name: f.value for f in derive(Recording("biased", imu)).findings}
    assert told["prior.gyro_bias_sigma"] == pytest.approx(np.linalg.norm(bias) / np.sqrt(3), rel=0.01)
    told = {f.name: f.value for f in derive(recording).findings}
    assert told["prior.gyro_bias_sigma"] is None


def test_other_fmus_have_no_noise_to_be_derived() -> None:
    with pytest.raises(
        InputError, match="filter TruthPlant: must be one of NavigationFilter, AlignmentFilter"
    ):
        derive(standing_then_moving(), filter_fmu="TruthPlant")


def test_command_writes_a_file_that_a_command_takes(tmp_path: Path) -> None:
    imu = standing_then_moving(60.0, 0.0).imu
    columns = [f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz"]
    table = pd.DataFrame(np.hstack([imu.delta_angle, imu.delta_velocity]), columns=columns)
    table.insert(0, "time", imu.time)
    table.to_csv(tmp_path / "rest.csv", index=False)
    chosen = [
        "--from",
        "5",
        "--to",
        "50",
        "--filter",
        "AlignmentFilter",
        "-o",
        str(tmp_path / "out"),
        "--json",
    ]
    command = [sys.executable, "-m", "sim_scenarios.cli", "derive", str(tmp_path / "rest.csv"), *chosen]
    told = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    walk = told["parameters"]["process.angle_random_walk"]
    assert walk["value"] == pytest.approx(WHITE["gyro"], rel=0.3)
    assert any("at rest, 5" in line for line in walk["evidence"])
    assert (tmp_path / "out" / "allan.png").read_bytes().startswith(b"\x89PNG")
    used = settings(None, [Path(told["file"])])
    assert used["process.angle_random_walk"].endswith("deg/h^0.5")


def test_command_tells_what_is_likely_wrong(tmp_path: Path) -> None:
    imu = standing_then_moving(60.0, 0.0).imu
    sideways = replace(imu, delta_velocity=imu.delta_velocity[:, [2, 1, 0]])
    imu_cells(sideways).to_csv(tmp_path / "rest.csv", index=False)
    told = CliRunner().invoke(app, ["derive", str(tmp_path / "rest.csv"), "-o", str(tmp_path / "out")])
    assert told.exit_code == 0, told.output
    assert "it points sideways" in told.stderr


def test_settings_of_the_command_line_go_before_those_of_files(tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text('process.angle_random_walk = "0.2 deg/h^0.5"\n[prior]\nheading_sigma = "3 deg"\n')
    second.write_text("process.angle_random_walk = 1e-5\n")
    assert settings(["prior.heading_sigma=0.5"], [first, second]) == {
        "process.angle_random_walk": 1e-5,
        "prior.heading_sigma": 0.5,
    }
    with pytest.raises(InputError, match=r"missing\.toml: cannot be read"):
        settings(None, [tmp_path / "missing.toml"])


def test_drive_without_enough_fixes_is_refused() -> None:
    with pytest.raises(InputError, match="has no fixes"):
        from_drive.from_drive(standing_then_moving())


def test_a_drive_that_is_too_short_leaves_what_the_rest_tells(fmus: Fmus) -> None:
    """From stoplight to stoplight, a minute after a minute's rest; without that there is nothing to tell."""
    town, period, random = TownDrive().recording(60.0), 0.01, np.random.default_rng(1)
    assert town.gnss is not None
    rest = 0.2 * np.sqrt(period) * WHITE["gyro"] * random.standard_normal((6000, 3))
    force = np.sqrt(period) * WHITE["accelerometer"] * random.standard_normal((6000, 3))
    force[:, 2] += STANDARD_GRAVITY * period
    later = 6000 * period
    imu = ImuTable(
        np.concatenate([town.imu.time[0] - period + period * np.arange(1, 6001), town.imu.time + later]),
        np.concatenate([rest, town.imu.delta_angle]),
        np.concatenate([force, town.imu.delta_velocity]),
    )
    short = Recording("short", imu, replace(town.gnss, time=town.gnss.time + later))
    derived = derive(short, begin=1.0, end=59.0, fmus=fmus)
    assert derived.drive is None
    assert derived.unused is not None
    assert "at least 100 are needed" in derived.unused
    assert "the stretch at rest alone is told" in derived.toml()
    told = {finding.name: finding.value for finding in derived.findings}
    assert told["process.angle_random_walk"] == pytest.approx(0.2 * WHITE["gyro"], rel=0.3)
    with pytest.raises(InputError, match=r"the drive from .* at least 100 are needed"):
        derive(town, fmus=fmus)


def test_noises_of_a_short_rest_of_the_plant(fmus: Fmus) -> None:
    stretch = longest_standing(at_rest_of_plant(fmus, {"walk"}, 1200.0, seed=1))
    assert stretch is not None
    for sensor, triad in at_rest(stretch).sensors.items():
        assert triad.joint.explains
        for name, size in simulated(sensor, {"walk"}).items():
            estimate = triad.joint.estimates[name]
            assert 0.8 * estimate.lower < size < 1.25 * estimate.upper
        assert triad.joint.estimates["white_noise"].value == pytest.approx(WHITE[sensor], rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("parts", [{"walk"}, {"markov"}], ids=["walk", "markov"])
def test_noises_of_two_hours_at_rest(parts: set[str], seed: int, fmus: Fmus) -> None:
    # The sigma of the best unbiased estimate is 7 and 2 % of the walks, 5 % of the Gauss-Markov sigmas.
    stretch = longest_standing(at_rest_of_plant(fmus, parts, TWO_HOURS, seed))
    assert stretch is not None
    assert stretch.end - stretch.begin > 0.99 * TWO_HOURS
    for sensor, triad in at_rest(stretch).sensors.items():
        assert triad.alike
        assert triad.joint.explains
        for name, size in simulated(sensor, parts).items():
            estimate = triad.joint.estimates[name]
            assert estimate.lower > 0
            if name != "markov_time":  # of which the best estimate has a sigma of 10 to 15 %
                assert estimate.value == pytest.approx(size, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_all_noises_together_in_two_hours(seed: int, fmus: Fmus) -> None:
    # Here the best unbiased estimate of the walk has a sigma of 20 %, of the Gauss-Markov sigma 13 %: what
    # can be asked of a single recording is that the intervals, a fifth wider, hold the truth.
    parts = {"walk", "markov"}
    stretch = longest_standing(at_rest_of_plant(fmus, parts, TWO_HOURS, seed))
    assert stretch is not None
    for sensor, triad in at_rest(stretch).sensors.items():
        assert triad.joint.estimates["white_noise"].value == pytest.approx(WHITE[sensor], rel=0.05)
        for name, size in simulated(sensor, parts).items():
            estimate = triad.joint.estimates[name]
            assert estimate.lower / 1.2 < size < estimate.upper * 1.2


FLIGHT = {
    "communication_step": 0.1,
    "imu.gyro.white_noise": "0.2 deg/h^0.5",
    "imu.gyro.bias_sigma": "20 deg/h",
    "imu.accelerometer.white_noise": "300 ug/Hz^0.5",
    "imu.accelerometer.bias_sigma": "2 mg",
    "gnss.position_sigma": [2.0, 2.0, 4.0],
    "gnss.velocity_sigma": 0.1,
}


@pytest.mark.slow
def test_drive_of_the_plant(fmus: Fmus) -> None:
    start = Start(heading=0.0, heading_sigma=2 * DEGREE)
    drive = sensed(fmus, "flight_constant_speed", 2400.0, seed=1, settings={**FLIGHT, "duration": 2400.0})
    told = {f.name: f.value for f in derive(drive, start=start, fmus=fmus).findings if f.value is not None}
    true = {
        "measurement.position_sigma": 2.0,
        "measurement.height_sigma": 4.0,
        "measurement.velocity_sigma": 0.1,
        "process.angle_random_walk": 0.2 * DEGREE / np.sqrt(HOUR),
    }
    assert {name: told[name] for name in true} == pytest.approx(true, rel=0.2)
    # NIS of other seeds with these parameters, each in its 95 % interval; one of four may be outside.
    inside = 0
    for seed in (2, 3, 4, 5):
        other = sensed(
            fmus, "flight_constant_speed", 700.0, seed=seed, settings={**FLIGHT, "duration": 1000.0}
        )
        data = replay(
            other, start, filter=Filter.navigation, set={"predictor": "linearised", **told}, fmus=fmus
        )
        settled = data["fix_time"].values > from_drive.SETTLING
        channels = np.count_nonzero(data["innovation_sigma"].values[settled] > 0)
        low, high = chi2.ppf([0.025, 0.975], channels)
        inside += low < data["nis"].values[settled].sum() < high
    assert inside >= 3


def test_toml_of_a_table_is_read_by_dotted_names() -> None:
    assert dict(toml.dotted({"a": {"b": 1, "c": {"d": 2}}, "e": 3})) == {"a.b": 1, "a.c.d": 2, "e": 3}
