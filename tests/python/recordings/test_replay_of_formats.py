"""Signals of the plant through the files of every format: what comes back, and what a filter makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from plant_signals import sensed, told_as_in
from scipy.io import savemat
from written import kf_gins, nmea, novatel, psins, rtklib, ubx, ulog

import sim_scenarios
from sim_scenarios import Start
from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings.readers.gps_time import DAY, WEEK
from sim_scenarios.recordings.stamps import intervals
from sim_scenarios.recordings.tables import Array, Recording
from sim_scenarios.recordings.units import VELOCITY
from sim_scenarios.units import DEGREE

pytest.importorskip("pyubx2", reason="reading UBX needs pyubx2")
pytest.importorskip("pyulog", reason="reading ULog needs pyulog")
pytest.importorskip("rosbags", reason="reading ROS bags needs rosbags")
from written import ros

SECONDS = 100.0
PERIOD = 0.01  # s
FILTER = {
    "error_model": "invariant",  # uses whole fixes
    "predictor": "linearised",
    "corrector": "standard",
    "coarse.enabled": False,  # at first its heading hangs on the last bit of the numbers
    "measurement.position_sigma": 5.0,
    "measurement.height_sigma": 5.0,
}
SIGMAS = (0.01, 0.01, 0.01)
"""Those that the filter is told are larger, and count."""
OUTPUTS = (
    *("nav.heading", "nav.latitude", "nav.longitude", "nav.height", "nav.velocity"),
    *("heading_sigma", "gyro_bias", "nis"),
)
NOON = 216000.0  # s of the week
DRAWS = 4
WORST = 3.0
"""How many times as far as the worst of the draws a result may lie."""

Step = Callable[[Array], Array]
"""Distance between the numbers that a format can write near some values."""


@dataclass(frozen=True)
class Format:
    """Files with an IMU and fixes, and how finely they carry them."""

    write: Callable[[Recording, Path], str]
    """Writes files into a folder, and gives the content of recording.toml."""
    steps: Mapping[str, Step] = field(default_factory=dict)
    """What has none is carried whole."""
    carried: Callable[[Recording], Recording] = lambda signals: signals
    """Signals without what the format has no place for."""
    rates: bool = False
    """Its increments are rates times steps between stamps, which count from midnight."""


def of(*step: float) -> Step:
    """The same everywhere."""
    return lambda values: np.broadcast_to(step, values.shape)


def single(values: Array) -> Array:
    """Of numbers in single precision."""
    return np.spacing(np.abs(values).astype(np.float32)).astype(float)


def single_rates(increments: Array) -> Array:
    """Of increments that come of rates in single precision."""
    return PERIOD * single(increments / PERIOD)


def over_ground(speed: float, course: float, up: float) -> Step:
    """Of a speed [m/s] and a course [deg]: each turns up in the velocities east and north."""

    def step(velocity: Array) -> Array:
        flat = speed + np.linalg.norm(velocity[:, :2], axis=1) * course * DEGREE
        return np.column_stack((flat, flat, np.full(len(flat), up)))

    return step


def ned(vectors: Array) -> Array:
    """Right, forward, up as forward, right, down; east, north, up as north, east, down; and back."""
    turned: Array = vectors[:, [1, 0, 2]] * [1, 1, -1]
    return turned


def flu(vectors: Array) -> Array:
    """Right, forward, up as forward, left, up."""
    turned: Array = vectors[:, [1, 0, 2]] * [1, -1, 1]
    return turned


def in_degrees(position: Array) -> Array:
    degrees: Array = position / [DEGREE, DEGREE, 1]
    return degrees


def course(velocity: Array) -> tuple[float, float]:
    """Speed over ground [m/s] and course [deg]."""
    return float(np.hypot(*velocity[:2])), float(np.degrees(np.arctan2(*velocity[:2])) % 360)


def kf_gins_imu(signals: Recording, folder: Path, since: float = 0.0) -> None:
    imu = signals.imu
    table = np.column_stack((imu.time + since, ned(imu.delta_angle), ned(imu.delta_velocity)))
    kf_gins.written(folder / "imu.txt", table)


def kf_gins_fixes(signals: Recording, folder: Path) -> None:
    fixes, sigmas = signals.gnss, np.tile(SIGMAS, (len(signals.gnss.time), 1))
    parts = (fixes.time, in_degrees(fixes.position), sigmas, ned(fixes.velocity), sigmas)
    kf_gins.written(folder / "gnss.txt", np.column_stack(parts))


def of_kf_gins(signals: Recording, folder: Path) -> str:
    kf_gins_imu(signals, folder)
    kf_gins_fixes(signals, folder)
    return '[imu]\nfile = "imu.txt"\n[gnss]\nfile = "gnss.txt"\n'


def psins_imu(signals: Recording) -> Array:
    return np.column_stack((signals.imu.delta_angle, signals.imu.delta_velocity, signals.imu.time))


def of_psins_arrays(signals: Recording, folder: Path) -> str:
    gps = np.column_stack((signals.gnss.velocity, signals.gnss.position, signals.gnss.time))
    savemat(folder / "ship.mat", {"imu": psins_imu(signals), "gps": gps})
    return '[imu]\nfile = "ship.mat"\n[gnss]\n'


def of_psins_doubles(signals: Recording, folder: Path) -> str:
    kf_gins_fixes(signals, folder)
    (folder / "imu.bin").write_bytes(psins_imu(signals).tobytes())
    return '[imu]\nfile = "imu.bin"\n[gnss]\nfile = "gnss.txt"\n'


PSINS_COUNT = (psins.ANGLE * DEGREE / 3600, psins.VELOCITY * 1e-6 * psins.GRAVITY)


def of_psins_counts(signals: Recording, folder: Path) -> str:
    kf_gins_fixes(signals, folder)
    angle, velocity = PSINS_COUNT
    counts = np.hstack((signals.imu.delta_angle / angle, signals.imu.delta_velocity / velocity))
    psins.counted(folder / "ship.imu", np.rint(counts))
    return '[imu]\nfile = "ship.imu"\n[gnss]\nfile = "gnss.txt"\n'


def of_ros(signals: Recording, folder: Path, kind: str) -> str:
    imu, gnss = signals.imu, signals.gnss
    covers = intervals(imu.time)[:, None]
    turns, forces = flu(imu.delta_angle / covers), flu(imu.delta_velocity / covers)
    messages = [
        ("/imu", ros.IMU, ros.inertial(*sample)) for sample in zip(imu.time, turns, forces, strict=True)
    ]
    variances = (1e-4, 1e-4, 1e-4)
    for time, place, velocity in zip(gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True):
        messages.append(("/fix", ros.FIX, ros.fix(time, place=place)))
        messages.append(("/vel", ros.UNCERTAIN, ros.uncertain_twist(time, "gps", variances, velocity)))
    path = ros.written(folder, kind, messages)
    return f'[imu]\nfile = "{path.name}"\n[gnss]\n'


def of_ulog(signals: Recording, folder: Path, increments: bool) -> str:
    """Stamps count from 20 s after the autopilot's start."""
    imu, gnss = signals.imu, signals.gnss
    stamps = [round((20 + time) * 1e6) for time in imu.time]
    period = round(1e6 * (imu.time[1] - imu.time[0]))
    if increments:
        name, fields = "vehicle_imu", ulog.INCREMENTS
        rows = [
            (stamp, (stamp, *angle, *velocity, period))
            for stamp, angle, velocity in zip(
                stamps, ned(imu.delta_angle), ned(imu.delta_velocity), strict=True
            )
        ]
    else:
        name, fields = "sensor_combined", ulog.IMU
        covers = intervals(imu.time)[:, None]
        rows = [
            (stamp, (*turn, period, *force, period))
            for stamp, turn, force in zip(
                stamps, ned(imu.delta_angle / covers), ned(imu.delta_velocity / covers), strict=True
            )
        ]
    fixes = []
    for time, (*flat, height), velocity in zip(
        gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True
    ):
        stamp = round((20 + time) * 1e6)
        north, east, down = ned(velocity[None])[0]
        moving = (0.01, 0.01, 0.01, north, east, down, np.nan)
        fixes.append((stamp, (stamp, *flat, height, height, *moving, 0.0, 3, True)))
    ulog.written(folder / "ship.ulg", {name: (fields, rows), "sensor_gps": (ulog.NEW_FIX, fixes)})
    return '[imu]\nfile = "ship.ulg"\n[gnss]\n'


