"""How well can the heading be known: posterior Cramer-Rao bound along a true trajectory.

For a linear system with Gaussian noise the bound is the covariance of the matched Kalman filter (Tichavsky,
Muravchik and Nehorai 1998, IEEE Trans. Signal Process. 46(5), eq. 21). The errors of an inertial navigator
are linear when they are small, so the filter is linearised at the truth; with the states ::

    x = [phi (attitude), dv (velocity), eps (gyro bias), nabla (accelerometer bias), dr (position)]

of which dr counts only where positions are measured, its error model in ENU is (Zhou 2011, eqs. 12 and 13,
for small angles; computed minus true) ::

    phi' = -w_in x phi + dw_en(dv) - C_bn eps + gyro noise
    dv'  =  f_n x phi - (2 w_ie + w_en) x dv + v x dw_en(dv) + C_bn nabla + 2 g / R dr_up
            + accelerometer noise
    dr'  =  dv - w_en x dr
    eps' = 0,  nabla' = 0

What the latitude error does to w_ie is left out (below 1e-5 of it for tens of metres). GNSS observes velocity
and position of its antenna, at the lever arm l from the IMU; with w the body rate against the Earth (known up
to a gyro bias that matters nothing here) ::

    z_v = dv + C_bn (w x l) x phi,   z_r = dr + C_bn l x phi

A log measures the velocity in body axes; its scale factor error k is one state more ::

    z_u = C_nb (dv + phi x v) - k C_nb v

No filter that knows these statistics has a smaller mean square error, whatever its algorithm; RMS over time
of sigma(phi_up) is the figure to hold a filter's heading RMSE against. It is a mean over many runs: a single
run may well lie below.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios.attitude import skew
from sim_scenarios.earth import EARTH_RATE, curvature, earth_rate, gravity, radii
from sim_scenarios.errors import InputError
from sim_scenarios.metrics.statistics import rms
from sim_scenarios.rauch_tung_striebel import Forward, smooth
from sim_scenarios.timeline import inside
from sim_scenarios.units import DEGREE, HOUR, STANDARD_GRAVITY

Array = NDArray[np.float64]

ATTITUDE, VELOCITY, GYRO_BIAS, ACCELEROMETER_BIAS, POSITION = (slice(i, i + 3) for i in (0, 3, 6, 9, 12))
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

    def __getitem__(self, rows: slice) -> Trajectory:
        """Some of its samples."""
        return Trajectory(**{name: values[rows] for name, values in vars(self).items()})


@dataclass(frozen=True)
class Log:
    """Velocities in body axes: sigma (right, forward, up) [m/s], rate [Hz], sigma of its scale factor."""

    sigma: tuple[float, float, float]
    rate: float
    scale_sigma: float = 0.0


@dataclass(frozen=True)
class Knowledge:
    """What is known before and besides the measurements: prior sigmas, noise densities, GNSS; SI units.

    The defaults are those of the scenario of Zhou 2011. Sigmas of GNSS may be given for each axis (east,
    north, up); without one of the position there are no positions, with a rate of 0 no fixes. The lever arm
    runs from the IMU to the antenna (right, forward, up). A log stands at the IMU.
    """

    tilt_sigma: float = 1.0 * DEGREE
    heading_sigma: float = 10.0 * DEGREE
    velocity_sigma: float = 0.15
    gyro_bias_sigma: float = 0.05 * DEGREE / HOUR
    accelerometer_bias_sigma: float = 1e-3 * STANDARD_GRAVITY
    position_sigma: float = 5.0
    angle_random_walk: float = 0.005 * DEGREE / HOUR**0.5
    velocity_random_walk: float = 50e-6 * STANDARD_GRAVITY
    gnss_velocity_sigma: float | tuple[float, float, float] = 0.1
    gnss_position_sigma: float | tuple[float, float, float] | None = None
    gnss_rate: float = 1.0
    lever_arm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    log: Log | None = None

    def steady_course_limit(self, latitude: float) -> float:
        """Heading sigma that the east gyro bias leaves without manoeuvres: eps_E / (w_ie cos L) [rad]."""
        return self.gyro_bias_sigma / (EARTH_RATE * float(np.cos(latitude)))


@dataclass(frozen=True)
class Bound:
    """Covariance of the matched filter after each fix, and each measurement of a log.

    Attributes
    ----------
    time : ndarray, shape (m,)
        Times of the fixes, the start included [s].
    sigma : ndarray, shape (m, 12) or (m, 15), one column more with a log
        Square root of the diagonal of the covariance: attitude (east, north, up) [rad], velocity (east,
        north, up) [m/s], gyro bias (right, forward, up) [rad/s], accelerometer bias (right, forward, up)
        [m/s2], where positions are measured, position (east, north, up) [m], and the scale of a log.
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
        held = inside(self.time, start, stop)
        if not held.any():
            raise InputError(f"the bound has no fix between {start:g} s and {stop:g} s")
        return rms(self.heading_sigma[held])


