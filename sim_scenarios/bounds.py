"""How well can the heading be known: posterior Cramer-Rao bound along a true trajectory.

For a linear system with Gaussian noise the bound is the covariance of the matched Kalman filter (Tichavsky,
Muravchik and Nehorai 1998, IEEE Trans. Signal Process. 46(5), eq. 21). The errors of an inertial navigator
are linear when they are small, so the filter is linearised at the truth; with the states ::

    x = [phi (attitude), dv (velocity), eps (gyro bias), nabla (accelerometer bias)]      12 states

its error model in ENU is (Zhou 2011, eqs. 12 and 13, for small angles) ::

    phi' = -w_in x phi + dw_en(dv) - C_bn eps                + gyro noise
    dv'  =  f_n x phi - (2 w_ie + w_en) x dv + C_bn nabla    + accelerometer noise
    eps' = 0,  nabla' = 0

and GNSS observes dv. No filter that knows these statistics has a smaller mean square heading error, whatever
its algorithm; RMS over time of sigma(phi_up) is the figure to hold a filter's RMSE against.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.attitude import skew
from sim_scenarios.earth import curvature, earth_rate, gravity
from sim_scenarios.errors import InputError
from sim_scenarios.units import DEGREE, HOUR, STANDARD_GRAVITY

Array = NDArray[np.float64]

ATTITUDE, VELOCITY, GYRO_BIAS, ACCELEROMETER_BIAS = (slice(i, i + 3) for i in (0, 3, 6, 9))
STATES = 12
HEADING = 2


@dataclass(frozen=True)
class Trajectory:
    """True motion, sampled often enough that its attitude is smooth between samples (10 Hz for a ship).

    Attributes
    ----------
    time : ndarray, shape (n,)
        Strictly increasing [s].
    C_bn : ndarray, shape (n, 3, 3)
        Body (right, forward, up) to navigation (east, north, up).
    velocity : ndarray, shape (n, 3)
        East, north, up [m/s].
    latitude : ndarray, shape (n,)
        [rad]
    height : ndarray, shape (n,)
        Above the ellipsoid [m].
    """

    time: Array
    C_bn: Array
    velocity: Array
    latitude: Array
    height: Array


@dataclass(frozen=True)
class Knowledge:
    """What is known before and besides the measurements: prior sigmas, noise densities, GNSS; SI units.

    The defaults are those of the scenario of Zhou 2011. The velocity of GNSS may have a sigma for each axis
    (east, north, up).
    """

    tilt_sigma: float = 1.0 * DEGREE
    heading_sigma: float = 10.0 * DEGREE
    velocity_sigma: float = 0.15
    gyro_bias_sigma: float = 0.05 * DEGREE / HOUR
    accelerometer_bias_sigma: float = 1e-3 * STANDARD_GRAVITY
    angle_random_walk: float = 0.005 * DEGREE / HOUR**0.5
    velocity_random_walk: float = 50e-6 * STANDARD_GRAVITY
    gnss_velocity_sigma: float | tuple[float, float, float] = 0.1
    gnss_rate: float = 1.0


@dataclass(frozen=True)
class Bound:
    """Covariance of the matched filter after each fix.

    Attributes
    ----------
    time : ndarray, shape (m,)
        Times of the fixes, the start included [s].
    sigma : ndarray, shape (m, 12)
        Square root of the diagonal of the covariance: attitude (east, north, up) [rad], velocity (east,
        north, up) [m/s], gyro bias (right, forward, up) [rad/s], accelerometer bias (right, forward, up)
        [m/s2].
    """

    time: Array
    sigma: Array

    @property
    def heading_sigma(self) -> Array:
        """Sigma of the heading at each fix [rad], shape (m,)."""
        heading: Array = self.sigma[:, HEADING]
        return heading

    def heading_rms(self, start: float, stop: float) -> float:
        """Root mean square of the heading sigma over start..stop [rad]."""
        inside = (self.time >= start) & (self.time <= stop)
        if not inside.any():
            raise InputError(f"the bound has no fix between {start:g} s and {stop:g} s")
        return float(np.sqrt(np.mean(self.heading_sigma[inside] ** 2)))


def cramer_rao(trajectory: Trajectory, knowledge: Knowledge) -> Bound:
    """Posterior Cramer-Rao bound of the 12 error states along a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        True motion.
    knowledge : Knowledge
        Prior, noise and GNSS.

    Returns
    -------
    Bound
        At the start and after each fix.
    """
    sigma = np.broadcast_to(knowledge.gnss_velocity_sigma, 3)
    if knowledge.gnss_rate <= 0 or np.any(sigma <= 0):
        raise InputError("the bound needs GNSS: a rate and velocity sigmas greater than 0")
    transition, noise = _discretise(trajectory, knowledge)
    R = np.diag(sigma**2)
    P = np.diag(_prior_variance(knowledge))

    fix_count = np.floor((trajectory.time - trajectory.time[0]) * knowledge.gnss_rate + 1e-6).astype(int)
    fixes = np.flatnonzero(np.diff(fix_count)) + 1
    is_fix = np.zeros(len(trajectory.time), dtype=bool)
    is_fix[fixes] = True

    variance = [P.diagonal().copy()]
    for k in range(1, len(trajectory.time)):
        P = transition[k - 1] @ P @ transition[k - 1].T + noise[k - 1]
        if is_fix[k]:
            gain = np.linalg.solve(P[VELOCITY, VELOCITY] + R, P[VELOCITY]).T
            P = P - gain @ P[VELOCITY]
            P = (P + P.T) / 2
            variance.append(P.diagonal().copy())
    time = np.concatenate((trajectory.time[:1], trajectory.time[fixes]))
    return Bound(time=time, sigma=np.sqrt(np.array(variance)))


def _prior_variance(knowledge: Knowledge) -> Array:
    k = knowledge
    sigma = [k.tilt_sigma, k.tilt_sigma, k.heading_sigma, *[k.velocity_sigma] * 3]
    sigma += [*[k.gyro_bias_sigma] * 3, *[k.accelerometer_bias_sigma] * 3]
    return np.array(sigma) ** 2


def _discretise(trajectory: Trajectory, knowledge: Knowledge) -> tuple[Array, Array]:
    """Transition and noise matrices of every interval of the trajectory, shapes (n - 1, 12, 12).

    The mean specific force of an interval follows exactly from the velocities at its ends,
    f_n = dv/dt + (2 w_ie + w_en) x v + g; the mean attitude from the attitudes at its ends.
    """
    dt = np.diff(trajectory.time)[:, None, None]
    if not np.all(dt > 0):
        raise ValueError("the times of a trajectory must increase")
    C_bn, velocity, latitude, height = (
        (x[1:] + x[:-1]) / 2
        for x in (trajectory.C_bn, trajectory.velocity, trajectory.latitude, trajectory.height)
    )
    w_ie = earth_rate(latitude)
    to_transport_rate = curvature(latitude, height)
    w_en = (to_transport_rate @ velocity[..., None])[..., 0]
    coriolis = skew(2 * w_ie + w_en)
    force = np.diff(trajectory.velocity, axis=0) / dt[..., 0] + (coriolis @ velocity[..., None])[..., 0]
    force[:, 2] += gravity(latitude, height)

    F = np.zeros((len(dt), STATES, STATES))
    F[:, ATTITUDE, ATTITUDE] = -skew(w_ie + w_en)
    F[:, ATTITUDE, VELOCITY] = to_transport_rate
    F[:, ATTITUDE, GYRO_BIAS] = -C_bn
    F[:, VELOCITY, ATTITUDE] = skew(force)
    F[:, VELOCITY, VELOCITY] = -coriolis
    F[:, VELOCITY, ACCELEROMETER_BIAS] = C_bn
    F *= dt
    transition = np.eye(STATES) + F + F @ F / 2 + F @ F @ F / 6

    Q = np.zeros(STATES)
    Q[ATTITUDE] = knowledge.angle_random_walk**2
    Q[VELOCITY] = knowledge.velocity_random_walk**2
    density = np.diag(Q) * dt
    half = np.eye(STATES) + F / 2
    return transition, half @ density @ np.swapaxes(half, -1, -2)