LITTON = (2.0**-33, 2.0**-27 * 0.3048)
"""What a count of the IMU 11 is worth [rad, m/s]."""


def of_novatel(signals: Recording, folder: Path) -> str:
    imu, gnss = signals.imu, signals.gnss
    counts = np.rint(np.hstack((imu.delta_velocity / LITTON[1], imu.delta_angle / LITTON[0]))).astype(int)
    logs = [
        novatel.raw_imu(11, row.tolist(), NOON + time) for time, row in zip(imu.time, counts, strict=True)
    ]
    for time, place, velocity in zip(gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True):
        above_geoid = (place[0], place[1], place[2] - novatel.UNDULATION)
        logs.append(novatel.best_position(place=above_geoid, seconds=NOON + time))
        motion = (*course(velocity), velocity[2])
        logs.append(novatel.best_velocity(motion=motion, seconds=NOON + time))
    novatel.written(folder / "span.log", *logs)
    return '[imu]\nfile = "span.log"\naxes = "right-forward-up"\n[gnss]\n'


def beside_an_imu_of_the_week(signals: Recording, folder: Path, fixes: str) -> str:
    kf_gins_imu(signals, folder, since=NOON)
    return f'[imu]\nfile = "imu.txt"\nclock = "gps-week"\n[gnss]\nfile = "{fixes}"\n'