def cramer_rao(trajectory: Trajectory, knowledge: Knowledge, *, smoothed: bool = False) -> Bound:
    """Posterior Cramer-Rao bound of the error states along a trajectory.

    Parameters
    ----------
    trajectory : Trajectory
        True motion.
    knowledge : Knowledge
        Prior, noise and GNSS.
    smoothed : bool
        That of what is known when all measurements are there, instead of those until then.

    Returns
    -------
    Bound
        At the start and after each fix.
    """
    prior = prior_sigma(knowledge)
    aids = aids_of(trajectory, knowledge)
    transition, noise = discretised(trajectory[:-1], trajectory[1:], white_noise(knowledge))
    predicted = np.empty((len(trajectory.time), len(prior), len(prior)))
    filtered = predicted.copy()
    predicted[0] = filtered[0] = P = np.diag(prior**2)
    measured = np.arange(len(trajectory.time)) == 0
    for k in range(1, len(trajectory.time)):
        predicted[k] = P = transition[k - 1] @ P @ transition[k - 1].T + noise[k - 1]
        for aid in aids:
            if aid.arriving[k]:
                measured[k] = True
                cross = aid.H[k] @ P
                P = P - cross.T @ np.linalg.solve(cross @ aid.H[k].T + aid.R / aid.arriving[k], cross)
                P = (P + P.T) / 2
        filtered[k] = P
    if smoothed:
        _, filtered = smooth(Forward(transition, predicted, filtered, np.zeros(predicted.shape[:2])))
    variance = np.diagonal(filtered[measured], axis1=1, axis2=2)
    return Bound(time=trajectory.time[measured], sigma=np.sqrt(variance))


@dataclass(frozen=True)
class Aid:
    """Measurement matrix at every time of the trajectory, noise covariance, how many arrive at each time."""

    H: Array
    R: Array
    arriving: NDArray[np.int_]


def aids_of(trajectory: Trajectory, knowledge: Knowledge) -> list[Aid]:
    """What measures along a trajectory. What comes between two of its samples counts at the later one."""
    log = knowledge.log
    states = len(prior_sigma(knowledge))
    aids = []
    for rate, sigma, observe in (
        (knowledge.gnss_rate, _measurement_sigma(knowledge), _observation),
        (log.rate if log else 0.0, np.array(log.sigma if log else ()), _observation_of_log),
    ):
        if rate > 0:
            if np.any(sigma <= 0):
                raise InputError("the bound needs GNSS and a log with sigmas greater than 0")
            count = np.floor((trajectory.time - trajectory.time[0]) * rate + 1e-6).astype(int)
            H = observe(trajectory, knowledge, states)
            aids.append(Aid(H, np.diag(sigma**2), np.diff(count, prepend=0)))
    if not aids:
        raise InputError("the bound needs GNSS or a log: a rate and sigmas greater than 0")
    return aids


def north_turned(offset: float) -> Array:
    """Matrix that turns the world to the left, for a heading too large by an offset [rad], shape (3, 3)."""
    turn: Array = Rotation.from_rotvec([0.0, 0.0, offset]).as_matrix()
    return turn


def white_noise(knowledge: Knowledge) -> Array:
    """Density of the noise that drives each state [its unit squared / s], shape (states,)."""
    density = np.zeros(len(prior_sigma(knowledge)))
    density[ATTITUDE] = knowledge.angle_random_walk**2
    density[VELOCITY] = knowledge.velocity_random_walk**2
    return density


def prior_sigma(knowledge: Knowledge) -> Array:
    """Of all states; those of the position count where positions are measured, a scale where a log is."""
    k = knowledge
    triples = [k.velocity_sigma, k.gyro_bias_sigma, k.accelerometer_bias_sigma]
    if k.gnss_position_sigma is not None:
        triples.append(k.position_sigma)
    scale = [k.log.scale_sigma] if k.log else []
    return np.array([k.tilt_sigma, k.tilt_sigma, k.heading_sigma, *np.repeat(triples, 3), *scale])


def _measurement_sigma(knowledge: Knowledge) -> Array:
    """Of the velocity and, where it is measured, of the position."""
    sigmas = [knowledge.gnss_velocity_sigma, knowledge.gnss_position_sigma]
    return np.concatenate([np.broadcast_to(sigma, 3) for sigma in sigmas if sigma is not None])


