"""How a vehicle moves that is known at points in time, and what TruthPlant is told of it in every step.

Between two points the velocity is the cubic that has their velocities and accelerations, and the attitude

    C_bn(x) = C_0 exp[y(x)],   y(x) a cubic,   derivative of y = J_r(y)^-1 w_nb^b

that which has their attitudes and body rates, as the plant goes from one step to the next
(`fmu_src/plant/passage.hpp`). The position is the integral of the velocity; what is left to the next point is
spread over the time between, so that every point is passed. What is not known of the points is taken of
quintic splines through them: velocities of that through the positions, accelerations of that through the
velocities, and body rates, 2 vec(q* dq/dt), of that through the quaternions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios import compiled
from sim_scenarios.attitude import dcm, right_jacobian
from sim_scenarios.earth import displaced, displacement, radii
from sim_scenarios.instance import Instance, Port

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

Array = NDArray[np.float64]

STATE: Final = (
    "external.time",
    *(
        f"external.{name}[{i}]"
        for name in ("position", "velocity", "attitude", "acceleration", "body_rate")
        for i in (1, 2, 3)
    ),
)
"""Inputs of the plant that a state of a vehicle goes into."""
HIGHEST_LATITUDE: Final = 1.57
"""Of the plant, whose local-level frame excludes the poles [rad]."""
SMOOTHEST: Final = 5
"""Degree of the splines, where there are enough points."""
BLOCK: Final = compiled.GIVEN
"""States that are calculated at once."""


@dataclass(frozen=True)
class Points:
    """What is known of a vehicle at n instants, two or more, increasing; None: not known.

    Attributes
    ----------
    time : ndarray, shape (n,)
        [s]
    position : ndarray, shape (n, 3)
        Latitude [rad], longitude [rad], height [m].
    attitude : ndarray, shape (n, 3), or None
        Roll, pitch, heading [rad]; without them it is level across and points where it goes.
    velocity : ndarray, shape (n, 3), or None
        East, north, up [m/s].
    acceleration : ndarray, shape (n, 3), or None
        Derivative of the velocity, component by component [m/s2].
    body_rate : ndarray, shape (n, 3), or None
        Relative to east, north, up: right, forward, up [rad/s].
    """

    time: Array
    position: Array
    attitude: Array | None = None
    velocity: Array | None = None
    acceleration: Array | None = None
    body_rate: Array | None = None


class Vehicle:
    """A vehicle that passes points; its time counts from the first of them.

    Parameters
    ----------
    points : Points
    """

    def __init__(self, points: Points) -> None:
        from scipy.interpolate import CubicHermiteSpline  # slow, and few scenarios have a vehicle

        self.time = points.time - points.time[0]
        latitude, longitude, height = points.position.T
        self._position = np.column_stack((latitude, np.unwrap(longitude), height))
        velocity = _velocity(self.time, self._position) if points.velocity is None else points.velocity
        acceleration = points.acceleration
        if acceleration is None:
            acceleration = _derivative(self.time, velocity)
        self._velocity = CubicHermiteSpline(self.time, velocity, acceleration)
        attitude = _ahead(velocity) if points.attitude is None else points.attitude
        self._rotation = Rotation.from_matrix(dcm(*attitude.T))
        self._rate = _body_rate(self.time, self._rotation) if points.body_rate is None else points.body_rate

    @property
    def end(self) -> float:
        """Until when its motion is known [s]."""
        return float(self.time[-1])

    @cached_property
    def turns(self) -> Array:
        """Rotation vectors from each point to the next, in the body axes of the first, shape (n - 1, 3)."""
        turned: Array = (self._rotation[:-1].inv() * self._rotation[1:]).as_rotvec()
        return turned

    @cached_property
    def astray(self) -> Array:
        """Where each point but the first lies off that to which velocities lead from the one before.

        East, north, up [m], shape (n - 1, 3).
        """
        way = np.diff(self._way(self.time), axis=0)
        return displacement(self._position[1:], displaced(self._position[:-1], way))

    def states(self, time: Array) -> Array:
        """States as the plant takes them.

        Parameters
        ----------
        time : ndarray, shape (m,)
            From 0 to the end [s]; what is later is taken for the end.

        Returns
        -------
        ndarray, shape (m, 16)
            By the order of `STATE`; all is known.
        """
        known, time = self.time, np.minimum(time, self.end)
        at = np.searchsorted(known, time, side="right").clip(1, len(known) - 1) - 1
        since, lasts = time - known[at], np.diff(known)[at]
        way = self._way(time) - self._way(known)[at] + self.astray[at] * (since / lasts)[:, None]
        rotation, rate = self._turned(at, since, lasts)
        minus_heading, pitch, roll = (self._rotation[at] * Rotation.from_rotvec(rotation)).as_euler("ZXY").T
        return np.column_stack(
            (
                time,
                displaced(self._position[at], way),
                self._velocity(time),
                np.column_stack((roll, pitch, -minus_heading)),
                self._velocity(time, 1),
                rate,
            )
        )

    @cached_property
    def _way(self) -> CubicHermiteSpline:
        return self._velocity.antiderivative()

    def _turned(self, at: NDArray[np.intp], since: Array, lasts: Array) -> tuple[Array, Array]:
        """Rotation vectors from the points before, and body rates."""
        turn = self.turns[at]
        begin = self._rate[at]
        end = np.linalg.solve(right_jacobian(turn), self._rate[at + 1][..., None])[..., 0]
        lasts, since = lasts[:, None], since[:, None]
        slope = turn / lasts
        quadratic = (3 * slope - 2 * begin - end) / lasts
        cubic = (begin + end - 2 * slope) / lasts**2
        rotation = since * (begin + since * (quadratic + since * cubic))
        derivative = begin + since * (2 * quadratic + 3 * since * cubic)
        return rotation, (right_jacobian(rotation) @ derivative[..., None])[..., 0]


class Driver:
    """Tells a plant whose motion is external how a vehicle moves.

    Parameters
    ----------
    plant : Instance
    vehicle : Vehicle
    """

    def __init__(self, plant: Instance, vehicle: Vehicle) -> None:
        self._port = Port(plant, STATE)
        self._vehicle = vehicle
        self._block = np.empty((0, len(STATE)))
        self._next = 0

    def tell(self, time: float, step: float) -> None:
        """Say how the vehicle is at the end of a step from a time [s]; all steps are equally long."""
        if self._next == len(self._block):
            self._renew(time, step)
            self._next = 0
        state = self._block[self._next]
        state[0] = time + step
        self._port.signals.buffers["Real"][:] = state
        self._port.write()
        self._next += 1

    def tell_in(self, loop: compiled.Loop) -> None:
        """As `tell`, in a compiled loop."""
        loop.write_rows(self._port, self._rows)

    def _renew(self, time: float, step: float) -> None:
        ahead = step * np.arange(1, BLOCK + 1, dtype=np.float64)
        self._block = self._vehicle.states(time + ahead)

    def _rows(self, _: int, times: Array) -> Array:
        steps = np.diff(times)
        self._renew(float(times[0]), float(steps[0]))
        self._block[: len(steps), 0] = times[:-1] + steps
        return self._block


def _derivative(time: Array, values: Array) -> Array:
    """Of the spline through values at the times, shape (n, m)."""
    from scipy.interpolate import make_interp_spline  # slow

    derivative: Array = make_interp_spline(time, values, k=min(SMOOTHEST, len(time) - 1))(time, 1)
    return derivative


def _velocity(time: Array, position: Array) -> Array:
    """Velocities at positions [m/s], shape (n, 3)."""
    latitude_rate, longitude_rate, climb = _derivative(time, position - position[0]).T
    latitude, _, height = position.T
    meridian, prime_vertical = radii(latitude)
    east = longitude_rate * (prime_vertical + height) * np.cos(latitude)
    return np.column_stack((east, latitude_rate * (meridian + height), climb))


def _body_rate(time: Array, rotation: Rotation) -> Array:
    """Body rates of rotations [rad/s], shape (n, 3)."""
    quaternion = rotation.as_quat()  # scalar last
    opposite = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0
    quaternion[1:][np.cumsum(opposite) % 2 == 1] *= -1  # both stand for the same rotation
    derivative = _derivative(time, quaternion)
    vector, scalar = quaternion[:, :3], quaternion[:, 3:]
    rate: Array = 2 * (
        scalar * derivative[:, :3] - derivative[:, 3:] * vector - np.cross(vector, derivative[:, :3])
    )
    return rate


def _ahead(velocity: Array) -> Array:
    """Roll, pitch, heading of what points where it goes [rad], shape (n, 3)."""
    east, north, up = velocity.T
    pitch = np.arctan2(up, np.hypot(east, north))
    return np.column_stack((np.zeros_like(pitch), pitch, np.arctan2(east, north)))
