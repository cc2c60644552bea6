"""What a filter is fed of a recording: the values of its inputs at the start and after each IMU sample.

A measurement of an aid enters with the first IMU sample whose stamp is not before its time of validity. The
count of the samples jumps where the stamps have a gap, a step far beyond its neighbours, and nowhere else.

Stamps go to the filter as they are: recordings with a date count from midnight, and even seconds since 1970
are resolved to 0.2 us, a fifth of what filters take for the same moment. To subtract a base would bring
nothing back. One thing apart: a filter takes a step half as long again as the one before for a gap, unless
the force says that the increment covers it. Increments of a steady sensor that were stamped late now and then
would so be taken for what is left after lost ones; their stamps are moved onto the sensor's own clock, unless
they follow none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Columns
from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.tables import ImuTable, Recording

Array = NDArray[np.float64]

SAME_MOMENT = 1e-6
"""Stamps closer than this mean the same moment, to filters too [s]."""
LEAP = 1.5
"""Of a step over the one before it, from which a filter looks for lost samples."""
MOST_SAMPLES = 2**31 - 1  # fmi2Integer


@dataclass(frozen=True)
class Feed:
    """Inputs of a filter over time.

    Attributes
    ----------
    time : ndarray, shape (n + 1,)
        Start and the stamps of n samples [s].
    columns : dict of str to ndarray, shape (n + 1,)
        Values at these instants, by scalar name.
    remark : str
        What was done to the stamps, in a sentence; empty: nothing.
    """

    time: Array
    columns: Columns
    remark: str = ""


def feed(recording: Recording, begin: float | None = None) -> Feed:
    """Feed of a recording.

    Parameters
    ----------
    recording : Recording
        Of which IMU, fixes and aids are fed.
    begin : float, optional
        Samples and measurements after it are fed [s]; by default all, from a period before the first sample.

    Returns
    -------
    Feed

    Raises
    ------
    InputError
        When fewer than two samples are left, or more than a filter counts.
    """
    imu, remark = recording.imu, ""
    if _pass_for_lost(imu):
        imu, remark = _on_its_own_clock(imu)
    start = before_first(imu) if begin is None else begin
    fed = imu.time > start
    clock = np.concatenate(([start], imu.time[fed]))
    if len(clock) < 3:
        raise InputError(
            f"{recording.name}: {len(clock) - 1} IMU samples follow {start:.10g} s; at least 2 must"
        )
    count = np.concatenate(([0], np.arange(1, len(clock)) + np.cumsum(stamps.missed(clock[1:]))))
    if count[-1] > MOST_SAMPLES:
        raise InputError(
            f"{recording.name}: covers {clock[-1] - start:g} s with a sample every "
            f"{stamps.period(clock[1:]):g} s: they must be at most {MOST_SAMPLES}, those that are missing "
            "included"
        )
    columns: Columns = {"imu.sample": count, "imu.time": clock}
    for name in ("delta_angle", "delta_velocity"):
        increments = getattr(imu, name)[fed]
        columns |= _scalars(f"imu.{name}", np.concatenate((np.zeros((1, 3)), increments)))
    return Feed(clock, {**columns, **_fixes(recording, clock), **_aids(recording, clock)}, remark)


def before_first(imu: ImuTable) -> float:
    """Where the interval of the first sample begins, as far as the others tell [s]."""
    return float(imu.time[0] - stamps.period(imu.time))


def _on_its_own_clock(imu: ImuTable) -> tuple[ImuTable, str]:
    """An IMU with steady stamps, and what was done; as it is if no steady clock is behind its stamps."""
    try:
        steady = stamps.on_a_steady_clock(imu.time)
    except InputError as error:
        return imu, f"Stamps of the IMU may pass for lost samples, and stay as recorded: {error}."
    moved = 1e3 * float(np.max(np.abs(steady - imu.time)))
    remark = f"Stamps of the IMU were moved onto its own steady clock, by {moved:.3g} ms at most."
    return replace(imu, time=steady), remark


def _pass_for_lost(imu: ImuTable) -> bool:
    """Whether jitter of the stamps would pass for lost samples: increments do not follow steps that leap."""
    steps = np.diff(imu.time)
    leaps = (steps[1:] > LEAP * steps[:-1]) & ~stamps.gaps(imu.time)[2:]
    change = np.linalg.norm(imu.delta_velocity, axis=1)
    force = np.median(change[np.isfinite(change)]) / stamps.period(imu.time)
    return bool(np.any(leaps & (change[2:] < force * np.sqrt(steps[1:] * steps[:-1]))))


def _fixes(recording: Recording, clock: Array) -> Columns:
    """Signals of the receiver; without one, such as never bring a fix."""
    gnss = recording.gnss
    if gnss is None or not len(gnss.time):
        names = ("sample", "latitude", "longitude", "height", *(f"velocity[{i}]" for i in (1, 2, 3)))
        nothing: Columns = {f"gnss.{name}": np.zeros(len(clock)) for name in names}
        return {**nothing, "gnss.time": np.full(len(clock), clock[0])}
    values = dict(zip(("latitude", "longitude", "height"), gnss.position.T, strict=True))
    told = {"fix_position_sigma": gnss.position_sigma, "fix_velocity_sigma": gnss.velocity_sigma}
    told = {name: sigma for name, sigma in told.items() if sigma.any()}
    return _newest("gnss", gnss.time, {**values, "velocity": gnss.velocity, **told}, clock)


def _aids(recording: Recording, clock: Array) -> Columns:
    columns: Columns = {}
    if (log := recording.body_velocity) is not None and len(log.time):
        values = {"velocity": log.velocity, "sigma": log.sigma}
        columns |= _newest("body_velocity", log.time, values, clock)
    if (compass := recording.heading_aid) is not None and len(compass.time):
        values = {"heading": compass.heading, "sigma": compass.sigma}
        columns |= _newest("heading_aid", compass.time, values, clock)
    if (height := recording.height_aid) is not None and len(height.time):
        values = {"height": height.height, "sigma": height.sigma}
        columns |= _newest("height_aid", height.time, values, clock)
    return columns


def _newest(prefix: str, time: Array, values: Mapping[str, Array], clock: Array) -> Columns:
    """Count of a table's rows so far, and the newest of them; until there is one, the first that comes."""
    first = int(np.searchsorted(time, clock[0] + SAME_MOMENT, side="right"))
    reached = np.searchsorted(time, clock + SAME_MOMENT, side="right")
    row = np.clip(reached - 1, min(first, len(time) - 1), None)
    columns: Columns = {f"{prefix}.sample": np.maximum(reached - first, 0), f"{prefix}.time": time[row]}
    for name, array in values.items():
        columns |= _scalars(f"{prefix}.{name}", array[row])
    return columns


def _scalars(name: str, values: Array) -> Columns:
    """Columns of a scalar, shape (n,), or of a vector, shape (n, 3)."""
    if values.ndim == 1:
        return {name: values}
    return {f"{name}[{i}]": column for i, column in enumerate(values.T, start=1)}
