"""`recording.nc` of a run of this product.

A run leaves what its filters put out and, of a simulation, the truth, ten times a second; it does not keep
the IMU's samples, nor the fixes. So the file has no IMU and is a reference alone: `truth.*`, in this
product's units, seconds since the start of the run (Clock.OWN).
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios import recording
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Contents
from sim_scenarios.recordings.readers.files import beginning, whole
from sim_scenarios.recordings.tables import ReferenceTable, doubles

_MAGIC: Final = b"CDF"
_TRUTH: Final = tuple(
    f"truth.{name}" for name in ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity")
)


def recognises(path: Path) -> bool:
    """Whether a file begins like netCDF 3."""
    return beginning(path).startswith(_MAGIC)


def read(path: Path) -> Contents:
    """Truth of a run as a reference.

    Raises
    ------
    InputError
        If the file is damaged or none of a run, or the run has no truth.
    """
    whole(path)  # says what cannot be opened
    try:
        data = recording.load(path)
    except Exception as error:  # of damaged bytes the library makes whatever they say
        raise InputError(f"{path}: cannot be read as netCDF: {type(error).__name__}: {error}") from None
    missing = [name for name in ("time", *_TRUTH) if name not in data]
    if missing:
        raise InputError(
            f"{path}: has no {missing[0]}: of a recording.nc the truth of a simulation can serve as a "
            "reference, and nothing else"
        )
    rows = (data["time"].size,)
    for name in ("time", *_TRUTH):
        shape = (*rows, 3) if name == "truth.velocity" else rows
        if data[name].shape != shape or data[name].dtype.kind not in "fiu":
            raise InputError(
                f"{path}: {name} is {data[name].dtype} of the shape {data[name].shape}, must be numbers of "
                f"the shape {shape}"
            )
    roll, pitch, heading, latitude, longitude, height, velocity = (
        doubles(data[name].values) for name in _TRUTH
    )
    attitude, position = np.stack((roll, pitch, heading), -1), np.stack((latitude, longitude, height), -1)
    time = doubles(data["time"].values)
    return Contents(
        reference=ReferenceTable(time, attitude, position, velocity),
        remarks=(f"{path}: a run keeps no samples of its IMU: its truth is a reference, and nothing else",),
    )
