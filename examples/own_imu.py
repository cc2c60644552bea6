"""A recording of one's own IMU through a filter.

The recording is made up, so that the answer is known: a vehicle at rest and level, whose IMU has no error but
its white noise. Increments, right, forward, up: delta angle [rad] and delta velocity [m/s] over the interval
that ends at `time` [s]. With rates instead of increments the file is refused.
"""

from pathlib import Path

import numpy as np
import pandas as pd

import sim_scenarios
from sim_scenarios.units import DEGREE

RATE, SPAN = 100, 300  # Hz, s
LATITUDE, HEADING = 45.0, 30.0  # deg
EARTH_RATE, GRAVITY = 7.292115e-5, 9.80620  # rad/s, m/s2 (of this latitude, at sea level)
GYRO_NOISE, ACCELEROMETER_NOISE = 1e-6, 3e-4  # rad/s^0.5, m/s/s^0.5

samples = RATE * SPAN
north, up = EARTH_RATE * np.cos(LATITUDE * DEGREE), EARTH_RATE * np.sin(LATITUDE * DEGREE)
body_rate = [-north * np.sin(HEADING * DEGREE), north * np.cos(HEADING * DEGREE), up]
noise = np.random.default_rng(1).standard_normal((2, samples, 3)) / RATE**0.5
delta_angle = np.array(body_rate) / RATE + GYRO_NOISE * noise[0]
delta_velocity = np.array([0.0, 0.0, GRAVITY]) / RATE + ACCELEROMETER_NOISE * noise[1]

table = pd.DataFrame({"time": np.arange(1, samples + 1) / RATE})
table[[f"delta_angle_{axis}" for axis in "xyz"]] = delta_angle
table[[f"delta_velocity_{axis}" for axis in "xyz"]] = delta_velocity
table.to_csv(Path("my_imu.csv"), index=False)

run = sim_scenarios.replay(
    "my_imu.csv",
    sim_scenarios.Start(heading=(HEADING + 8) * DEGREE, heading_sigma=10 * DEGREE),
    zero_velocity=sim_scenarios.ZeroVelocity((LATITUDE, 10.0, 0.0)),
    set={
        "process.angle_random_walk": GYRO_NOISE,
        "process.velocity_random_walk": ACCELEROMETER_NOISE,
        "prior.gyro_bias_sigma": "0.005 deg/h",
        "prior.accelerometer_bias_sigma": "20 ug",
    },
)
heading, sigma = (float(run[name][-1]) / DEGREE for name in ("nav.heading", "heading_sigma"))
print(f"The heading is {heading:.3f} deg with a sigma of {sigma:.3f} deg; it was made to be {HEADING:g} deg")
