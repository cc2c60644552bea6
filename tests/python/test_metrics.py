"""Metrics against closed forms."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from sim_scenarios.metrics import (
    chi_square_interval,
    heading_rmse,
    holds_since,
    judge,
    nis_statistics,
)
from sim_scenarios.units import ARCMIN, DEGREE

TIME = np.arange(601.0)


def test_rmse_of_a_constant_and_of_a_sine() -> None:
    assert heading_rmse(TIME, np.full(601, -0.3), 300, 600) == pytest.approx(0.3)
    sine = 0.1 * np.sin(2 * np.pi * TIME / 50)
    assert heading_rmse(TIME, sine, 300, 599) == pytest.approx(0.1 / np.sqrt(2))


def test_rmse_wraps_and_ignores_what_is_outside_the_window() -> None:
    error = np.where(TIME < 300, 1.0, 2 * np.pi - 0.01)
    assert heading_rmse(TIME, error, 300, 600) == pytest.approx(0.01)


def test_rmse_needs_samples() -> None:
    with pytest.raises(ValueError, match="between 700 s and 800 s"):
        heading_rmse(TIME, TIME, 700, 800)


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


def recorded(error: np.ndarray) -> xr.Dataset:
    """A run with a given heading error, a fix each second of which the first is rejected."""
    return xr.Dataset(
        {
            "heading_error": ("time", error),
            "heading_sigma": ("time", np.full(601, 10 * ARCMIN)),
            "converged": ("time", TIME >= 100),
            "nis": ("fix", np.full(600, 2.0)),
            "innovation_sigma": (("fix", "axis3"), np.tile([0.1, 0.1, 0.0], (600, 1))),  # up is not measured
            "fix_used": ("fix", TIME[1:] > 1),
            "rejected_fixes": ("fix", np.ones(600, dtype=int)),
        },
        coords={"time": TIME, "fix_time": ("fix", TIME[1:])},
        attrs={
            "evaluation.start": 300.0,
            "evaluation.stop": 600.0,
            "evaluation.heading_limit": 0.5 * DEGREE,
            "bound.heading_rms": 5 * ARCMIN,
        },
    )


def test_verdict() -> None:
    verdict = judge(recorded(np.where(TIME < 150, 1.0, 20 * ARCMIN)))
    assert verdict.converged
    assert verdict.heading_rmse == pytest.approx(20 * ARCMIN)
    assert verdict.convergence_time == 150
    assert verdict.claimed_time == 100
    assert verdict.nis.mean == pytest.approx(1)
    assert verdict.nis.count == 301
    assert (verdict.used_fixes, verdict.rejected_fixes) == (599, 1)
    json = verdict.to_json()
    assert json["heading_rmse_arcmin"] == pytest.approx(20)
    assert json["bound_arcmin"] == pytest.approx(5)


def test_a_large_error_or_a_late_divergence_is_no_convergence() -> None:
    assert not judge(recorded(np.full(601, 31 * ARCMIN))).converged
    assert not judge(recorded(np.where(TIME < 600, 0.0, 31 * ARCMIN))).converged
    assert judge(recorded(np.full(601, 29 * ARCMIN))).converged
