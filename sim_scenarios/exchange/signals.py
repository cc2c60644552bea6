"""The file that the Playback FMU plays; its layout: `fmu_src/components/recorded_signals.hpp`.

It holds what `recordings.feed` feeds to a filter, row by row, so that the FMU decides nothing: which fix
comes with which sample of the IMU, and where samples were lost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Columns
from sim_scenarios.recordings import reference as references
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.feed import SAME_MOMENT, Feed
from sim_scenarios.recordings.tables import ReferenceTable

Array = NDArray[np.float64]

FILE: Final = "resources/recording.bin"
"""In the FMU."""
MAGIC: Final = b"TNplay1\n"
ROUNDING: Final = 1e-9
"""What differences of stamps may be off [s]."""
SHORTEST: Final = 0.1
"""Of a sampling period, down to which a communication step may be."""

_AXES: Final = ("[1]", "[2]", "[3]")


def _vector(name: str) -> list[str]:
    return [name + axis for axis in _AXES]


_IMU: Final = ("imu.time", *_vector("imu.delta_angle"), *_vector("imu.delta_velocity"))
_AIDS: Final[Mapping[str, Sequence[str]]] = {
    "gnss": (
        *("time", "latitude", "longitude", "height", *_vector("velocity")),
        *(*_vector("fix_position_sigma"), *_vector("fix_velocity_sigma")),
    ),
    "body_velocity": ("time", *_vector("velocity"), *_vector("sigma")),
    "heading_aid": ("time", "heading", "sigma"),
    "height_aid": ("time", "height", "sigma"),
}
_TRUTH: Final = tuple(
    f"truth.{name}"
    for name in ("roll", "pitch", "heading", "latitude", "longitude", "height", *_vector("velocity"))
)


def content(fed: Feed, truth: ReferenceTable | None) -> bytes:
    """Content of the file.

    Parameters
    ----------
    fed : Feed
        What a filter is fed.
    truth : ReferenceTable or None
        What the FMU puts out as the truth at the stamps of the IMU.

    Returns
    -------
    bytes
    """
    told: Columns = {} if truth is None else references.at(truth, fed.time)
    tables = [
        _imu(fed.columns),
        *(_aid(name, columns, fed.columns) for name, columns in _AIDS.items()),
        np.column_stack([told[name] for name in _TRUTH]) if told else np.empty((0, len(_TRUTH))),
    ]
    head = np.array([fed.time[0], suitable_step(fed.time)], dtype="<f8").tobytes()
    body = head + b"".join(np.array([len(t)], "<u8").tobytes() + t.astype("<f8").tobytes() for t in tables)
    return MAGIC + _sums(body) + body


def suitable_step(clock: Array) -> float:
    """Communication step in which no two samples come.

    Parameters
    ----------
    clock : ndarray, shape (n + 1,)
        Where it begins, and the stamps of the samples [s].

    Returns
    -------
    float
        The sampling period if all stamps are on its grid, else the largest of 1, 2, 5 times a power of ten
        that is not longer than the shortest interval, but at least a tenth of the period [s].
    """
    period = stamps.period(clock[1:])
    numbers = np.rint((clock - clock[0]) / period)
    even = float(f"{(clock[-1] - clock[0]) / numbers[-1]:.12g}")
    on_grid = np.abs(clock - clock[0] - even * np.rint((clock - clock[0]) / even)) < SAME_MOMENT
    if on_grid.all():
        return even
    shortest = max(float(np.min(np.diff(clock))), SHORTEST * period) + ROUNDING
    power = 10.0 ** np.floor(np.log10(shortest))
    return float(max(power * factor for factor in (1, 2, 5) if power * factor <= shortest))


def _imu(columns: Columns) -> Array:
    """Samples that were lost before each, its stamp and increments, shape (n, 8)."""
    lost = np.diff(columns["imu.sample"]) - 1
    return np.column_stack([lost, *(columns[name][1:] for name in _IMU)])


def _aid(prefix: str, names: Sequence[str], columns: Columns) -> Array:
    """With which sample a measurement comes, how many come with it, and its values, a row for each."""
    if f"{prefix}.sample" not in columns:
        return np.empty((0, 2 + len(names)))
    count = np.diff(columns[f"{prefix}.sample"])
    rows = np.flatnonzero(count) + 1
    absent = np.zeros(len(columns["imu.time"]))
    values = [columns.get(f"{prefix}.{name}", absent)[rows] for name in names]
    return np.column_stack([rows, count[rows - 1], *values])


def _sums(body: bytes) -> bytes:
    """Sum of all words, and sum of the sums up to each, modulo 2^64."""
    sums = np.cumsum(np.frombuffer(body, "<u8"), dtype="<u8")
    return np.array([sums[-1], np.sum(sums, dtype="<u8")], "<u8").tobytes()
