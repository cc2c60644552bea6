"""Allan variance of a sensor at rest: measured, and that of each kind of noise.

A noise is given by the structure function of its integral, an angle or a velocity,

    D(t) = Var[theta(s + t) - theta(s)],

generalised where the variance itself does not exist. From it follow the Allan variance and the covariance of
mean rates alike (IEEE Std 952, annex C, has the variances):

    sigma^2(t) = (4 D(t) - D(2 t)) / (2 t^2).

    quantisation Q        D = 2 Q^2  (t > 0)                    sigma^2 = 3 Q^2 / t^2
    white noise N         D = N^2 t                             sigma^2 = N^2 / t
    bias instability B    D = -(B^2 / pi) t^2 ln t              sigma^2 = (2 ln 2 / pi) B^2
    rate random walk K    D = -K^2 t^3 / 6                      sigma^2 = K^2 t / 3
    Gauss-Markov s, T     D = 2 s^2 T^2 (t / T - 1 + exp(-t / T))

Units: u is rad for gyros, m/s for accelerometers; Q in u, N in u/s^0.5, B and s in u/s, K in u/s^1.5, T in s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from sim_scenarios.errors import InputError

Array = NDArray[np.float64]

CONFIDENCE: Final = 0.95
"""Of every interval."""
FLICKER_FLOOR: Final = float(np.sqrt(2 * np.log(2) / np.pi))
"""Allan deviation of bias instability over B: 0.664."""

UNIT_STRUCTURES: Final[Mapping[str, Callable[[Array], Array]]] = {
    "quantisation": lambda t: np.where(t > 0, 2.0, 0.0),
    "white_noise": lambda t: t,
    "bias_instability": lambda t: -(t**2) * np.log(np.where(t > 0, t, 1.0)) / np.pi,
    "random_walk": lambda t: -(t**3) / 6,
}
"""D(t) of the noises that have one parameter, of size 1."""


def structure(sizes: Mapping[str, float], lag: Array) -> Array:
    """D(t) of independent noises together, by name of parameter and size; lags in s."""
    total = np.zeros_like(lag)
    for name, unit in UNIT_STRUCTURES.items():
        total += sizes.get(name, 0.0) ** 2 * unit(lag)
    if "markov_sigma" in sizes:
        total += sizes["markov_sigma"] ** 2 * markov_structure(lag, sizes["markov_time"])
    return total


def markov_structure(lag: Array, time: float) -> Array:
    """D(t) of a first-order Gauss-Markov process with a sigma of 1."""
    return 2 * time**2 * (lag / time + np.expm1(-lag / time))


def allan_deviation(sizes: Mapping[str, float], tau: Array) -> Array:
    """Allan deviation of independent noises together [u/s]."""
    return np.sqrt((4 * structure(sizes, tau) - structure(sizes, 2 * tau)) / 2) / tau


@dataclass(frozen=True)
class AllanCurve:
    """Measured Allan deviation of one axis, each point with its interval.

    Attributes
    ----------
    tau : ndarray, shape (n,)
        Averaging times, octaves [s].
    deviation, lower, upper : ndarray, shape (n,)
        [u/s]
    """

    tau: Array
    deviation: Array
    lower: Array
    upper: Array


def allan_curve(increments: Array, period: float) -> AllanCurve:
    """Overlapping Allan deviation of increments at a steady rate.

    Parameters
    ----------
    increments : ndarray, shape (n,)
        Integrals of the rate over consecutive periods [u].
    period : float
        [s]

    Returns
    -------
    AllanCurve
        The intervals are those of chi-square with the equivalent degrees of freedom of the noise that the
        slope of the curve shows (Greenhall and Riley 2004).
    """
    try:
        import allantools
    except ImportError:
        raise InputError("an Allan deviation needs allantools: pip install 'truenorth[recordings]'") from None
    integral = np.concatenate([[0.0], np.cumsum(increments)])
    tau, deviation, _, _ = allantools.oadev(integral, rate=1 / period, data_type="phase", taus="octave")
    slopes = np.gradient(np.log(deviation), np.log(tau)) if len(tau) > 1 else np.array([-0.5])
    degrees = np.array(
        [
            allantools.edf_greenhall(
                alpha=_noise_exponent(slope), d=2, m=round(t / period), N=len(integral), overlapping=True
            )
            for t, slope in zip(tau, slopes, strict=True)
        ]
    )
    tail = (1 - CONFIDENCE) / 2
    lower, upper = (deviation * np.sqrt(degrees / chi2.ppf(p, degrees)) for p in (1 - tail, tail))
    return AllanCurve(tau, deviation, lower, upper)


def _noise_exponent(slope: float) -> int:
    """Exponent of frequency in the spectrum of the rate, by the slope of the Allan deviation.

    1 and 2 have the same slope; allantools lacks the degrees of freedom of 2 where tau is long.
    """
    return int(np.clip(round(-2 * slope) - 1, -2, 1))
