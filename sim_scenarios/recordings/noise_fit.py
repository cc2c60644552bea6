"""Noise of sensors at rest by maximum likelihood.

The stretch is cut into n blocks of equal length h. Their mean rates y_j go through the cosine transform

    z_k = sqrt(2 / n) sum_j y_j cos(w_k (j + 1/2)),    w_k = pi k / n,    k = 1 ... n - 1.

The unknown bias is z_0 and drops out. Of white noise and of a random walk the z_k are independent, exactly;
of the other noises nearly so. With c_m the covariance of block means m blocks apart, which follows from D(t)
of `allan`, their variances are

    c_m = (D((m+1) h) - 2 D(m h) + D(|m-1| h)) / (2 h^2)
    Var z_k = c_0 + (2 / n) sum_{m > 0} c_m ((n - m) cos(m w_k) - sin(m w_k) / sin(w_k)).

The parameters are those that make the Gaussian z_k most likely. An interval holds the values of a parameter
at which the logarithm of the likelihood, with the others where they are best, is less than half the quantile
of chi-square below its maximum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, rfft
from scipy.stats import chi2

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.allan import CONFIDENCE, UNIT_STRUCTURES, markov_structure
from sim_scenarios.recordings.scoring import Loss, descend

Array = NDArray[np.float64]

BLOCK: Final = 1.0
"""Length of a block [s], the longest interval between a filter's predictions: what is faster is no noise."""
BLOCKS: Final = (256, 8192)
"""Of a stretch: blocks are shorter than `BLOCK` where there were fewer, longer where there were more."""
FEWEST: Final = 64
"""Blocks below which nothing is fitted."""
SLOW: Final = 10.0
"""Least correlation time of a Gauss-Markov process, in blocks; a faster one is white noise."""
MODELS: Final[Mapping[str, tuple[str, ...]]] = {
    name + and_quantisation: (*names, *added)
    for and_quantisation, added in (("", ()), (", quantisation", ("quantisation",)))
    for name, names in {
        "white noise, random walk": ("white_noise", "random_walk"),
        "white noise, random walk, bias instability": ("white_noise", "random_walk", "bias_instability"),
        "white noise, random walk, Gauss-Markov": (
            "white_noise",
            "random_walk",
            "markov_sigma",
            "markov_time",
        ),
    }.items()
}
"""Parameters of the sums of noises that are tried."""
RECOGNITION: Final = 0.99
"""Confidence with which a noise must be seen to be taken into the sum."""
CHANCE: Final = 1e-3
"""Probability below which a misfit is not by chance."""
_RANGE: Final = (1e-4, 10.0)
"""Sizes of a noise over that with which it alone would make the scatter of the block means."""


@dataclass(frozen=True)
class Estimate:
    """A value and the ends of its 95 % interval."""

    value: float
    lower: float
    upper: float


@dataclass(frozen=True)
class NoiseFit:
    """Noises of one axis, or of several that share them.

    Attributes
    ----------
    model : str
        Of `MODELS`.
    estimates : dict of str to Estimate
        By name of parameter, in the units of `allan`. With a lower end of 0 the noise has not been seen.
    loss : float
        Negative logarithm of the likelihood.
    explains : bool
        Whether the scatter is that of these noises at all frequencies; if not, the vehicle has moved, or the
        sensor has a noise of another kind.
    """

    model: str
    estimates: dict[str, Estimate]
    loss: float
    explains: bool

    @property
    def sizes(self) -> dict[str, float]:
        """Values by name of parameter."""
        return {name: estimate.value for name, estimate in self.estimates.items()}


def block_means(increments: Array, period: float) -> tuple[Array, float]:
    """Mean rates of blocks, shape (n, axes) [u/s], and their length h [s].

    Parameters
    ----------
    increments : ndarray, shape (samples, axes)
        Integrals of the rate over consecutive periods [u].
    period : float
        [s]
    """
    span = len(increments) * period
    length = max(min(BLOCK, span / BLOCKS[0]), span / BLOCKS[1])
    samples = max(1, round(length / period))
    blocks = len(increments) // samples
    if blocks < FEWEST:
        raise InputError(f"a fit of noises needs at least {FEWEST} samples; there are {len(increments)}")
    h = samples * period
    return increments[: blocks * samples].reshape(blocks, samples, -1).sum(axis=1) / h, h


def fit(rates: Array, h: float, models: Sequence[str] = tuple(MODELS)) -> NoiseFit:
    """Noises that several axes share.

    Parameters
    ----------
    rates : ndarray, shape (n, axes)
        Mean rates of consecutive blocks [u/s].
    h : float
        Length of a block [s].
    models : sequence of str
        Of `MODELS`; for each parameter more, one must be more likely than another with `RECOGNITION`.
    """
    candidates = {model: _Likelihood(rates, h, MODELS[model]) for model in models}
    found = {model: likelihood.maximum() for model, likelihood in candidates.items()}
    price = chi2.ppf(RECOGNITION, 1)
    best = min(models, key=lambda model: 2 * found[model][1] + len(MODELS[model]) * price)
    likelihood, (at, least) = candidates[best], found[best]
    return NoiseFit(best, likelihood.estimates(at, least), least, likelihood.explains(at))