def _observation(trajectory: Trajectory, knowledge: Knowledge, states: int) -> Array:
    """Measurement matrix at every time of the trajectory, shape (n, 3 or 6, states)."""
    antenna = trajectory.C_bn @ np.array(knowledge.lever_arm)
    w_en = (curvature(trajectory.latitude, trajectory.height) @ trajectory.velocity[..., None])[..., 0]
    antenna_velocity = np.gradient(antenna, trajectory.time, axis=0) + np.cross(w_en, antenna)
    observed = [(VELOCITY, antenna_velocity), (POSITION, antenna)]
    if knowledge.gnss_position_sigma is None:
        observed.pop()
    H = np.zeros((len(antenna), 3 * len(observed), states))
    for row, (state, lever) in zip((slice(0, 3), slice(3, 6)), observed, strict=False):
        H[:, row, state] = np.eye(3)
        H[:, row, ATTITUDE] = skew(lever)
    return H


def _observation_of_log(trajectory: Trajectory, _: Knowledge, states: int) -> Array:
    """Likewise of a log, shape (n, 3, states)."""
    C_nb = np.swapaxes(trajectory.C_bn, -1, -2)
    H = np.zeros((len(C_nb), 3, states))
    H[:, :, VELOCITY] = C_nb
    H[:, :, ATTITUDE] = -C_nb @ skew(trajectory.velocity)
    H[:, :, -1] = -(C_nb @ trajectory.velocity[..., None])[..., 0]
    return H


def discretised(
    begin: Trajectory, end: Trajectory, density: Array, offset: float = 0.0
) -> tuple[Array, Array]:
    """Transition and noise matrices of the errors over the intervals between two samples of a trajectory.

    Parameters
    ----------
    begin, end, offset
        As of `error_dynamics`.
    density : ndarray, shape (states,)
        Of the white noise that drives each state [its unit squared / s]. Of 15 states on there are positions.

    Returns
    -------
    tuple of ndarray, shapes (n, states, states)
    """
    states = len(density)
    dt = (end.time - begin.time)[:, None, None]
    if not np.all(dt > 0):
        raise ValueError("the times of a trajectory must increase")
    F = error_dynamics(begin, end, states, offset) * dt
    square = F @ F
    transition = np.eye(states) + F + square / 2 + square @ F / 6
    half = np.eye(states) + F / 2
    return transition, half @ (np.diag(density) * dt) @ np.swapaxes(half, -1, -2)


def error_dynamics(begin: Trajectory, end: Trajectory, states: int, offset: float = 0.0) -> Array:
    """Matrix F of x' = F x over the intervals between two samples of a trajectory, shape (n, states, states).

    The mean specific force of an interval follows exactly from the velocities at its ends,
    f_n = dv/dt + (2 w_ie + w_en) x v + g; the mean attitude from the attitudes at its ends.

    Parameters
    ----------
    begin, end : Trajectory
        Of the intervals; n samples each.
    states : int
        12 without positions, 15 with; further ones are constants.
    offset : float
        By how much the heading about which the errors are small is larger than the true one [rad]. The errors
        are in axes that turn with it: in these attitude and specific force are what they are, and the Earth
        and the velocities are turned (`north_turned`).
    """
    dt = (end.time - begin.time)[:, None]
    C_bn, velocity, latitude, height = (
        (getattr(begin, name) + getattr(end, name)) / 2 for name in ("C_bn", "velocity", "latitude", "height")
    )
    w_ie = earth_rate(latitude)
    to_transport_rate = curvature(latitude, height)
    w_en = (to_transport_rate @ velocity[..., None])[..., 0]
    force = (end.velocity - begin.velocity) / dt + np.cross(2 * w_ie + w_en, velocity)
    g = gravity(latitude, height)
    force[:, 2] += g

    turn = north_turned(offset)
    w_ie, w_en, velocity = (vector @ turn.T for vector in (w_ie, w_en, velocity))
    to_transport_rate = turn @ to_transport_rate @ turn.T
    F = np.zeros((len(dt), states, states))
    F[:, ATTITUDE, ATTITUDE] = -skew(w_ie + w_en)
    F[:, ATTITUDE, VELOCITY] = to_transport_rate
    F[:, ATTITUDE, GYRO_BIAS] = -C_bn
    F[:, VELOCITY, ATTITUDE] = skew(force)
    F[:, VELOCITY, VELOCITY] = skew(velocity) @ to_transport_rate - skew(2 * w_ie + w_en)
    F[:, VELOCITY, ACCELEROMETER_BIAS] = C_bn
    if states >= POSITION.stop:
        F[:, POSITION, POSITION] = -skew(w_en)
        F[:, POSITION, VELOCITY] = np.eye(3)
        F[:, VELOCITY.stop - 1, POSITION.stop - 1] = 2 * g / radii(latitude)[1]
    return F