def of_rtklib(signals: Recording, folder: Path) -> str:
    gnss = signals.gnss
    rows = [
        rtklib.row(f"2350 {NOON + time:.3f}", place=tuple(place), velocity=tuple(velocity))
        for time, place, velocity in zip(gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True)
    ]
    path = rtklib.written(folder, rtklib.of_rows(rows))
    return beside_an_imu_of_the_week(signals, folder, path.name)


def of_nmea(signals: Recording, folder: Path) -> str:
    """Coordinated time is 18 s behind on the Tuesday of the week 2350."""
    sentences = []
    gnss = signals.gnss
    for time, place, velocity in zip(gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True):
        minutes, seconds = divmod(round(time) - 18, 60)
        stamp = f"{12 + minutes // 60:02d}{minutes % 60:02d}{seconds:02d}.00"
        speed, along = course(velocity)
        knots = f"{speed / VELOCITY['knot']:.3f}"
        sentences.append(nmea.rmc(stamp, "210125", knots, f"{along:.2f}"))
        sentences.append(nmea.gga(stamp, place[0], place[1], f"{place[2] + 30.5:.3f}"))
    nmea.written(folder / "gnss.nmea", *sentences)
    return beside_an_imu_of_the_week(signals, folder, "gnss.nmea")


def flat(signals: Recording) -> Recording:
    """Without velocities upwards."""
    return replace(signals, gnss=replace(signals.gnss, velocity=signals.gnss.velocity * [1, 1, np.nan]))


def of_ubx(signals: Recording, folder: Path, precise: bool) -> str:
    frames = []
    gnss = signals.gnss
    for time, place, velocity in zip(gnss.time, in_degrees(gnss.position), gnss.velocity, strict=True):
        tow = round((NOON + time) * 1e3)
        coarse = np.rint(place * [1e7, 1e7, 1e3]).astype(int)
        fine = np.rint(place * [1e9, 1e9, 1e4]).astype(int) - coarse * [100, 100, 10]
        at, beyond = (
            dict(zip(("lat", "lon", "height"), part.tolist(), strict=True)) for part in (coarse, fine)
        )
        moving = np.rint(1e3 * ned(velocity[None])[0]).astype(int).tolist()
        frames.append(ubx.pvt(tow, at=at, moving=dict(zip(("north", "east", "down"), moving, strict=True))))
        if precise:
            frames.append(ubx.precise(tow, at=at, beyond=beyond))
    ubx.written(folder / "gnss.ubx", *frames)
    return beside_an_imu_of_the_week(signals, folder, "gnss.ubx")


MINUTE = DEGREE / 60
FORMATS = {
    "KF-GINS": Format(of_kf_gins),
    "PSINS .mat": Format(of_psins_arrays),
    "PSINS .bin": Format(of_psins_doubles),
    "PSINS .imu": Format(
        of_psins_counts, {"delta_angle": of(PSINS_COUNT[0]), "delta_velocity": of(PSINS_COUNT[1])}
    ),
    "ROS 1": Format(partial(of_ros, kind="one.bag"), rates=True),
    "ROS 2": Format(partial(of_ros, kind="sqlite"), rates=True),
    "MCAP": Format(partial(of_ros, kind="mcap"), rates=True),
    "ULog, rates": Format(
        partial(of_ulog, increments=False),
        {"delta_angle": single_rates, "delta_velocity": single_rates, "velocity": single},
        rates=True,
    ),
    "ULog, increments": Format(
        partial(of_ulog, increments=True),
        {"delta_angle": single, "delta_velocity": single, "velocity": single},
    ),
    "NovAtel": Format(
        of_novatel,
        {
            "delta_angle": of(LITTON[0]),
            "delta_velocity": of(LITTON[1]),
            "position": of(1e-11 * DEGREE, 1e-11 * DEGREE, 1e-4),
            "velocity": over_ground(1e-4, 1e-6, 1e-4),
        },
    ),
    "RTKLIB": Format(of_rtklib, {"position": of(1e-9 * DEGREE, 1e-9 * DEGREE, 1e-4), "velocity": of(1e-5)}),
    "NMEA": Format(
        of_nmea,
        {
            "position": of(1e-7 * MINUTE, 1e-7 * MINUTE, 1e-3),
            "velocity": over_ground(1e-3 * VELOCITY["knot"], 0.01, 0.0),
        },
        flat,
    ),
    "UBX": Format(
        partial(of_ubx, precise=False),
        {"position": of(1e-7 * DEGREE, 1e-7 * DEGREE, 1e-3), "velocity": of(1e-3)},
    ),
    "UBX, precise": Format(
        partial(of_ubx, precise=True),
        {"position": of(1e-9 * DEGREE, 1e-9 * DEGREE, 1e-4), "velocity": of(1e-3)},
    ),
}


