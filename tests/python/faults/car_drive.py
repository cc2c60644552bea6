"""A car with a MEMS IMU and an RTK receiver, as it was recorded: host stamps on a millisecond grid.

The recording does not come with the repository: `drive_0708` of rtklibexplorer/GNSS_IMU, IMU and solution
file, in the folder `car_drive` of the recordings.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim_scenarios.earth import radii

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665
DEGREE = np.pi / 180.0
# From sensor axes to forward-right-down ones, by the owner's fit.
MOUNTING = np.array(
    [[-0.98866, -0.092586, 0.118231], [-0.093239, 0.995644, 0.0], [-0.117716, -0.011024, -0.992986]]
)
TO_RIGHT_FORWARD_UP = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
LEVER_ARM = (-0.05, 0.0, 0.0)
DEPARTURE = 3.0  # m/s, of which the course is the heading

# What the owner says of the sensor, on a bench; on the road vibration is larger by almost ten.
BENCH = {
    "process.angle_random_walk": 0.0038 * DEGREE,
    "process.velocity_random_walk": 140e-6 * STANDARD_GRAVITY,
    "prior.gyro_bias_sigma": 0.2 * DEGREE,
    "prior.accelerometer_bias_sigma": 0.1,
}


@dataclass
class CarDrive:
    """The drive from the first fix on that is fast enough.

    Attributes
    ----------
    clock : ndarray, shape (n + 1,)
        Stamps of the IMU [s].
    columns : dict
        Inputs of a filter at these instants.
    fixes : DataFrame
        Time [s], latitude, longitude [rad], height [m], velocity_east, velocity_north, velocity_up [m/s].
    """

    clock: Array
    columns: dict[str, NDArray[np.generic]]
    fixes: pd.DataFrame

    @classmethod
    def read(cls, folder: Path) -> CarDrive:
        imu = pd.read_csv(folder / "imu.csv.gz")
        fixes = _fixes(folder / "gnss.pos.gz")
        fast = fixes[np.hypot(fixes.velocity_east, fixes.velocity_north) >= DEPARTURE]
        first = fast.index[0]
        start = int(np.searchsorted(imu.time_gpst_s, fixes.time[first]))
        imu, fixes = imu[start:], fixes.loc[first:].reset_index(drop=True)
        stamps = imu.time_gpst_s.to_numpy()
        origin = stamps[0]
        clock = stamps - origin
        fixes["time"] -= origin
        period = np.diff(clock)[:, None]
        to_body = TO_RIGHT_FORWARD_UP @ MOUNTING
        rates = imu[["gx_dps", "gy_dps", "gz_dps"]].to_numpy()[1:] * DEGREE @ to_body.T
        forces = imu[["ax_g", "ay_g", "az_g"]].to_numpy()[1:] * STANDARD_GRAVITY @ to_body.T
        # The newest fix at every instant.
        newest = np.searchsorted(fixes.time.to_numpy(), clock, side="right") - 1
        newest = np.maximum(newest, 0)
        columns: dict[str, NDArray[np.generic]] = {
            "imu.sample": np.arange(len(clock)),
            "imu.time": clock,
            "gnss.sample": newest,
            "gnss.time": fixes.time.to_numpy()[newest],
            **{f"gnss.{n}": fixes[n].to_numpy()[newest] for n in ("latitude", "longitude", "height")},
        }
        for i, axis in enumerate(("east", "north", "up")):
            columns[f"gnss.velocity[{i + 1}]"] = fixes[f"velocity_{axis}"].to_numpy()[newest]
            columns[f"imu.delta_angle[{i + 1}]"] = np.concatenate([[0.0], (rates * period)[:, i]])
            columns[f"imu.delta_velocity[{i + 1}]"] = np.concatenate([[0.0], (forces * period)[:, i]])
        return cls(clock, columns, fixes)

    def told(self, **changes: object) -> dict[str, object]:
        """Parameters and start of a NavigationFilter: bench and course, save the `changes`."""
        start = self.fixes.iloc[0]
        return {
            "initial.roll": 0.0,
            "initial.pitch": 0.0,
            "initial.heading": float(np.arctan2(start.velocity_east, start.velocity_north)),
            **{
                f"initial.velocity[{i}]": float(start[f"velocity_{axis}"])
                for i, axis in enumerate(("east", "north", "up"), 1)
            },
            **{f"initial.{n}": float(start[n]) for n in ("latitude", "longitude", "height")},
            "prior.position_sigma": 0.05,
            "prior.height_sigma": 0.05,
            "prior.velocity_sigma": 0.1,
            "prior.tilt_sigma": 3.0 * DEGREE,
            "prior.heading_sigma": 8.0 * DEGREE,
            "measurement.position_sigma": 0.05,
            "measurement.height_sigma": 0.05,
            "measurement.velocity_sigma": 0.15,
            **{f"gnss.lever_arm[{i}]": x for i, x in enumerate(LEVER_ARM, 1)},
            **BENCH,
            **changes,
        }

    def off(self, out: dict[str, Array]) -> Array:
        """Horizontal distance from the receiver's track, between fixes by interpolation [m]."""
        time = out["nav.time"]
        latitude, longitude = (
            np.interp(time, self.fixes.time, self.fixes[n]) for n in ("latitude", "longitude")
        )
        meridian, prime_vertical = radii(latitude)
        north = (out["nav.latitude"] - latitude) * meridian
        east = (out["nav.longitude"] - longitude) * prime_vertical * np.cos(latitude)
        return np.hypot(north, east)


def _fixes(path: Path) -> pd.DataFrame:
    table = pd.read_csv(path, sep=r"\s+", skiprows=1, header=None)
    day = pd.to_timedelta(table[1]).dt.total_seconds()
    return pd.DataFrame(
        {
            "time": day,
            "latitude": table[2] * DEGREE,
            "longitude": table[3] * DEGREE,
            "height": table[4],
            "velocity_east": table[16],
            "velocity_north": table[15],
            "velocity_up": table[17],
        }
    )
