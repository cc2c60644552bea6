"""A recorded IMU through the alignment filter.

The recording is a CSV file (or .csv.gz) with a header. Columns, in any order:

    time                              end of the interval that the increments cover [s]
    delta_angle_x, _y, _z             integral of the body rate (right, forward, up) [rad]
    delta_velocity_x, _y, _z          integral of the specific force (right, forward, up) [m/s]

and, unless fixes of zero velocity are made up, GNSS, with empty cells in the rows that have no fix:

    gnss_velocity_east, _north, _up   velocity of the antenna [m/s]; a row with gnss_velocity_east has a fix
    gnss_latitude, gnss_longitude     [deg]
    gnss_height                       above the ellipsoid [m]
    gnss_time                         time of validity of the fix [s]; optional, else the row's time

The initial roll and pitch come from levelling: at rest the mean specific force of the first seconds points
up,

    pitch = atan2(f_y, sqrt(f_x^2 + f_z^2)),   roll = atan2(-f_x, f_z).
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.cosimulation import Progress, RecordedSource, Sink, connected, simulate
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Number, did_you_mean, load
from sim_scenarios.instance import Instance
from sim_scenarios.units import DEGREE, STANDARD_GRAVITY

Array = NDArray[np.float64]

IMU_COLUMNS = [f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz"]
GNSS_VELOCITY = [f"gnss_velocity_{axis}" for axis in ("east", "north", "up")]
GNSS_POSITION = ["gnss_latitude", "gnss_longitude", "gnss_height"]
GNSS_TIME = "gnss_time"
COLUMNS = ["time", *IMU_COLUMNS, *GNSS_VELOCITY, *GNSS_POSITION, GNSS_TIME]
MOST_SAMPLES = 2**31 - 1  # fmi2Integer
RECORDING_PERIOD = 0.1  # s
RECORDINGS = "TRUENORTH_RECORDINGS"
"""Environment variable that names the folder of recordings that do not come with the package."""


@dataclass(frozen=True)
class ZeroVelocity:
    """Fixes of a vehicle that stands: latitude [deg], longitude [deg], height [m]; sigma [m/s], rate [Hz]."""

    position: tuple[float, float, float]
    sigma: float = 0.02
    rate: float = 1.0


@dataclass(frozen=True)
class Start:
    """What is known at the start: heading and its sigma [rad], seconds of standstill used for levelling."""

    heading: float
    heading_sigma: float = 10.0 * DEGREE
    levelling: float = 1.0


def replay(
    path: str | Path,
    start: Start,
    *,
    zero_velocity: ZeroVelocity | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    progress: Progress = lambda _: None,
    fmu: Fmu | None = None,
) -> xr.Dataset:
    """Align on a recording.

    Parameters
    ----------
    path : str or Path
        CSV file, possibly compressed with gzip.
    start : Start
        Heading to start from.
    zero_velocity : ZeroVelocity, optional
        Fixes of zero velocity in the place of recorded GNSS.
    set : mapping, optional
        Parameters of the AlignmentFilter by name, in SI units or with a unit.
    progress : callable
        Called with the completed share.
    fmu : Fmu, optional
        The AlignmentFilter, to load it once for many recordings.

    Returns
    -------
    xarray.Dataset
        As that of `sim_scenarios.run`, without truth.
    """
    _check_finite(start, zero_velocity)
    fmu = fmu or load(ALIGNMENT_FILTER)
    table = read_recording(Path(path))
    imu = signals_of_imu(table)
    gnss = (
        _zero_velocity_fixes(table["time"].to_numpy(), zero_velocity)
        if zero_velocity
        else _recorded_fixes(table, path)
    )
    values = parameters(table, start, gnss, zero_velocity, set or {}, fmu)
    columns = {**imu, **gnss}
    source = RecordedSource([fmu.variables[name] for name in connected(columns, fmu)], columns)
    times = columns["imu.time"]
    record_every = max(1, round(RECORDING_PERIOD / float(np.median(np.diff(times)))))
    with closing(Instance(fmu, "filter", values)) as instance:
        instance.begin_initialisation(float(times[0]), float(times[-1]))
        sink = Sink(instance, source)
        sink.receive()
        instance.finish_initialisation()
        recorded = simulate(
            source,
            [sink],
            times,
            record_every=record_every,
            fix_outputs=recording.fix_outputs(fmu),
            progress=progress,
        )
    data = recording.of_filter(recording.dataset(recorded, ["filter"], fmu), "filter")
    data.attrs = {
        "recording": str(path),
        "description": f"{Path(path).name}, started at a heading of {start.heading / DEGREE:.6g} deg",
        "settings": json.dumps({"filter": {n: fmu.variables[n].display(v) for n, v in values.items()}}),
        "versions": json.dumps({fmu.name: fmu.guid}),
        "messages": json.dumps([str(message) for message in instance.messages]),
    }
    return data


def recording_named(name: str) -> Path | None:
    """A recording that does not come with the package, if its folder is named and holds it."""
    folder = os.environ.get(RECORDINGS)
    path = Path(folder or "", name)
    return path if folder and path.is_file() else None


def read_recording(path: Path) -> pd.DataFrame:
    """Recording of a file, checked."""
    try:
        table = pd.read_csv(path)
    except FileNotFoundError:
        raise InputError(f"there is no recording {path}") from None
    except (OSError, ValueError, EOFError, zlib.error) as error:  # the last two of a damaged .csv.gz
        raise InputError(f"{path}: cannot be read as a CSV file: {error}") from None
    for column in ("time", *IMU_COLUMNS):
        if column not in table:
            raise InputError(
                f"{path}: there is no column {column}{did_you_mean(column, list(map(str, table.columns)))}"
            )
    if len(table) < 2:
        raise InputError(f"{path}: has {len(table)} samples; an alignment needs many")
    for column in table.columns.intersection(COLUMNS):
        if not pd.api.types.is_numeric_dtype(table[column]) or pd.api.types.is_bool_dtype(table[column]):
            raise InputError(f"{path}: column {column} holds something that is not a number")
    unknown = np.flatnonzero(~np.isfinite(table["time"]))
    if len(unknown):
        raise InputError(f"{path}: line {unknown[0] + 2}: time must be a finite number")
    backwards = np.flatnonzero(np.diff(table["time"]) <= 0)
    if len(backwards):
        raise InputError(f"{path}: line {backwards[0] + 3}: time must increase from each sample to the next")
    _check_increments(table, path)
    return table


def _check_increments(table: pd.DataFrame, path: Path) -> None:
    """On Earth the specific force is about 9.8 m/s2 in the mean, so the increments tell their unit."""
    size = np.linalg.norm(table[IMU_COLUMNS[3:]].to_numpy(dtype=float), axis=1)
    if not np.isfinite(size).any():
        raise InputError(f"{path}: no sample has a delta_velocity")
    mean = float(np.mean(size[np.isfinite(size)]))
    period = float(np.median(np.diff(table["time"])))
    low, high = STANDARD_GRAVITY / 2, STANDARD_GRAVITY * 2
    if low < mean / period < high:
        return
    if low < mean < high:
        raise InputError(
            f"{path}: the file seems to hold rates, not increments: |delta_velocity| is {mean:.3g} in the "
            f"mean, which is a specific force in m/s2; multiply all six columns by the sample period of "
            f"{period:g} s"
        )
    raise InputError(
        f"{path}: |delta_velocity| / dt is {mean / period:.3g} m/s2 in the mean, but an IMU on Earth feels "
        f"about 9.8 m/s2; delta_velocity must be an increment in m/s over {period:g} s"
    )


def residuals(path: Path, period: float, span: float) -> dict[str, Array]:
    """What the increments of a recording at rest have besides their mean over a span of time.

    Of a vehicle that stands it is the noise of the sensors and what shakes them, without biases, the Earth
    and what changes more slowly than over the span.

    Parameters
    ----------
    path : Path
        As for `replay`.
    period : float
        Of the samples [s]; a recording with another one is refused.
    span : float
        [s]

    Returns
    -------
    dict of str to ndarray, shape (samples,)
        By the names of the IMU's signals.
    """
    table = read_recording(path)
    found = float(np.median(np.diff(table["time"])))
    if abs(found - period) > 1e-3 * period:
        raise InputError(f"{path}: a sample every {found:g} s, where {period:g} s are needed")
    increments = table[IMU_COLUMNS]
    rest = increments - increments.rolling(round(span / period), center=True, min_periods=1).mean()
    names = [f"imu.delta_{kind}[{i}]" for kind in ("angle", "velocity") for i in (1, 2, 3)]
    return {name: rest[column].to_numpy() for name, column in zip(names, IMU_COLUMNS, strict=True)}


def level(force: Array) -> tuple[float, float]:
    """Roll and pitch [rad] at which a specific force in body axes points up; shape (3,)."""
    x, y, z = force
    return float(np.arctan2(-x, z)), float(np.arctan2(y, np.hypot(x, z)))


def signals_of_imu(table: pd.DataFrame) -> dict[str, NDArray[np.float64]]:
    """IMU signals at the start and after each sample. A gap in time is a jump of the sample counter."""
    time = table["time"].to_numpy(dtype=float)
    period = float(np.median(np.diff(time)))
    if (time[-1] - time[0]) / period >= MOST_SAMPLES:
        raise InputError(
            f"the recording covers {time[-1] - time[0]:g} s with a sample every {period:g} s: they must be "
            f"at most {MOST_SAMPLES}, those that are missing included"
        )
    index = np.arange(len(time))
    sample = np.maximum.accumulate(np.rint((time - time[0]) / period) - index) + index + 1
    signals = {"imu.sample": sample, "imu.time": time}
    for kind in ("angle", "velocity"):
        for i, axis in enumerate("xyz"):
            signals[f"imu.delta_{kind}[{i + 1}]"] = table[f"delta_{kind}_{axis}"].to_numpy(dtype=float)
    return {
        name: np.concatenate(([_before(name, values, period)], values)) for name, values in signals.items()
    }


def parameters(
    table: pd.DataFrame,
    start: Start,
    gnss: Mapping[str, Array],
    zero_velocity: ZeroVelocity | None,
    settings: Mapping[str, object],
    fmu: Fmu,
) -> dict[str, Number]:
    """Parameters of the filter: initial state from the recording, then the user's settings."""
    time = table["time"].to_numpy()
    period = float(np.median(np.diff(time)))
    first = time < time[0] - period + start.levelling + period / 2
    if start.levelling <= 0 or not first.any():
        raise InputError(f"levelling = {start.levelling:g} s: must cover at least one sample ({period:g} s)")
    roll, pitch = level(table.loc[first, IMU_COLUMNS[3:]].mean().to_numpy())
    values: dict[str, Number] = {
        "initial.roll": roll,
        "initial.pitch": pitch,
        "initial.heading": start.heading,
        **{f"initial.{name}": float(gnss[f"gnss.{name}"][0]) for name in ("latitude", "longitude", "height")},
        **{f"initial.velocity[{i}]": float(gnss[f"gnss.velocity[{i}]"][0]) for i in (1, 2, 3)},
        "prior.heading_sigma": start.heading_sigma,
    }
    if zero_velocity:
        values["measurement.velocity_sigma"] = zero_velocity.sigma
    for name, value in settings.items():
        known = name if fmu.has_parameter(name) else name.removeprefix("filter.")
        values |= fmu.assignments(known, value)
    return values


