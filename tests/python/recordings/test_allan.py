"""Allan deviations and noises at rest, against closed forms and against noises that were made."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.fft import dct
from scipy.linalg import toeplitz
from scipy.signal import lfilter
from scipy.stats import binom

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import noise_fit
from sim_scenarios.recordings.allan import allan_curve, allan_deviation, structure
from sim_scenarios.recordings.noise_fit import MODELS, block_means, cosine_variances, fit

Array = NDArray[np.float64]

NOISES = [
    {"white_noise": 0.7},
    {"random_walk": 0.02},
    {"bias_instability": 0.3},
    {"markov_sigma": 0.4, "markov_time": 30.0},
    {"quantisation": 0.2},
]


def made(sizes: dict[str, float], blocks: int, h: float, seed: int, axes: int = 3, parts: int = 5) -> Array:
    """Mean rates of blocks of white noise, random walk and Gauss-Markov noise, from `parts` steps in each."""
    random = np.random.default_rng(seed)
    shape, dt = (blocks * parts, axes), h / parts
    rate = sizes.get("white_noise", 0.0) / np.sqrt(dt) * random.standard_normal(shape)
    rate += np.cumsum(sizes.get("random_walk", 0.0) * np.sqrt(dt) * random.standard_normal(shape), axis=0)
    if "markov_sigma" in sizes:
        decay = np.exp(-dt / sizes["markov_time"])
        drive = np.sqrt(1 - decay**2) * random.standard_normal(shape)
        drive[0] = random.standard_normal(axes)
        rate += sizes["markov_sigma"] * lfilter([1], [1, -decay], drive, axis=0)
    return rate.reshape(blocks, parts, axes).mean(axis=1)


@pytest.mark.parametrize(
    ("sizes", "variance"),
    [
        ({"quantisation": 0.2}, lambda t: 3 * 0.2**2 / t**2),
        ({"white_noise": 0.7}, lambda t: 0.7**2 / t),
        ({"bias_instability": 0.3}, lambda t: 0.3**2 * 2 * np.log(2) / np.pi + 0 * t),
        ({"random_walk": 0.02}, lambda t: 0.02**2 * t / 3),
        (  # IEEE Std 952, correlated noise
            {"markov_sigma": 0.4, "markov_time": 30.0},
            lambda t: (
                2 * 0.4**2 * 30 / t * (1 - 30 / (2 * t) * (3 - 4 * np.exp(-t / 30) + np.exp(-2 * t / 30)))
            ),
        ),
    ],
)
def test_allan_variance_of_each_noise(sizes: dict[str, float], variance) -> None:
    tau = np.geomspace(0.1, 1e4, 30)
    assert allan_deviation(sizes, tau) ** 2 == pytest.approx(variance(tau), rel=1e-6)


def test_independent_noises_add_up() -> None:
    tau = np.geomspace(1.0, 1000.0, 10)
    together = {name: size for sizes in NOISES for name, size in sizes.items()}
    parts = sum(allan_deviation(sizes, tau) ** 2 for sizes in NOISES)
    assert allan_deviation(together, tau) ** 2 == pytest.approx(parts, rel=1e-9)


def test_measured_deviation_is_that_of_the_noise() -> None:
    increments = 0.7 * np.sqrt(0.01) * np.random.default_rng(1).standard_normal(200_000)
    curve = allan_curve(increments, 0.01)
    true = allan_deviation({"white_noise": 0.7}, curve.tau)
    assert curve.tau[0] == pytest.approx(0.01)
    inside = (curve.lower < true) & (true < curve.upper)
    assert np.mean(inside) > 0.8
    assert np.all(np.diff(curve.upper / curve.lower) > -0.1)  # the longer, the less is known


@pytest.mark.parametrize("sizes", NOISES, ids=lambda sizes: next(iter(sizes)))
def test_variances_of_the_cosine_transform(sizes: dict[str, float]) -> None:
    n, h = 40, 2.0
    D = structure(sizes, h * np.arange(n + 1))
    covariance = toeplitz([(D[1] - D[0]) / h**2, *(D[2:] - 2 * D[1:-1] + D[:-2]) / (2 * h**2)])
    transform = dct(np.eye(n), axis=0, norm="ortho")
    expected = transform @ covariance @ transform.T
    assert cosine_variances(D, h) == pytest.approx(np.diag(expected)[1:], rel=1e-9)
    if next(iter(sizes)) in ("white_noise", "random_walk"):
        assert expected[1:, 1:] == pytest.approx(np.diag(np.diag(expected)[1:]), abs=1e-9 * expected[1, 1])


@pytest.mark.parametrize("model", MODELS)
def test_gradient_and_information_of_the_likelihood(model: str) -> None:
    likelihood = noise_fit._Likelihood(np.random.default_rng(3).standard_normal((200, 2)), 1.5, MODELS[model])
    at = likelihood._start(40.0) + 0.3
    step = 1e-5 * np.eye(len(at))
    numerical = [(likelihood(at + s).value - likelihood(at - s).value) / 2e-5 for s in step]
    assert likelihood(at).gradient == pytest.approx(numerical, rel=1e-4, abs=1e-4)
    variances = [np.log(likelihood._variances(at + s)[0]) for s in step]
    slopes = np.array([v - np.log(likelihood._variances(at)[0]) for v in variances]) / 1e-5
    assert likelihood(at).information == pytest.approx(2 * slopes @ slopes.T / 2, rel=1e-2, abs=1e-3)


def test_blocks_keep_the_integral() -> None:
    increments = np.random.default_rng(4).standard_normal((30_000, 3))
    rates, h = block_means(increments, 0.01)
    assert h == pytest.approx(1.0)
    assert rates.sum(axis=0) * h == pytest.approx(increments.sum(axis=0))


def test_too_few_samples_are_refused() -> None:
    with pytest.raises(InputError, match="at least 64 samples; there are 20"):
        block_means(np.ones((20, 3)), 0.01)


def test_sensor_that_is_stuck_is_refused() -> None:
    with pytest.raises(InputError, match="no noise"):
        fit(np.ones((100, 3)), 1.0)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    "sizes",
    [
        {"white_noise": 1.0, "random_walk": 0.02},
        {"white_noise": 1.0, "markov_sigma": 0.3, "markov_time": 100.0},
    ],
    ids=["random walk", "Gauss-Markov"],
)
def test_noises_are_recognised(sizes: dict[str, float], seed: int) -> None:
    found = fit(made(sizes, 3000, 1.0, seed), 1.0)
    seen = {name for name, estimate in found.estimates.items() if estimate.lower > 0}
    assert seen == set(sizes)
    assert found.explains
    for name, size in sizes.items():
        assert 0.7 * found.estimates[name].lower < size < 1.4 * found.estimates[name].upper


def test_misfit_is_told() -> None:
    wave = 0.5 * np.sin(2 * np.pi * np.arange(3000) / 20)[:, None]
    assert not fit(made({"white_noise": 1.0}, 3000, 1.0, 5) + wave, 1.0).explains


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    runs = 100
    sizes = {"white_noise": 1.0, "random_walk": 3e-3, "markov_sigma": 0.3, "markov_time": 30.0}
    model = "white noise, random walk, Gauss-Markov"
    hits = dict.fromkeys(sizes, 0)
    explained = 0
    for seed in range(runs):
        found = fit(made(sizes, 7200, 1.0, seed), 1.0, [model])
        explained += found.explains
        for name, size in sizes.items():
            hits[name] += found.estimates[name].lower <= size <= found.estimates[name].upper
    least, most = binom.ppf([0.001, 0.999], runs, 0.95)
    assert all(least <= hit <= most for hit in hits.values()), hits
    assert explained >= binom.ppf(0.001, runs, 0.999), explained
