"""A loosely coupled filter (Li, eqs. 19 to 22) in plain numpy, which shares nothing with the product.

Several filters that differ in their corrector alone take the same increments and fixes, side by side: they
are the first dimension of arrays. Frames: n east, north, up; b right, forward, up; SI units and radians.
Positions are longitude, latitude, height. Errors are true minus estimated, where the product has them the
other way round; the fifteen states are

    phi (C_true = exp(phi x) C)    dv    dp [m]    dbg, dba (of the biases, body)

    phi' = -w_in x phi - dw_in - C dbg
    dv'  = phi x f - C dba - (2 w_ie + w_en) x dv + v x (2 dw_ie + dw_en) + (2 g / R) dp_u up
    dp'  = derivative of [(N + h) cos(lat) dlon, (M + h) dlat, dh]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STATES = 15
PHI, VELOCITY, POSITION, GYRO, ACCELEROMETER = (slice(i, i + 3) for i in range(0, STATES, 3))
H = np.eye(STATES)[[6, 7, 8, 3, 4, 5]]
"""A fix measures position, then velocity."""

GENERATORS = np.stack([np.cross(axis, np.eye(3)).T for axis in np.eye(3)])
"""e x, for the three unit vectors e."""

# WGS-84 (NIMA TR8350.2).
SEMI_MAJOR_AXIS, FLATTENING = 6378137.0, 1 / 298.257223563
ECCENTRICITY_2 = FLATTENING * (2 - FLATTENING)
EARTH_RATE = 7.292115e-5
EQUATORIAL_GRAVITY, SOMIGLIANA, CENTRIFUGAL = 9.7803253359, 0.00193185265241, 0.00344978650684


def skew(v: Array) -> Array:
    """Matrices of the cross product, shape (..., 3, 3)."""
    matrices: Array = (v @ GENERATORS.reshape(3, 9)).reshape(*v.shape, 3)
    return matrices


def rotation(theta: Array) -> Array:
    """Rodrigues' formula, shape (..., 3, 3)."""
    angle = np.linalg.norm(theta, axis=-1)[..., None, None]
    K = skew(theta)
    of_sine, of_cosine = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    rodrigues: Array = np.eye(3) + of_sine * K + of_cosine * K @ K
    return rodrigues


def mean_rotation(theta: Array) -> Array:
    """The integral of exp(s theta x) over s from 0 to 1, shape (3, 3), by Gauss' rule.

    It turns a small error d of theta into what remains of it after theta has been fed back, r of
    exp((theta + d) x) = exp(r x) exp(theta x).
    """
    nodes, weights = np.polynomial.legendre.leggauss(5)
    mean: Array = np.tensordot(0.5 * weights, rotation(0.5 * (nodes[:, None] + 1) * theta), axes=1)
    return mean


def times(matrix: Array, vector: Array) -> Array:
    """Product of each matrix and its vector, shape (n, 3)."""
    return (matrix @ vector[..., None])[..., 0]


@dataclass(frozen=True)
class Earth:
    """What the Earth is at positions, shape (n, 3), for velocities, shape (n, 3)."""

    rate: Array
    """w_ie, shape (n, 3)."""
    transport: Array
    """w_en, shape (n, 3)."""
    gravity: Array
    """Shape (n,)."""
    radii: Array
    """(N + h) cos(lat), M + h and 1, which turn a change of position into metres, shape (n, 3)."""
    tan: Array
    """Of the latitude, shape (n,)."""

    @classmethod
    def at(cls, position: Array, velocity: Array) -> Earth:
        """The Earth below."""
        _, latitude, height = position.T
        sin, cos = np.sin(latitude), np.cos(latitude)
        zero, tan, root = np.zeros_like(sin), sin / cos, np.sqrt(1 - ECCENTRICITY_2 * sin**2)
        prime_vertical = SEMI_MAJOR_AXIS / root + height
        meridian = SEMI_MAJOR_AXIS * (1 - ECCENTRICITY_2) / root**3 + height
        ratio = height / SEMI_MAJOR_AXIS
        falling = 1 - 2 * (1 + FLATTENING + CENTRIFUGAL - 2 * FLATTENING * sin**2) * ratio + 3 * ratio**2
        east, north = velocity[:, 0], velocity[:, 1]
        return cls(
            rate=EARTH_RATE * np.stack((zero, cos, sin), axis=-1),
            transport=np.stack(
                (-north / meridian, east / prime_vertical, east * tan / prime_vertical), axis=-1
            ),
            gravity=EQUATORIAL_GRAVITY * (1 + SOMIGLIANA * sin**2) / root * falling,
            radii=np.stack((prime_vertical * cos, meridian, zero + 1.0), axis=-1),
            tan=tan,
        )