def _check_finite(start: Start, aiding: ZeroVelocity | None) -> None:
    given = vars(start) | ({} if aiding is None else vars(aiding))
    for name, value in given.items():
        if not np.isfinite(value).all():
            raise InputError(f"{name} = {value}: must be finite")
    if start.heading_sigma < 0:
        raise InputError(f"heading_sigma = {start.heading_sigma:g} rad: must be at least 0")


def _before(name: str, values: Array, period: float) -> float:
    """Signal of the IMU at the start, one period before the first sample."""
    known = {"imu.sample": float(values[0]) - 1, "imu.time": float(values[0]) - period}
    return known.get(name, 0.0)


def _zero_velocity_fixes(time: Array, aiding: ZeroVelocity) -> dict[str, Array]:
    period = float(np.median(np.diff(time)))
    if aiding.rate <= 0 or aiding.sigma <= 0:
        raise InputError("zero-velocity fixes need a rate and a sigma greater than 0")
    if aiding.rate * period > 1 + 1e-6:
        raise InputError(
            f"rate = {aiding.rate:g} Hz: must be at most that of the recording, {1 / period:g} Hz"
        )
    clock = np.concatenate(([time[0] - period], time))
    sample = np.floor((clock - clock[0]) * aiding.rate + 1e-6)
    at_fix = np.concatenate(([False], np.diff(sample) > 0))
    latitude, longitude, height = aiding.position
    place = {"latitude": latitude * DEGREE, "longitude": longitude * DEGREE, "height": height}
    return {
        "gnss.sample": sample,
        "gnss.time": _held(np.where(at_fix, clock, np.nan), clock[0]),
        **{f"gnss.{name}": np.full_like(clock, value) for name, value in place.items()},
        **{f"gnss.velocity[{i}]": np.zeros_like(clock) for i in (1, 2, 3)},
    }


