"""Statistics of runs against independent oracles: scipy, closed forms and simulated coverage."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from sim_scenarios.campaigns import table
from sim_scenarios.campaigns.quantities import BOUNDED, FIGURES, SERIES
from sim_scenarios.campaigns.statistics import (
    consistency_course,
    error_course,
    mean_of,
    nees_course,
    paired_ratio,
    ratio_of_means,
    root_mean_square,
    summarise,
)
from sim_scenarios.campaigns.store import State

TRIALS = 2000


def binomial_range(trials: int, probability: float) -> tuple[float, float]:
    """Range of a share that a true probability leaves once in 10 000 tests."""
    low, high = stats.binom.interval(1 - 1e-4, trials, probability)
    return low / trials, high / trials


@pytest.mark.parametrize("runs", [20, 100])
def test_the_interval_of_the_rmse_covers_the_truth(runs: int) -> None:
    """Run figures as those of an unobservable bias: |N(0, 1)|, whose root mean square is 1.

    An approximate interval: allowed are 1.5 points of lost coverage at 100 runs, 4 at 20.
    """
    draws = np.abs(np.random.default_rng(runs).standard_normal((TRIALS, runs)))
    intervals = [root_mean_square(r) for r in draws]
    covered = np.mean([i.lower <= 1 <= i.upper for i in intervals])
    lost = {20: 0.04, 100: 0.015}[runs]
    assert binomial_range(TRIALS, 0.95 - lost)[0] <= covered <= binomial_range(TRIALS, 0.95)[1]


@pytest.mark.parametrize("runs", [10, 20, 100])
def test_the_interval_of_a_mean_covers_the_truth(runs: int) -> None:
    """RMSE of runs scatter about their mean as the length of a Gaussian vector of six components does."""
    rng = np.random.default_rng(1000 + runs)
    draws = np.linalg.norm(rng.standard_normal((TRIALS, runs, 6)), axis=2)
    truth = float(stats.chi(6).mean())
    intervals = [mean_of(r) for r in draws]
    covered = np.mean([i.lower <= truth <= i.upper for i in intervals])
    assert binomial_range(TRIALS, 0.945)[0] <= covered <= binomial_range(TRIALS, 0.955)[1]
    assert intervals[0].value == pytest.approx(np.mean(draws[0]))


def test_the_interval_of_a_ratio_of_means_covers_the_truth() -> None:
    """Two filters that share half of their squared error."""
    rng = np.random.default_rng(6)
    common, own = rng.standard_normal((2, TRIALS, 20, 6))
    a, b = np.linalg.norm(common + own, axis=2), np.linalg.norm(common, axis=2)
    ratios = [ratio_of_means(x, y) for x, y in zip(a, b, strict=True)]
    covered = np.mean([r.lower <= np.sqrt(2) <= r.upper for r in ratios])
    assert binomial_range(TRIALS, 0.94)[0] <= covered <= binomial_range(TRIALS, 0.955)[1]
    alike = ratio_of_means(3.0 * b[0], b[0])
    assert (alike.lower, alike.value, alike.upper) == pytest.approx((3.0, 3.0, 3.0))


def test_a_single_run_and_runs_without_error_have_no_interval() -> None:
    assert mean_of([2.0]).value == 2.0
    for nothing in (mean_of([2.0]), ratio_of_means([2.0], [1.0])):
        assert np.isnan(nothing.lower)
        assert np.isnan(nothing.upper)
    assert np.isnan(mean_of([0.0, 0.0]).value)
    assert np.isnan(ratio_of_means([1.0, 2.0], [0.0, 0.0]).value)


def test_the_interval_of_a_paired_ratio_covers_the_truth() -> None:
    """Two filters that share most of their error: the ratio of their root mean squares is known."""
    rng = np.random.default_rng(5)
    common, own = rng.standard_normal((2, TRIALS, 100))
    a, b = np.abs(common + 0.2 * own), np.abs(common)
    truth = np.sqrt(1 + 0.2**2)
    ratios = [paired_ratio(x, y) for x, y in zip(a, b, strict=True)]
    covered = np.mean([r.lower <= truth <= r.upper for r in ratios])
    assert binomial_range(TRIALS, 0.935)[0] <= covered <= binomial_range(TRIALS, 0.95)[1]
    alone = [root_mean_square(x) for x in a]
    assert np.mean([r.upper / r.lower for r in ratios]) < 1 + 0.5 * np.mean(
        [i.upper / i.lower - 1 for i in alone]
    )


def test_intervals_agree_with_a_bootstrap() -> None:
    rng = np.random.default_rng(11)
    common = rng.standard_normal(200)
    a, b = np.abs(1.3 * common + 0.3 * rng.standard_normal(200)), np.abs(common)

    def rms(x: np.ndarray, axis: int) -> np.ndarray:
        return np.sqrt(np.mean(x**2, axis=axis))

    resampled = stats.bootstrap((a,), rms, rng=rng, n_resamples=5000).confidence_interval
    own = root_mean_square(a)
    assert own.value == pytest.approx(np.sqrt(np.mean(a**2)))
    assert (own.lower, own.upper) == pytest.approx(resampled, rel=0.03)
    resampled = stats.bootstrap(
        (a, b), lambda x, y, axis: rms(x, axis) / rms(y, axis), paired=True, rng=rng, n_resamples=5000
    ).confidence_interval
    own = paired_ratio(a, b)
    assert (own.lower, own.upper) == pytest.approx(resampled, rel=0.02)


def test_filters_that_agree_have_a_ratio_without_doubt() -> None:
    r = np.random.default_rng(1).random(10)
    ratio = paired_ratio(2 * r, r)
    assert (ratio.value, ratio.lower, ratio.upper) == pytest.approx((2, 2, 2))


def test_one_run_has_no_interval() -> None:
    one = root_mean_square([3.0])
    assert one.value == 3
    assert np.isnan([one.lower, one.upper]).all()
    assert np.isnan(root_mean_square([]).value)


def test_percentiles_are_those_of_the_size_of_the_error() -> None:
    error = np.array([[-4.0, 1.0], [2.0, 1.0], [0.0, -1.0]])
    course = error_course(error)
    assert course.middle == pytest.approx([np.sqrt(20 / 3), 1])
    assert course.lower == pytest.approx([2, 1])
    assert course.upper == pytest.approx([np.percentile([4, 2, 0], 90), 1])


def test_a_consistent_filter_stays_in_its_interval() -> None:
    """Mean NEES of 40 runs of true sigma lies in its 95 % interval at 95 % of independent times."""
    rng = np.random.default_rng(2)
    sigma = np.full((40, TRIALS), 0.3)
    course = nees_course(sigma * rng.standard_normal(sigma.shape), sigma)
    inside = np.mean((course.lower <= course.middle) & (course.middle <= course.upper))
    assert binomial_range(TRIALS, 0.95)[0] <= inside <= binomial_range(TRIALS, 0.95)[1]
    assert (course.lower[0], course.upper[0]) == pytest.approx(np.array(stats.chi2.interval(0.95, 40)) / 40)


def test_times_without_a_fix_have_no_nis() -> None:
    course = consistency_course(np.array([[3.0, 0.0], [1.0, 0.0]]), np.array([[2.0, 0.0], [2.0, 0.0]]))
    assert course.middle[0] == 1
    assert np.isnan([course.middle[1], course.lower[1], course.upper[1]]).all()


@pytest.fixture
def results() -> xr.Dataset:
    """One case with filters a and b in four runs, the last of which failed for b."""
    runs = ("scenario", "filter", "run")
    data = xr.Dataset(
        {
            **{name: ((*runs, "time"), np.ones((1, 2, 4, 3))) for name in SERIES},
            **{name: (runs, np.ones((1, 2, 4))) for name in FIGURES},
            "state": (runs, np.full((1, 2, 4), State.finished, np.int8)),
            **{f"{name}_bound": (("scenario", "time"), np.ones((1, 3))) for name in BOUNDED},
            "heading_bound_rms": ("scenario", [0.5]),
            "horizontal_bound_rms": ("scenario", [2.0]),
        },
        coords={"scenario": ["case"], "filter": ["a", "b"], "time": [0.0, 1.0, 2.0]},
        attrs={
            "plan": '{"reference": null}',
            "cases": json.dumps(
                {"case": {"attributes": {"evaluation.stop": 1.0, "filter_fmu": "AlignmentFilter"}}}
            ),
        },
    )
    data["state"][0, 1, 3] = State.failed
    data["hand_over_time"][:] = np.nan
    data["heading_rmse"][0] = [[1, 1, 1, 7], [3, 3, 3, np.nan]]
    data["convergence_time"][0] = [[30, 10, np.nan, 20], [np.nan, np.nan, 5, np.nan]]
    data["claimed_deviation"][0] = [[0.5, 3.1, np.nan, 2.9], [np.nan] * 4]
    data["success"][0] = [[1, 1, 0, 1], [1, 1, 1, np.nan]]
    data["heading_sigma"][0, 0, :, 1] = 0.5
    return data


def test_a_summary_counts_what_became_of_the_runs(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    a, b = case.filters["a"], case.filters["b"]
    assert (a.runs, a.stopped, a.failures.value) == (4, 0, 0.25)
    assert (b.runs, b.stopped, b.failures.value) == (4, 1, 0.25)
    for share, events, count in ((a.failures, 1, 4), (a.wrong_claims, 1, 3)):
        exact = stats.binomtest(events, count).proportion_ci(0.95, "exact")
        assert (share.lower, share.upper) == pytest.approx(tuple(exact))
    assert a.rmse["heading"].value == pytest.approx(np.sqrt(13))
    assert a.to_bound.value == pytest.approx(np.sqrt(13) / 0.5)
    assert a.convergence == pytest.approx((20, np.nan), nan_ok=True)
    assert b.convergence == pytest.approx((np.nan, np.nan), nan_ok=True)
    assert (a.claims, a.wrong_claims.value) == (3, pytest.approx(1 / 3))
    assert b.claims == 0
    assert np.isnan(b.wrong_claims.value)
    assert a.nees.value == pytest.approx(4)  # at the end of the window, not of the run
    assert a.nees.upper == pytest.approx(stats.chi2.ppf(0.975, 4) / 4)


@pytest.mark.parametrize("success", [0, 1])
def test_no_failure_and_nothing_else_have_an_interval_too(results: xr.Dataset, success: int) -> None:
    results["success"][0] = success
    (case,) = summarise(results)
    failures = case.filters["a"].failures
    exact = stats.binomtest(4 * (1 - success), 4).proportion_ci(0.95, "exact")
    assert (failures.lower, failures.upper) == pytest.approx(tuple(exact))


def test_a_run_that_stopped_is_later_than_all_others(results: xr.Dataset) -> None:
    results["convergence_time"][0, 1] = [10, 20, 30, np.nan]
    (case,) = summarise(results)
    median, late = case.filters["b"].convergence
    assert median == 20
    assert np.isnan(late)


def test_the_nees_is_that_of_the_runs_that_have_a_sigma() -> None:
    error, sigma = np.array([[1.0, 2.0], [1.0, 2.0]]), np.array([[1.0, 1.0], [np.nan, 2.0]])
    course = nees_course(error, sigma)
    assert course.middle == pytest.approx([1.0, 2.5])
    assert course.upper[0] == pytest.approx(stats.chi2.ppf(0.975, 1))


def test_filters_are_compared_on_the_seeds_that_both_finished(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    assert case.reference == "a"
    assert case.filters["b"].ratio.value == pytest.approx(3)
    results.attrs["plan"] = '{"reference": "b"}'
    (case,) = summarise(results)
    assert case.filters["a"].ratio.value == pytest.approx(1 / 3)


def test_navigation_is_judged_by_the_horizontal_position(results: xr.Dataset) -> None:
    results.attrs["cases"] = results.attrs["cases"].replace("AlignmentFilter", "NavigationFilter")
    results["horizontal_rmse"][0] = [[6, 6, 6, 6], [3, 3, 3, np.nan]]
    (case,) = summarise(results)
    assert case.counting == "horizontal"
    assert case.filters["a"].to_bound.value == pytest.approx(3)
    assert case.filters["b"].ratio.value == pytest.approx(0.5)
    assert table.by_scenario([case])[0][1] == "case: horizontal [m]"
    assert table.figures(case)[1][1] == "6.00"


def test_the_longer_of_filters_and_scenarios_goes_down(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    few, many = table.by_scenario([case]), table.by_scenario([case] * 3)
    assert [row[0] for row in few[1:]] == ["a", "b", "Cramer-Rao bound"]
    assert many[0][1:] == ["a", "b", "Cramer-Rao bound"]
    assert many[1:] == [[row[1] for row in few]] * 3


def test_the_hand_over_is_told_where_there_is_one(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    assert "handed\nover [s]" not in table.figures(case)[0]
    results["hand_over_time"][0] = [[227, 226, 228, 227], [231, 230, 229, np.nan]]
    (case,) = summarise(results)
    assert [row[-1] for row in table.figures(case)] == ["handed\nover [s]", "226 to 228", "229 to 231"]
    assert table.for_machines(case)["filters"]["a"]["hand_over"] == [226, 228]


def test_a_filter_that_a_case_lacks_has_no_summary(results: xr.Dataset) -> None:
    results["state"][0, 1] = State.absent
    (case,) = summarise(results)
    assert list(case.filters) == ["a"]


def test_a_case_without_runs_is_empty(results: xr.Dataset) -> None:
    results["state"][0] = State.missing
    (case,) = summarise(results)
    assert case.filters == {}
