"""The smoother against the least squares of everything at once, which knows nothing of filters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
import scipy.linalg

from sim_scenarios.rauch_tung_striebel import Forward, smooth

STATES, INSTANTS = 3, 40


class System(NamedTuple):
    """x_k+1 = F_k x_k + noise of covariance Q; at some instants z_k = H x_k + noise of sigma r."""

    transition: np.ndarray
    noise: np.ndarray
    H: np.ndarray
    sigma: float
    measurement: np.ndarray  # NaN: none
    prior: np.ndarray


@pytest.fixture(scope="module")
def system() -> System:
    """An outage in the middle, states of units that differ by orders."""
    random = np.random.default_rng(3)
    size = np.array([1e3, 1.0, 1e-3])
    turn = np.array([scipy.linalg.expm(0.2 * random.normal(size=(3, 3))) for _ in range(INSTANTS - 1)])
    root = 0.1 * random.normal(size=(3, 3))
    measurement = 1e3 * random.normal(size=INSTANTS)
    measurement[15:25] = np.nan
    return System(
        transition=size[:, None] * turn / size,
        noise=size[:, None] * (root @ root.T) * size,
        H=np.array([1.0, 200.0, 0.0]),
        sigma=100.0,
        measurement=measurement,
        prior=np.diag((3 * size) ** 2),
    )


def filtered(system: System) -> tuple[Forward, np.ndarray]:
    """What a Kalman filter does, and its estimate after each measurement."""
    x, P = np.zeros(STATES), system.prior
    predicted, covariance, correction, estimate = [], [], [], []
    for k, z in enumerate(system.measurement):
        if k:
            F = system.transition[k - 1]
            x, P = F @ x, F @ P @ F.T + system.noise
        predicted.append(P)
        change = np.zeros(STATES)
        if np.isfinite(z):
            gain = P @ system.H / (system.H @ P @ system.H + system.sigma**2)
            change = gain * (z - system.H @ x)
            x, P = x + change, P - np.outer(gain, system.H @ P)
        covariance.append(P)
        correction.append(change)
        estimate.append(x)
    forward = Forward(system.transition, np.array(predicted), np.array(covariance), np.array(correction))
    return forward, np.array(estimate)


def all_at_once(system: System, until: int = INSTANTS) -> tuple[np.ndarray, np.ndarray]:
    """Every state up to an instant, and its covariance, by least squares of all equations together."""

    def at(k: int, block: np.ndarray) -> np.ndarray:
        row = np.zeros((len(block), until * STATES))
        row[:, k * STATES : (k + 1) * STATES] = block
        return row

    whiten = np.linalg.inv(np.linalg.cholesky(system.noise))
    rows, right = [at(0, np.diag(1 / np.sqrt(system.prior.diagonal())))], [np.zeros(STATES)]
    for k in range(until):
        if k:
            rows.append(at(k, whiten) - at(k - 1, whiten @ system.transition[k - 1]))
            right.append(np.zeros(STATES))
        if np.isfinite(system.measurement[k]):
            rows.append(at(k, system.H[None] / system.sigma))
            right.append(system.measurement[[k]] / system.sigma)
    A, b = np.vstack(rows), np.concatenate(right)
    size = np.linalg.norm(A, axis=0)
    solution, _, rank, _ = scipy.linalg.lstsq(A / size, b)
    assert rank == A.shape[1]
    triangle = np.linalg.inv(np.linalg.qr(A / size, mode="r"))
    covariance = triangle @ triangle.T / np.outer(size, size)
    blocks = covariance.reshape(until, STATES, until, STATES)[np.arange(until), :, np.arange(until)]
    return (solution / size).reshape(until, STATES), blocks


def test_it_is_the_least_squares_of_everything(system: System) -> None:
    forward, estimate = filtered(system)
    deviation, covariance = smooth(forward)
    best, spread = all_at_once(system)
    size = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    np.testing.assert_allclose((estimate + deviation - best) / size, 0, atol=1e-9)
    in_sigmas = (covariance - spread) / (size[:, :, None] * size[:, None])
    np.testing.assert_allclose(in_sigmas, 0, atol=1e-9)
    assert np.abs(deviation[20] / size[20]).max() > 1  # it is something else than the filter


def test_the_end_is_the_filter(system: System) -> None:
    forward, _ = filtered(system)
    deviation, covariance = smooth(forward)
    assert not deviation[-1].any()
    np.testing.assert_array_equal(covariance[-1], forward.filtered[-1])


def test_nothing_comes_over_what_is_severed(system: System) -> None:
    """What precedes is smoothed as if the record ended there, what follows as without."""
    forward, estimate = filtered(system)
    severed = np.zeros(INSTANTS - 1, dtype=bool)
    severed[29] = True
    deviation, covariance = smooth(forward, severed)
    best, spread = all_at_once(system, 30)
    size = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
    np.testing.assert_allclose((estimate + deviation)[:30] / size, best / size, atol=1e-9)
    np.testing.assert_allclose(
        covariance[:30] / size[..., None] ** 2, spread / size[..., None] ** 2, atol=1e-9
    )
    np.testing.assert_array_equal(deviation[30:], smooth(forward)[0][30:])
