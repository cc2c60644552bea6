"""Metrics against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from sim_scenarios.metrics.statistics import (
    chi_square_interval,
    holds_since,
    nees,
    nis_statistics,
    rms,
)

TIME = np.arange(601.0)


def test_a_condition_holds_since_it_was_last_broken() -> None:
    assert holds_since(TIME, TIME >= 200) == 200
    assert holds_since(TIME, (TIME >= 200) & (TIME != 400)) == 401
    assert holds_since(TIME, TIME >= 0) == 0
    assert holds_since(TIME, TIME < 300) is None
    assert holds_since(TIME, TIME < 600) is None


@given(st.lists(st.booleans(), min_size=1, max_size=30))
def test_holds_since_keeps_its_word(flags: list[bool]) -> None:
    time, condition = np.arange(len(flags), dtype=float), np.array(flags)
    found = holds_since(time, condition)
    if found is None:
        assert not condition[-1]
    else:
        assert np.all(condition[time >= found])
        assert found == 0 or not condition[int(found) - 1]


@pytest.mark.parametrize("degrees", [1, 2, 60, 1200])
def test_chi_square_interval(degrees: int) -> None:
    np.testing.assert_allclose(chi_square_interval(degrees, 0.9), chi2.interval(0.9, degrees), rtol=1e-9)


def test_nis_of_a_consistent_and_of_an_overconfident_filter() -> None:
    values = np.random.default_rng(5).chisquare(2, 100_000)
    consistent = nis_statistics(values, 2)
    assert consistent.mean == pytest.approx(1, abs=0.01)
    assert consistent.lower < 1 < consistent.upper
    assert consistent.upper - consistent.lower == pytest.approx(2 * 1.96 * np.sqrt(2 / 200_000), rel=0.01)
    assert not nis_statistics(4 * values, 2).consistent
    assert not nis_statistics(values / 4, 2).consistent


def test_nis_without_fixes() -> None:
    assert nis_statistics(np.array([]), 2).count == 0


def test_nis_of_fixes_with_different_numbers_of_channels() -> None:
    channels = np.tile([6, 24, 10], 5000)
    values = np.random.default_rng(6).chisquare(channels)
    statistics = nis_statistics(values, channels)
    assert statistics.mean == pytest.approx(1, abs=0.01)
    assert statistics.count == 15_000
    assert statistics.consistent


def test_nees_of_correlated_states() -> None:
    """A thousand draws from a covariance, and the same errors under a covariance four times too small."""
    rng = np.random.default_rng(7)
    root = rng.standard_normal((6, 6))
    covariance = root @ root.T + np.eye(6)
    error = rng.multivariate_normal(np.zeros(6), covariance, 1000)
    same = np.broadcast_to(covariance, (1000, 6, 6))
    assert nees(error, same).mean() == pytest.approx(1, abs=4 * np.sqrt(2 / 6000))  # 4 sigma
    np.testing.assert_allclose(nees(error, same / 4), 4 * nees(error, same))


def test_rms_of_numbers_and_of_vectors() -> None:
    assert rms([3.0, 4.0]) == pytest.approx(np.sqrt(12.5))
    assert rms(np.array([[3.0, 4.0], [0.0, 0.0]])) == pytest.approx(np.sqrt(12.5))