def cosine_variances(D: Array, h: float) -> Array:
    """Var z_k, shape (n - 1,), of D(m h), shape (n + 1,)."""
    n = len(D) - 1
    c = np.concatenate([[(D[1] - D[0]) / h**2], (D[2:] - 2 * D[1:-1] + D[:-2]) / (2 * h**2)])
    m, w = np.arange(n), np.pi * np.arange(1, n) / n
    cosines = rfft((n - m) * c, 2 * n).real[1:n]
    sines = -rfft(c, 2 * n).imag[1:n]
    variances: Array = (2 * cosines - 2 * sines / np.sin(w)) / n - c[0]
    return variances


class _Likelihood:
    """Negative logarithm of the likelihood over the logarithms of the parameters of one model."""

    def __init__(self, rates: Array, h: float, names: Sequence[str]) -> None:
        n, self.axes = rates.shape
        self.names, self.h, self.span = tuple(names), h, n * h
        self.powers = np.sum(dct(rates, axis=0, norm="ortho")[1:] ** 2, axis=1)
        self.lags = h * np.arange(n + 1)
        self.units = {
            name: cosine_variances(unit(self.lags), h)
            for name, unit in UNIT_STRUCTURES.items()
            if name in names
        }
        scatter = float(np.median(self.powers)) / self.axes
        if scatter == 0.0:
            raise InputError("the increments do not change: there is no noise in them")
        self.scales = {name: np.sqrt(scatter / np.median(unit)) for name, unit in self.units.items()}
        self.scales["markov_sigma"] = np.sqrt(scatter)

    def bounds(self) -> list[tuple[float, float]]:
        """Of the logarithms."""
        limits = {name: np.log(scale * np.array(_RANGE)) for name, scale in self.scales.items()}
        limits["markov_time"] = np.log([SLOW * self.h, self.span / 5])
        return [(float(limits[name][0]), float(limits[name][1])) for name in self.names]

    def explains(self, at: Array) -> bool:
        """Whether the powers scatter about their variances as they should, octave by octave."""
        excess = self.powers / self._variances(at)[0] / self.axes
        octaves = np.floor(np.log2(np.arange(1, len(excess) + 1))).astype(int)
        counts = np.bincount(octaves)
        means = np.bincount(octaves, excess) / counts
        # The cube root of chi-square over its degrees of freedom is about normal (Wilson and Hilferty).
        spread = 2 / (9 * counts * self.axes)
        deviations = (np.cbrt(means) - (1 - spread)) / np.sqrt(spread)
        return bool(chi2.sf(np.sum(deviations**2), len(counts)) > CHANCE)

    def __call__(self, at: Array) -> Loss:
        variances, slopes = self._variances(at)
        relative = np.array([slopes[name] for name in self.names]) / variances
        excess = self.powers / variances
        value = float(np.sum(self.axes * np.log(variances) + excess)) / 2
        return Loss(value, relative @ (self.axes - excess) / 2, self.axes * (relative @ relative.T) / 2)

    def _variances(self, at: Array) -> tuple[Array, dict[str, Array]]:
        """Var z_k, and their derivatives by the logarithms of the parameters."""
        sizes = dict(zip(self.names, np.exp(at), strict=True))
        parts = {name: sizes[name] ** 2 * unit for name, unit in self.units.items()}
        slopes = {name: 2 * part for name, part in parts.items()}
        if "markov_time" in sizes:
            variance, time = sizes["markov_sigma"] ** 2, sizes["markov_time"]
            part = variance * cosine_variances(markov_structure(self.lags, time), self.h)
            decay = np.exp(-self.lags / time)
            by_time = 2 * (self.lags - 2 * time + (2 * time + self.lags) * decay)
            parts["markov_sigma"], slopes["markov_sigma"] = part, 2 * part
            slopes["markov_time"] = variance * time * cosine_variances(by_time, self.h)
        return np.sum(list(parts.values()), axis=0), slopes

    def maximum(self) -> tuple[Array, float]:
        """Most likely parameters, and the value there."""
        times = self.span / np.array([1000.0, 200.0, 50.0, 15.0]) if "markov_time" in self.names else [1.0]
        return min((self._descended(self._start(time)) for time in times), key=lambda found: found[1])

    def _start(self, time: float) -> Array:
        sizes = {name: 0.03 * scale for name, scale in self.scales.items()}
        sizes |= {"white_noise": self.scales["white_noise"], "markov_time": time}
        return np.log([sizes[name] for name in self.names])

    def _descended(self, start: Array, fixed: int | None = None) -> tuple[Array, float]:
        low, high = np.transpose(self.bounds())
        at, loss = descend(self, start, low, high, fixed=fixed)
        return at, loss.value

    def estimates(self, at: Array, least: float) -> dict[str, Estimate]:
        """Values and intervals."""
        return {
            name: Estimate(float(np.exp(at[i])), *(self._end(i, at, least, side) for side in (0, 1)))
            for i, name in enumerate(self.names)
        }

    def _end(self, i: int, at: Array, least: float, side: int) -> float:
        """Lower (0) or upper (1) end of an interval: the root of twice the loss is that of the quantile."""
        goal = np.sqrt(chi2.ppf(CONFIDENCE, 1))
        farthest = abs(self.bounds()[i][side] - at[i])
        away, others = 0.1, at
        for _ in range(20):
            away = min(away, farthest)
            there = others.copy()
            there[i] = at[i] + (away if side else -away)
            others, value = self._descended(there, fixed=i)
            root = np.sqrt(2 * max(value - least, 0.0))
            if abs(root - goal) < 0.01 * goal:
                break
            if away == farthest and root < goal:
                return float(np.inf) if side else 0.0
            away *= float(np.clip(goal / max(root, 1e-6), 0.3, 3.0))
        return float(np.exp(others[i]))
