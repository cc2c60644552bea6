"""How well can the heading be known whatever its error: its posterior, on a grid of headings.

The Cramer-Rao bound (see `bounds`) is that of small errors. With a wide prior, and gyros to which the Earth
rate is little, the heading may remain unknown by any part of the circle. The variance of its posterior, in
the mean over the data, is the least mean square error that an estimator can have (Van Trees and Bell 2007,
Bayesian Bounds for Parameter Estimation and Nonlinear Filtering/Tracking), and is computed here.

Given the heading to a few degrees, all else is linear and Gaussian. So the circle is laid out with hypotheses
psi_i, headings that are larger than the true one by psi_i, each with a weight and with a Kalman filter of all
states of `bounds`, the small deviation of the heading among them: a Rao-Blackwellised grid (Doucet, Godsill
and Andrieu 2000, Statistics and Computing 10(3)), as a Gaussian sum (Alspach and Sorenson 1972, IEEE Trans.
Automatic Control 17(4)), in which each hypothesis has a width.

**Hypotheses.** A heading that is too large by psi is a world that is turned to the left by psi, T = T(psi),
around a vehicle whose attitude is right. In axes that turn with the hypothesis, attitude and specific force
are what they are, while Earth rate, transport rate and velocity are T w_ie, T w_en and T v. About that motion
the errors obey x' = F_psi x + u_psi, with the input by which it contradicts the IMU ::

    u_phi = (I - T) w_in,   u_dv = (T - I) f_n,   T = I + sin psi [up x] + (1 - cos psi) [up x]^2

or u = -(sin psi I + (1 - cos psi) [up x]) F e_up; for small psi it is -F (psi e_up), so that a heading that
is off by psi is no other than a heading error of psi. Where the Earth turns and where the vehicle accelerates
u tells headings apart; as much of it as biases can explain stays in doubt. In axes of east and north GNSS
measures H_psi = T' H_0, and expects another part l of the lever arm, h_psi - h_0 = (T' - I) l. A log is left
out: by the velocities that x_0 below grows to, it would tell the heading.

**Data.** Biases are drawn into what the IMU measures along the true motion. The other errors x_0, of the
start and of noise, are drawn into the motion: the vehicle moves otherwise, and GNSS shows it. Were noise in
what the IMU measures, it would be an acceleration of which GNSS shows nothing, whatever the heading, and the
posterior, to which every motion is as likely, would become too sure. Of biases the same is true until they
and the tilts are told apart from noise, in the first half minute, and makes a few per cent there. They are
not drawn into the motion because it would sway with them, and tell the heading to GNSS by that. With the mean
m less the true biases ::

    m- = Phi_psi m + u_psi,   m = m- + K nu,   nu = h_psi - h_0 + H_0 x_0 + v - H_psi m-
    log p_i = log p_i - nu' S^-1 nu / 2 - log det S / 2

and the heading of a hypothesis is off by psi_i - m_up + x_0,up. Phi, u, H and h are trigonometric polynomials
of psi up to the square of Earth rate times interval (1e-8), so that those of five headings give those of all.

**Prior.** The heading known beforehand is off by e_0 ~ N(0, sigma^2), around the circle. With a sigma of a
hypothesis of 3/4 of a spacing, their sum is that prior to 1e-4, and in each of them the errors are small.

What comes out is a mean over draws of the data, and has a standard error. It is least in the mean over
motions that differ from the true one by their heading; but for the transport rate those are alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from sim_scenarios.attitude import wrap
from sim_scenarios.bounds import (
    ACCELEROMETER_BIAS,
    ATTITUDE,
    GYRO_BIAS,
    HEADING,
    VELOCITY,
    Knowledge,
    Trajectory,
    aids_of,
    discretised,
    error_dynamics,
    north_turned,
    prior_sigma,
    white_noise,
)
from sim_scenarios.errors import InputError
from sim_scenarios.timeline import within
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

DRAWS: Final = 200
SEED: Final = 1
SPACING: Final = 1.5 * DEGREE
"""Between hypotheses [rad]; 3 deg make the bound of twenty minutes of turns 3 % too large, 1.5 deg 0.6 %."""
HYPOTHESES: Final[Array] = np.arange(240, dtype=np.float64) * SPACING
"""By how much their headings are larger than the true one [rad]."""
WIDTH: Final = 0.75 * SPACING
"""Sigma of the heading of a hypothesis [rad]."""
NOTHING_KNOWN: Final = 100.0 * DEGREE
"""Prior sigma from which on the heading is uniform on the circle, which has 103.9 deg [rad]."""
WIDE: Final = 20.0 * DEGREE
"""Prior sigma from which on errors are not small [rad]: with it the two bounds are within 5 %."""
NODES: Final = 2 * np.pi / 5 * np.arange(5)
"""Hypotheses that tell a trigonometric polynomial of the second order [rad]; the first is the truth."""
UP: Final = (0.0, 0.0, 1.0)
NEGLIGIBLE: Final = -30.0
"""Logarithm of a weight, against the largest, with which a hypothesis goes."""


@dataclass(frozen=True)
class HeadingPosterior:
    """Posterior of the heading after each fix, of every draw of the data.

    Attributes
    ----------
    time : ndarray, shape (m,)
        Times of the fixes, the start included [s].
    variance : ndarray, shape (m, draws)
        Of the heading, around the circle [rad^2].
    error : ndarray, shape (m, draws)
        Of its mean, wrapped to [-pi, pi) [rad].
    """

    time: Array
    variance: Array
    error: Array

    @property
    def heading_sigma(self) -> Array:
        """Least root mean square error of the heading at each fix [rad], shape (m,)."""
        sigma: Array = np.sqrt(self.variance.mean(axis=1))
        return sigma

    @property
    def heading_rmse(self) -> Array:
        """That of the posterior mean in the draws at each fix [rad], shape (m,): the same but for chance."""
        rmse: Array = np.sqrt(np.square(self.error).mean(axis=1))
        return rmse

    def heading_rms(self, start: float, stop: float) -> tuple[float, float]:
        """Root mean square of the heading sigma over start..stop, and its standard error [rad].

        Raises
        ------
        InputError
            There is no fix.
        """
        each = within(self.time, self.variance, start, stop).mean(axis=0)
        rms = float(np.sqrt(each.mean()))
        return rms, float(each.std(ddof=1)) / len(each) ** 0.5 / (2 * rms)


def heading_posterior(
    trajectory: Trajectory, knowledge: Knowledge, *, draws: int = DRAWS, seed: int = SEED
) -> HeadingPosterior:
    """Posterior of the heading along a trajectory, for draws of the data.

    Parameters
    ----------
    trajectory : Trajectory
        True motion.
    knowledge : Knowledge
        Prior, noise and GNSS.
    draws : int
        Of data; two at least.
    seed : int
        Of the draws.

    Returns
    -------
    HeadingPosterior
        At the start and after each fix.

    Raises
    ------
    InputError
        There is no GNSS, no fix, or a log; or the heading is known better than a hypothesis is wide.
    """
    if knowledge.heading_sigma <= WIDTH:
        raise InputError(f"the posterior needs a heading sigma of more than {WIDTH / DEGREE:g} deg")
    if knowledge.log is not None:
        raise InputError("the posterior of the heading knows no log")
    (gnss,) = aids_of(trajectory, knowledge)
    measured = np.flatnonzero(gnss.arriving)
    if not len(measured):
        raise InputError("the bound of heading errors of any size needs a fix")
    generator = np.random.default_rng(seed)
    sigma = prior_sigma(knowledge)
    sigma[HEADING] = 0.0  # what is not known of it, the weights say
    drawn = sigma * generator.standard_normal((draws, len(sigma)))
    sigma[HEADING] = WIDTH
    is_bias = np.isin(np.arange(len(sigma)), np.r_[GYRO_BIAS, ACCELEROMETER_BIAS])
    true = np.where(is_bias, 0.0, drawn)
    posterior = _GaussianSum(_prior(knowledge.heading_sigma, draws), drawn - true, sigma)
    moments = [posterior.moments(true[:, HEADING])]
    for k, transition, put_in, noise in zip(measured, *_steps(trajectory, knowledge, measured), strict=True):
        posterior.predict(transition, put_in, noise)
        true = true @ transition[0].T + _normal(generator, noise, draws)
        R = gnss.R / gnss.arriving[k]
        posterior.correct(*_expected(gnss.H[k]), R, true @ gnss.H[k].T + _normal(generator, R, draws))
        posterior.prune()
        moments.append(posterior.moments(true[:, HEADING]))
    variance, error = np.moveaxis(np.array(moments), 1, 0)
    return HeadingPosterior(trajectory.time[[0, *measured]], variance, error)


class _GaussianSum:
    """Posterior of each draw: g hypotheses psi, each with a filter, whose covariances the draws share.

    What depends on psi comes in as that of `NODES`, in front.
    """

    def __init__(self, log_weight: Array, mean: Array, sigma: Array) -> None:
        """With what is known beforehand: shapes (g, draws), (draws, states) and (states,)."""
        self.psi = HYPOTHESES
        self.log_weight = log_weight
        self.mean = np.repeat(mean[None], len(self.psi), axis=0)
        self.P = np.repeat(np.diag(sigma**2)[None], len(self.psi), axis=0)

    def predict(self, transition: Array, put_in: Array, noise: Array) -> None:
        """To the next fix: shapes (nodes, states, states), (nodes, states) and (states, states)."""
        Phi = on_the_circle(self.psi, transition)
        self.P = Phi @ self.P @ Phi.swapaxes(-1, -2) + noise
        self.mean = self.mean @ Phi.swapaxes(-1, -2) + on_the_circle(self.psi, put_in)[:, None]

    def correct(self, H: Array, expected: Array, R: Array, measurement: Array) -> None:
        """With m that are measured: shapes (nodes, m, states), (nodes, m), (m, m) and (draws, m)."""
        H, expected = on_the_circle(self.psi, H), on_the_circle(self.psi, expected)
        cross = H @ self.P
        S = cross @ H.swapaxes(-1, -2) + R
        gain = np.linalg.solve(S, cross)
        innovation = expected[:, None] + measurement - self.mean @ H.swapaxes(-1, -2)
        whitened = innovation @ np.linalg.inv(S)
        self.mean = self.mean + innovation @ gain
        self.P = self.P - cross.swapaxes(-1, -2) @ gain
        self.P = (self.P + self.P.swapaxes(-1, -2)) / 2
        self.log_weight = (
            self.log_weight
            - (np.sum(whitened * innovation, axis=-1) + np.linalg.slogdet(S).logabsdet[:, None]) / 2
        )

    def prune(self) -> None:
        """Leave out the headings that no draw holds possible any longer."""
        possible = np.any(self.log_weight > self.log_weight.max(axis=0) + NEGLIGIBLE, axis=1)
        if not possible.all():
            for name, values in vars(self).items():
                setattr(self, name, values[possible])

    def moments(self, true: Array) -> tuple[Array, Array]:
        """Variance of the heading and error of its mean, around the circle; all of shape (draws,)."""
        weight = np.exp(self.log_weight - self.log_weight.max(axis=0))
        weight /= weight.sum(axis=0)
        heading = self.psi[:, None] - self.mean[..., HEADING]
        centre = np.angle(np.sum(weight * np.exp(1j * heading), axis=0))
        centre += np.sum(weight * wrap(heading - centre), axis=0)
        spread = np.square(wrap(heading - centre)) + self.P[:, HEADING, HEADING, None]
        return np.sum(weight * spread, axis=0), wrap(centre + true)


def on_the_circle(psi: Array, of_nodes: Array) -> Array:
    """At each of headings, of a trigonometric polynomial that is known at `NODES`.

    Shapes (g,) and (nodes, ...) -> (g, ...).
    """
    apart = psi[:, None] - NODES
    share = (1 + 2 * np.cos(apart) + 2 * np.cos(2 * apart)) / len(NODES)
    of_each: Array = np.tensordot(share, of_nodes, axes=1)
    return of_each


def _prior(sigma: float, draws: int) -> Array:
    """Logarithm of the weights of hypotheses, shape (g, draws); a draw is off by a quantile of the prior."""
    if sigma >= NOTHING_KNOWN:
        return np.zeros((len(HYPOTHESES), draws))
    off = sigma * ndtri((np.arange(draws) + 0.5) / draws)
    around = HYPOTHESES[:, None, None] - off[:, None] + 2 * np.pi * np.arange(-3, 4)
    log_weight: Array = np.logaddexp.reduce(-np.square(around) / (2 * (sigma**2 - WIDTH**2)), axis=-1)
    return log_weight


def _expected(H: Array) -> tuple[Array, Array]:
    """Of GNSS under the hypotheses `NODES`: H, and by how much more it is expected to measure.

    Shape (m, states) -> (nodes, m, states) and (nodes, m).
    """
    of_heading = H[:, HEADING].reshape(-1, 3)  # l x up
    matrices, more = [], []
    for psi in NODES:
        matrices.append(np.concatenate([north_turned(psi).T @ rows for rows in H.reshape(-1, 3, H.shape[1])]))
        more.append((np.sin(psi) * of_heading - (1 - np.cos(psi)) * np.cross(UP, of_heading)).ravel())
    return np.array(matrices), np.array(more)


def _steps(
    trajectory: Trajectory, knowledge: Knowledge, measured: NDArray[np.intp]
) -> tuple[Array, Array, Array]:
    """From each fix to the next: x = transition x + input, of the nodes, and the noise of the truth.

    Shapes (m, nodes, states, states), (m, nodes, states) and (m, states, states).
    """
    transition, put_in, noise = (
        np.stack(of_nodes, axis=1)
        for of_nodes in zip(
            *(_composed(trajectory, knowledge, node, measured) for node in NODES), strict=True
        )
    )
    return transition, put_in, noise[:, 0]


def _composed(
    trajectory: Trajectory, knowledge: Knowledge, psi: float, measured: NDArray[np.intp]
) -> tuple[Array, Array, Array]:
    """From each fix to the next, of one hypothesis."""
    begin, end, density = trajectory[:-1], trajectory[1:], white_noise(knowledge)
    dt = np.diff(trajectory.time)[:, None]
    of_heading = error_dynamics(begin, end, len(density))[..., HEADING] * dt
    turned = np.zeros_like(of_heading)
    for part in (ATTITUDE, VELOCITY):
        turned[:, part] = np.cross(UP, of_heading[:, part])
    contradiction = -np.sin(psi) * of_heading - (1 - np.cos(psi)) * turned
    F = error_dynamics(begin, end, len(density), psi) * dt[..., None]
    put_in = contradiction + (F @ contradiction[..., None])[..., 0] / 2
    transition, noise = discretised(begin, end, density, psi)
    ends = set(measured.tolist())
    steps = []
    for k in range(measured[-1]):
        if k == 0 or k in ends:
            Phi, u, Q = np.eye(len(density)), np.zeros(len(density)), np.zeros_like(noise[0])
        Phi, u = transition[k] @ Phi, transition[k] @ u + put_in[k]
        Q = transition[k] @ Q @ transition[k].T + noise[k]
        if k + 1 in ends:
            steps.append((Phi, u, Q))
    transitions, inputs, noises = (np.array(each) for each in zip(*steps, strict=True))
    return transitions, inputs, noises


def _normal(generator: np.random.Generator, covariance: Array, draws: int) -> Array:
    """Draws of a normal distribution of mean 0 whose covariance may be singular, shape (draws, states)."""
    size = np.sqrt(np.maximum(covariance.diagonal(), np.finfo(float).tiny))  # states of many units
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn: Array = size * (generator.standard_normal((draws, len(size))) @ root.T)
    return drawn
