"""A small vehicle of its own, independent of the plant: parked, then driving with a weaving heading.

Parked for 30 s, then 1 m/s2 up to 8 m/s, with a yaw rate of 0.3 sin(2 pi t / 40 s) rad/s once it moves. The
increments are those that invert the equations of navigation over one sample, so that a perfect filter follows
to rounding of the sampling; noise is white.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.earth import radii

Array = NDArray[np.float64]

RATE = 100.0  # Hz
LATITUDE = 0.7
EARTH = 7.292115e-5
PARKED = 30.0


def gravity(latitude: Array) -> Array:
    """Normal gravity at height 0 [m/s2], WGS-84 (Somigliana)."""
    s2 = np.sin(latitude) ** 2
    return np.asarray(9.7803253359 * (1 + 0.00193185265241 * s2) / np.sqrt(1 - 0.00669437999013 * s2))


@dataclass
class Drive:
    """Truth and signals of a drive.

    Attributes
    ----------
    time : ndarray, shape (n + 1,)
    position : ndarray, shape (n + 1, 3)
        Latitude, longitude [rad], height [m].
    velocity : ndarray, shape (n + 1, 3)
        East, north, up [m/s].
    heading : ndarray, shape (n + 1,)
        Clockwise from north [rad].
    """

    duration: float = 400.0
    gyro_noise: float = np.deg2rad(0.02)  # rad/sqrt(s)
    accelerometer_noise: float = 0.02  # m/s/sqrt(s)
    fix_rate: float = 4.0
    position_sigma: float = 0.01
    velocity_sigma: float = 0.04
    seed: int = 1
    time: Array = field(init=False)
    position: Array = field(init=False)
    velocity: Array = field(init=False)
    heading: Array = field(init=False)
    columns: dict[str, NDArray[np.generic]] = field(init=False)

    def __post_init__(self) -> None:
        n = round(self.duration * RATE)
        dt = 1.0 / RATE
        self.time = t = np.arange(n + 1) * dt
        driving = np.clip(t - PARKED, 0.0, None)
        speed = np.minimum(driving, 8.0)
        self.heading = 0.3 * 40.0 / (2 * np.pi) * (1 - np.cos(2 * np.pi * driving / 40.0)) + 0.5
        self.velocity = np.stack(
            [speed * np.sin(self.heading), speed * np.cos(self.heading), np.zeros(n + 1)], axis=1
        )
        self.position = self._positions(dt)
        rng = np.random.default_rng(self.seed)
        angle, velocity = self._increments(dt)
        angle += self.gyro_noise * np.sqrt(dt) * rng.standard_normal((n, 3))
        velocity += self.accelerometer_noise * np.sqrt(dt) * rng.standard_normal((n, 3))
        self.columns = self._columns(angle, velocity, rng)

    def _positions(self, dt: float) -> Array:
        position = np.zeros((len(self.time), 3))
        position[0] = LATITUDE, 0.3, 0.0
        mean = 0.5 * (self.velocity[1:] + self.velocity[:-1])
        for k, (east, north, _) in enumerate(mean):
            meridian, prime_vertical = radii(position[k, 0])
            position[k + 1] = position[k] + dt * np.array(
                [north / meridian, east / (prime_vertical * np.cos(position[k, 0])), 0.0]
            )
        return position

    def _increments(self, dt: float) -> tuple[Array, Array]:
        """Integrals of body rate and specific force, body axes right-forward-up; the body stays level."""
        latitude = 0.5 * (self.position[1:, 0] + self.position[:-1, 0])
        v = 0.5 * (self.velocity[1:] + self.velocity[:-1])
        meridian, prime_vertical = radii(latitude)
        earth = EARTH * np.stack([0 * latitude, np.cos(latitude), np.sin(latitude)], axis=1)
        transport = np.stack(
            [-v[:, 1] / meridian, v[:, 0] / prime_vertical, v[:, 0] / prime_vertical * np.tan(latitude)],
            axis=1,
        )
        force = (self.velocity[1:] - self.velocity[:-1]) / dt + np.cross(2 * earth + transport, v)
        force[:, 2] += gravity(latitude)
        turn = -(self.heading[1:] - self.heading[:-1])
        psi = 0.5 * (self.heading[1:] + self.heading[:-1])
        to_body = np.zeros((len(psi), 3, 3))
        to_body[:, 0, 0], to_body[:, 0, 1] = np.cos(psi), -np.sin(psi)
        to_body[:, 1, 0], to_body[:, 1, 1] = np.sin(psi), np.cos(psi)
        to_body[:, 2, 2] = 1.0
        angle = dt * np.einsum("kij,kj->ki", to_body, earth + transport)
        angle[:, 2] += turn
        return angle, dt * np.einsum("kij,kj->ki", to_body, force)

    def _columns(
        self, angle: Array, velocity: Array, rng: np.random.Generator
    ) -> dict[str, NDArray[np.generic]]:
        n = len(angle)
        every = round(RATE / self.fix_rate)
        count = np.arange(n + 1) // every
        last = count * every
        noise = rng.standard_normal((count[-1] + 1, 6))
        meridian, prime_vertical = radii(self.position[last, 0])
        columns: dict[str, NDArray[np.generic]] = {
            "imu.sample": np.arange(n + 1),
            "imu.time": self.time,
            "gnss.sample": count,
            "gnss.time": self.time[last],
            "gnss.latitude": self.position[last, 0] + self.position_sigma * noise[count, 1] / meridian,
            "gnss.longitude": self.position[last, 1]
            + self.position_sigma * noise[count, 0] / (prime_vertical * np.cos(self.position[last, 0])),
            "gnss.height": self.position[last, 2] + self.position_sigma * noise[count, 2],
        }
        for i in range(3):
            columns[f"imu.delta_angle[{i + 1}]"] = np.concatenate([[0.0], angle[:, i]])
            columns[f"imu.delta_velocity[{i + 1}]"] = np.concatenate([[0.0], velocity[:, i]])
            columns[f"gnss.velocity[{i + 1}]"] = (
                self.velocity[last, i] + self.velocity_sigma * noise[count, 3 + i]
            )
        return columns

    def told(self, heading_error: float = 0.0, **changes: float) -> dict[str, float]:
        """Parameters and start of a NavigationFilter that is told truthfully, save the `changes`."""
        degree = np.deg2rad(1.0)
        return {
            "initial.roll": 0.0,
            "initial.pitch": 0.0,
            "initial.heading": float(self.heading[0] + heading_error),
            **{f"initial.velocity[{i}]": 0.0 for i in (1, 2, 3)},
            "initial.latitude": LATITUDE,
            "initial.longitude": 0.3,
            "initial.height": 0.0,
            "prior.position_sigma": 0.05,
            "prior.height_sigma": 0.05,
            "prior.velocity_sigma": 0.1,
            "prior.tilt_sigma": degree,
            "prior.heading_sigma": 8 * degree,
            "prior.gyro_bias_sigma": 0.2 * degree,
            "prior.accelerometer_bias_sigma": 0.1,
            "process.angle_random_walk": self.gyro_noise,
            "process.velocity_random_walk": self.accelerometer_noise,
            "measurement.position_sigma": self.position_sigma,
            "measurement.height_sigma": self.position_sigma,
            "measurement.velocity_sigma": self.velocity_sigma,
            **changes,
        }

    def errors(self, out: dict[str, Array], rows: NDArray[np.intp]) -> tuple[Array, Array]:
        """Horizontal position [m] and heading [rad] of a filter's outputs against the truth."""
        meridian, prime_vertical = radii(LATITUDE)
        north = (out["nav.latitude"] - self.position[rows, 0]) * meridian
        east = (out["nav.longitude"] - self.position[rows, 1]) * prime_vertical * np.cos(LATITUDE)
        heading = (out["nav.heading"] - self.heading[rows] + np.pi) % (2 * np.pi) - np.pi
        return np.hypot(north, east), heading