@dataclass(frozen=True)
class Told:
    """What the filters are told: sigmas of the start and of a fix, densities of the noise; SI units."""

    tilt: float
    heading: float
    velocity: float
    position: float
    height: float
    gyro_bias: float
    accelerometer_bias: float
    angle_random_walk: float
    velocity_random_walk: float
    fix_position: float
    fix_height: float
    fix_velocity: float

    def prior(self) -> Array:
        """Covariance of the start, shape (15, 15)."""
        start = [self.tilt, self.tilt, self.heading, *[self.velocity] * 3, *[self.position] * 2, self.height]
        return np.diag(np.square([*start, *[self.gyro_bias] * 3, *[self.accelerometer_bias] * 3]))

    def density(self) -> Array:
        """Of the process noise, shape (15, 15)."""
        walks = [*[self.angle_random_walk] * 3, *[self.velocity_random_walk] * 3, *[0.0] * 9]
        return np.diag(np.square(walks))

    def widest(self) -> Array:
        """Sigmas beyond which the adaptive factor makes no state uncertain, shape (15,)."""
        tilt, heading = max(3 * self.tilt, 0.1), max(3 * self.heading, 0.3)
        sensors = [*[10 * self.gyro_bias] * 3, *[10 * self.accelerometer_bias] * 3]
        return np.array([tilt, tilt, heading, *[np.inf] * 6, *sensors])

    def fix_noise(self) -> Array:
        """R, shape (6, 6)."""
        return np.diag(np.square([*[self.fix_position] * 2, self.fix_height, *[self.fix_velocity] * 3]))


class Corrector(Protocol):
    """From the predicted covariance, an innovation v and R to the correction and its covariance."""

    def __call__(self, P: Array, v: Array, R: Array) -> tuple[Array, Array]: ...


def update(P: Array, H: Array, v: Array, R: Array) -> tuple[Array, Array]:
    """Kalman's, in Joseph's form."""
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    rest = np.eye(STATES) - K @ H
    return K @ v, rest @ P @ rest.T + K @ R @ K.T


def standardised(P: Array, v: Array, R: Array) -> Array:
    """u_i = |v_i| / sqrt(S_ii)."""
    u: Array = np.abs(v) / np.sqrt(np.diag(H @ P @ H.T + R))
    return u


def standard(P: Array, v: Array, R: Array) -> tuple[Array, Array]:
    """Minimum variance, of what was measured: an innovation that is no number was not."""
    measured = np.isfinite(v)
    return update(P, H[measured], v[measured], R[np.ix_(measured, measured)])


class AdaptiveFactor:
    """Li, eqs. 15 to 17: alpha divides the predicted covariance wherever it stands.

    Free of units, in place of eq. 18: alpha is 2.1 m over the sum of u^2, where that is less than 1. No sigma
    is then left beyond `widest`, which is no rule of Li but one of the product.
    """

    THRESHOLD = 2.1

    def __init__(self, widest: Array) -> None:
        self.widest = widest

    def __call__(self, P: Array, v: Array, R: Array) -> tuple[Array, Array]:
        """Blames the prediction for what the innovation has beyond its covariance."""
        alpha = self.THRESHOLD * len(v) / np.sum(standardised(P, v, R) ** 2)
        if alpha >= 1.0:
            return standard(P, v, R)
        x, P = update(P / alpha, H, v, R)
        narrowing = np.minimum(1.0, self.widest / np.sqrt(np.diag(P)))
        return x, P * np.outer(narrowing, narrowing)


class GuardedIgg:
    """Chen 2019, eq. 28, on R; after five bad epochs in a row, until a good one, a guard in its place."""

    K0, K1, PATIENCE = 2.5, 8.0, 5

    def __init__(self, guard: Corrector) -> None:
        self.guard = guard
        self.bad = 0

    def __call__(self, P: Array, v: Array, R: Array) -> tuple[Array, Array]:
        """An epoch is bad in which a channel loses weight."""
        u = standardised(P, v, R)
        falling = self.K0 / np.maximum(u, self.K0) * ((self.K1 - u) / (self.K1 - self.K0)) ** 2
        weight = np.select([u <= self.K0, u <= self.K1], [1.0, falling], 0.0)
        self.bad = self.bad + 1 if np.any(weight < 1.0) else 0
        if self.bad > self.PATIENCE:
            return self.guard(P, v, R)
        left = weight > 0.0
        return update(P, H[left], v[left], np.diag(np.diag(R)[left] / weight[left]))