def _recorded_fixes(table: pd.DataFrame, path: str | Path) -> dict[str, Array]:
    missing = [column for column in (*GNSS_VELOCITY, *GNSS_POSITION) if column not in table]
    if missing:
        raise InputError(
            f"{path}: there is no column {missing[0]}; record GNSS, or use zero-velocity fixes at a position"
        )
    fix = table["gnss_velocity_east"].notna().to_numpy()
    if not fix.any():
        raise InputError(f"{path}: no row has a fix (gnss_velocity_east is empty everywhere)")
    incomplete = fix & table[[*GNSS_VELOCITY, *GNSS_POSITION]].isna().any(axis=1).to_numpy()
    if incomplete.any():
        raise InputError(f"{path}: line {int(np.flatnonzero(incomplete)[0]) + 2}: the fix is incomplete")
    columns = {f"gnss.velocity[{i + 1}]": table[name] for i, name in enumerate(GNSS_VELOCITY)}
    columns |= {
        "gnss.latitude": table["gnss_latitude"] * DEGREE,
        "gnss.longitude": table["gnss_longitude"] * DEGREE,
    }
    columns |= {"gnss.height": table["gnss_height"], "gnss.time": table.get(GNSS_TIME, table["time"])}
    first = int(np.flatnonzero(fix)[0])
    signals = {
        name: _held(np.concatenate(([np.nan], np.where(fix, column, np.nan))), column.iloc[first])
        for name, column in columns.items()
    }
    return {"gnss.sample": np.concatenate(([0.0], np.cumsum(fix))), **signals}


def _held(values: Array, first: float) -> Array:
    """Values held from one fix to the next; `first` until there is one."""
    known = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(len(values))))
    return np.where(known < 0, first, values[known])
