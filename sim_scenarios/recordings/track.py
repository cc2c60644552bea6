"""Where a filter of a replay was at any time, and the antenna with it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import dcm
from sim_scenarios.earth import displacement
from sim_scenarios.recording import HAND_OVER

Array = NDArray[np.float64]


def navigates_from(run: xr.Dataset) -> float:
    """Since when the filter has an estimate [s]: the start, or the hand-over of an alignment; inf: never."""
    if HAND_OVER not in run:
        return float(run["time"].values[0])
    return float(np.nan_to_num(run[HAND_OVER].values, nan=np.inf))


def positions(run: xr.Dataset) -> Array:
    """Latitude [rad], longitude [rad], height [m] of the IMU over the recorded times, shape (n, 3)."""
    return np.column_stack([run[f"nav.{name}"].values for name in ("latitude", "longitude", "height")])


def antenna_minus(run: xr.Dataset, time: Array, position: Array) -> Array:
    """Antenna of the filter minus other positions at their times: east, north, up [m].

    Between recorded times position and heading are interpolated; within a recording period of 0.1 s a vehicle
    that accelerates by 5 m/s2 leaves the straight line by 6 mm.

    Parameters
    ----------
    run : Dataset
        Of `recordings.replay`.
    time : ndarray, shape (n,)
        [s]
    position : ndarray, shape (n, 3)
        Latitude [rad], longitude [rad], height [m].

    Returns
    -------
    ndarray, shape (n, 3)
    """
    recorded = run["time"].values
    nearby = np.searchsorted(recorded, time).clip(0, len(recorded) - 1)
    path = positions(run)
    path[:, 1] = np.unwrap(path[:, 1])
    imu = np.column_stack([np.interp(time, recorded, column) for column in path.T])
    angles = (run[f"nav.{name}"].values[nearby] for name in ("roll", "pitch", "heading"))
    arm = dcm(*angles) @ run["lever_arm"].values
    off: Array = displacement(imu, position) + arm
    return off


def headings(run: xr.Dataset, time: Array) -> Array:
    """Heading of the filter at times between the recorded ones [rad], shape (n,)."""
    interpolated: Array = np.interp(time, run["time"].values, np.unwrap(run["nav.heading"].values))
    return interpolated