class DenseLoose:
    """Filters that differ in their corrector, on the same signals.

    Parameters
    ----------
    told : Told
    correctors : sequence of Corrector
        One for each filter.
    C_bn : ndarray, shape (3, 3)
        Attitude of the start.
    velocity, position : ndarray, shape (3,)
        Of the start.

    Attributes
    ----------
    C, v, p : ndarray, shape (filters, 3, 3), (filters, 3), (filters, 3)
        Attitude, velocity, position.
    """

    def __init__(
        self, told: Told, correctors: Sequence[Corrector], C_bn: Array, velocity: Array, position: Array
    ) -> None:
        count = len(correctors)
        self.told, self.correctors = told, correctors
        self.C = np.tile(C_bn, (count, 1, 1))
        self.v, self.p = np.tile(velocity, (count, 1)), np.tile(position, (count, 1))
        self.gyro_bias, self.accelerometer_bias = np.zeros((2, count, 3))
        self.P = np.tile(told.prior(), (count, 1, 1))

    def advance(self, angle: Array, velocity: Array, dt: float) -> None:
        """Mechanise increments that last dt each, shape (n, 3), and carry the covariance over all of them."""
        angle = angle - self.gyro_bias[:, None] * dt
        velocity = velocity - self.accelerometer_bias[:, None] * dt
        turns, half_turns = rotation(angle), rotation(0.5 * angle)
        attitudes, gains, velocities = [], [], []
        for k in range(angle.shape[1]):
            earth = Earth.at(self.p, self.v)
            middle = self.C @ half_turns[:, k]
            gained = times(middle, velocity[:, k])
            change = gained - dt * times(skew(2 * earth.rate + earth.transport), self.v)
            change[:, 2] -= dt * earth.gravity
            self.p += dt * (self.v + 0.5 * change) / earth.radii
            self.v += change
            turned = self.C @ turns[:, k]
            # By 1e-6 rad a sample: one order will do.
            self.C = turned - dt * skew(earth.rate + earth.transport) @ turned
            attitudes.append(middle)
            gains.append(gained)
            velocities.append(self.v.copy())
        attitude, force = np.mean(attitudes, axis=0), np.mean(gains, axis=0) / dt
        self._predict(attitude, force, np.mean(velocities, axis=0), dt * angle.shape[1])

    def correct(self, position: Array, velocity: Array, sigma: Array) -> None:
        """Take in a fix, shape (3,) each, and feed the errors back; sigmas, shape (6,), if it tells them."""
        earth = Earth.at(self.p, self.v)
        R = np.diag(np.where(sigma > 0, sigma**2, np.diag(self.told.fix_noise())))
        innovation = np.hstack(((position - self.p) * earth.radii, velocity - self.v))
        for i, corrector in enumerate(self.correctors):
            x, self.P[i] = corrector(self.P[i], innovation[i], R)
            reset = np.eye(STATES)
            reset[PHI, PHI] = mean_rotation(x[PHI])
            self.P[i] = reset @ self.P[i] @ reset.T
            self.C[i] = rotation(x[PHI]) @ self.C[i]
            self.v[i] += x[VELOCITY]
            self.p[i] += x[POSITION] / earth.radii[i]
            self.gyro_bias[i] += x[GYRO]
            self.accelerometer_bias[i] += x[ACCELEROMETER]

    def _predict(self, attitude: Array, force: Array, velocity: Array, time: float) -> None:
        """The covariance, by the exponential of F; half of the noise comes before, half after."""
        step = self._dynamics(attitude, force, velocity) * time
        term = transition = np.tile(np.eye(STATES), (len(step), 1, 1))
        for order in range(1, 8):
            term = term @ step / order
            transition = transition + term
        noise = 0.5 * time * self.told.density()
        self.P = transition @ (self.P + noise) @ transition.transpose(0, 2, 1) + noise

    def _dynamics(self, attitude: Array, force: Array, velocity: Array) -> Array:
        """F, shape (filters, 15, 15), of means over an interval."""
        earth = Earth.at(self.p, velocity)
        east, north, up = velocity.T
        meridian, prime_vertical = earth.radii[:, 1], earth.radii[:, 0] / np.cos(self.p[:, 1])
        tan, zero = earth.tan, np.zeros_like(up)

        def matrix(*rows: Sequence[Array]) -> Array:
            return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

        rate_of_position = matrix(
            (zero, zero, zero),
            (zero, -earth.rate[:, 2] / meridian, zero),
            (zero, earth.rate[:, 1] / meridian, zero),
        )
        transport_of_velocity = matrix(
            (zero, -1 / meridian, zero), (1 / prime_vertical, zero, zero), (tan / prime_vertical, zero, zero)
        )
        transport_of_position = matrix(
            (zero, zero, north / meridian**2),
            (zero, zero, -east / prime_vertical**2),
            (zero, east * (1 + tan**2) / prime_vertical / meridian, -east * tan / prime_vertical**2),
        )
        east_by_east = up / prime_vertical - tan * north / meridian
        position_of_position = matrix(
            (east_by_east, tan * east / meridian, -east / prime_vertical),
            (zero, up / meridian, -north / meridian),
            (zero, zero, zero),
        )
        F = np.zeros((len(velocity), STATES, STATES))
        F[:, PHI, PHI] = -skew(earth.rate + earth.transport)
        F[:, PHI, VELOCITY] = -transport_of_velocity
        F[:, PHI, POSITION] = -rate_of_position - transport_of_position
        F[:, PHI, GYRO] = -attitude
        F[:, VELOCITY, PHI] = -skew(force)
        F[:, VELOCITY, VELOCITY] = skew(velocity) @ transport_of_velocity
        F[:, VELOCITY, VELOCITY] -= skew(2 * earth.rate + earth.transport)
        F[:, VELOCITY, POSITION] = skew(velocity) @ (2 * rate_of_position + transport_of_position)
        F[:, 5, 8] += 2 * earth.gravity / np.sqrt(meridian * prime_vertical)
        F[:, VELOCITY, ACCELEROMETER] = -attitude
        F[:, POSITION, VELOCITY] = np.eye(3)
        F[:, POSITION, POSITION] = position_of_position
        return F