def values(signals: Recording) -> dict[str, Array]:
    """What formats carry more or less finely."""
    imu, gnss = signals.imu, signals.gnss
    return {
        "delta_angle": imu.delta_angle,
        "delta_velocity": imu.delta_velocity,
        "position": gnss.position,
        "velocity": gnss.velocity,
    }


def drawn(signals: Recording, steps: Mapping[str, Step], seed: int) -> Recording:
    """Signals off by up to half a step, evenly distributed."""
    random = np.random.default_rng(seed)
    off = {
        name: value + steps[name](value) * random.uniform(-0.5, 0.5, value.shape)
        for name, value in values(signals).items()
        if name in steps
    }
    imu = {name: value for name, value in off.items() if name.startswith("delta")}
    gnss = {name: value for name, value in off.items() if name not in imu}
    return replace(signals, imu=replace(signals.imu, **imu), gnss=replace(signals.gnss, **gnss))


def furthest(run: xr.Dataset, other: xr.Dataset) -> dict[str, float]:
    """Largest difference of each output."""
    apart = {name: run[name].values - other[name].values for name in OUTPUTS}
    apart["nav.heading"] = wrap(apart["nav.heading"])
    return {name: float(np.max(np.abs(difference))) for name, difference in apart.items()}


@pytest.fixture(scope="module")
def ship(all_fmus: Fmus) -> Recording:
    return replace(sensed(all_fmus, "swaying_ship", SECONDS), reference=None)


@pytest.fixture(scope="module")
def told(all_fmus: Fmus) -> dict[str, object]:
    return {**told_as_in("swaying_ship", all_fmus), **FILTER}


@pytest.fixture(scope="module")
def direct(all_fmus: Fmus) -> xr.Dataset:
    """The run without any file."""
    times = {"duration": SECONDS, "evaluation.start": SECONDS / 2, "evaluation.stop": SECONDS}
    settings = {**times, **{f"filter.{name}": value for name, value in FILTER.items()}}
    return sim_scenarios.run("swaying_ship", seed=21, set=settings, fmus=all_fmus)


@pytest.fixture(scope="module", params=FORMATS)
def described(
    request: pytest.FixtureRequest, ship: Recording, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Format, Path]:
    """A format, and the description of the ship in its files."""
    form, folder = FORMATS[request.param], tmp_path_factory.mktemp("ship")
    path = folder / "recording.toml"
    path.write_text(form.write(ship, folder))
    return form, path


def test_a_format_carries_signals_to_its_resolution(described: tuple[Format, Path], ship: Recording) -> None:
    form, path = described
    read, sent = load_recording(path), form.carried(ship)
    for came, went in ((read.imu.time, sent.imu.time), (read.gnss.time, sent.gnss.time)):
        since = came - (read.gnss.time[0] - sent.gnss.time[0])
        np.testing.assert_allclose(since, went, rtol=0, atol=np.spacing(WEEK))
    for quantity, value in values(sent).items():
        step = form.steps[quantity](value) if quantity in form.steps else np.zeros_like(value)
        off = np.abs(values(read)[quantity] - value)
        np.testing.assert_array_equal(np.isnan(off), np.isnan(value))
        exact = np.spacing(DAY) / PERIOD if form.rates and quantity.startswith("delta") else 1e-15
        allowed = step / 2 * (1 + 1e-6) + exact * np.abs(value)
        assert np.nanmax(off - allowed) <= 0, quantity


def test_a_replay_equals_the_direct_run(
    described: tuple[Format, Path],
    ship: Recording,
    told: dict[str, object],
    direct: xr.Dataset,
    all_fmus: Fmus,
) -> None:
    """To 1e-9 of what a format carries whole; else no further off than signals that are off by its steps.

    How far that is, is drawn: the same filter with the signals themselves, off by up to half a step.
    """
    form, path = described

    def replayed(recording: Path | Recording) -> xr.Dataset:
        return sim_scenarios.replay(recording, Start(0.0), set=told, fmus=all_fmus)

    sent = form.carried(ship)
    expected = direct if sent is ship else replayed(sent)
    allowed = {output: 1e-9 * float(np.max(np.abs(expected[output]))) for output in OUTPUTS}
    for seed in range(DRAWS if form.steps else 0):
        for output, off in furthest(replayed(drawn(sent, form.steps, seed)), expected).items():
            allowed[output] = max(allowed[output], WORST * off)
    found = furthest(replayed(path), expected)
    assert {output: off for output, off in found.items() if off > allowed[output]} == {}
