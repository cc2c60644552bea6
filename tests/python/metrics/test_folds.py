"""What the figures of runs make together against independent oracles: scipy, closed forms, coverage."""

from __future__ import annotations

import statistics

import numpy as np
import pytest
from scipy import stats

from sim_scenarios.metrics.folds import (
    COUNT,
    LAST,
    MEAN,
    MEDIAN,
    OF_ERRORS,
    RMS,
    SHARE,
    mean_of,
    order,
    paired_ratio,
    ratio_of_means,
    root_mean_square,
    time_share,
)

TRIALS = 2000


def binomial_range(trials: int, probability: float) -> tuple[float, float]:
    """Range of a share that a true probability leaves once in 10 000 tests."""
    low, high = stats.binom.interval(1 - 1e-4, trials, probability)
    return low / trials, high / trials


def test_the_interval_of_the_rmse_of_a_few_runs_in_closed_form() -> None:
    """Student's t with the unbiased variance: of four runs, that of all of them would be a quarter less."""
    squares = [1.0, 4.0, 9.0, 2.0]
    own = root_mean_square(np.sqrt(squares))
    influence = [square / (2 * statistics.mean(squares)) for square in squares]
    reach = stats.t.ppf(0.975, 3) * statistics.stdev(influence) / 4**0.5
    assert own.value == pytest.approx(2.0)
    assert np.log([own.lower, own.upper]) == pytest.approx([np.log(2) - reach, np.log(2) + reach])


def test_the_interval_of_a_share_of_time_of_a_few_runs_in_closed_form() -> None:
    """Clopper and Pearson for as many instants as give the unbiased variance of the ratio over runs."""
    part, share = [1.0, 2.0, 0.0, 5.0], 0.2
    own = time_share(part, [10.0] * 4)
    variance = statistics.variance([(w - share * 10.0) / 10.0 for w in part]) / 4
    few = (stats.norm.ppf(0.975) / stats.t.ppf(0.975, 3)) ** 2
    instants = few * share * (1 - share) / variance
    events = share * instants
    lower = stats.beta.ppf(0.025, events, instants - events + 1)
    upper = stats.beta.ppf(0.975, events + 1, instants - events)
    assert (own.value, own.lower, own.upper) == pytest.approx((share, lower, upper))


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


@pytest.mark.parametrize("runs", [10, 50])
def test_the_interval_of_a_share_of_time_covers_the_truth(runs: int) -> None:
    """Runs of unequal length, each with a share of its own, 4 % in the mean: instants that hang together."""
    rng = np.random.default_rng(runs)
    length = rng.uniform(100, 300, (TRIALS, runs))
    part = rng.beta(0.5, 12, (TRIALS, runs)) * length
    intervals = [time_share(w, c) for w, c in zip(part, length, strict=True)]
    covered = np.mean([i.lower <= 0.04 <= i.upper for i in intervals])
    lost = {10: 0.04, 50: 0.015}[runs]
    assert binomial_range(TRIALS, 0.95 - lost)[0] <= covered <= 1
    assert np.mean([i.upper - i.lower for i in intervals]) < 0.5 / np.sqrt(runs)


def test_a_share_of_time_that_all_runs_agree_on_is_that_of_independent_instants() -> None:
    """As many independent instants as there are give the interval of Clopper and Pearson for all of them."""
    instants = np.random.default_rng(3).random((2000, 100)) < 0.1
    own = time_share(instants.sum(axis=1), np.full(2000, 100))
    exact = stats.binomtest(int(instants.sum()), instants.size).proportion_ci(0.95, "exact")
    assert (own.lower, own.upper) == pytest.approx(tuple(exact), rel=0.01)


@pytest.mark.parametrize("wrong", [0, 1])
def test_where_no_run_differs_each_counts_as_one_instant(wrong: int) -> None:
    share = time_share(np.full(20, 30.0 * wrong), np.full(20, 30.0))
    exact = stats.binomtest(20 * wrong, 20).proportion_ci(0.95, "exact")
    assert (share.value, share.lower, share.upper) == pytest.approx((wrong, *exact))


def test_a_share_is_that_of_the_time_of_all_runs() -> None:
    assert time_share([1.0, 0.0, 0.0], [10.0, 90.0, 0.0]).value == pytest.approx(0.01)
    for nothing in (time_share([0.0], [0.0]), time_share([np.nan, np.nan], [10.0, 10.0])):  # nor a sigma
        assert np.isnan([nothing.value, nothing.lower, nothing.upper]).all()
    one = time_share([1.0], [10.0])
    assert one.value == pytest.approx(0.1)
    assert np.isnan([one.lower, one.upper]).all()


def test_every_fold_of_four_runs_in_closed_form() -> None:
    values = [1.0, 4.0, 2.0, 1.0]
    for fold, expected in ((RMS, 5.5**0.5), (MEAN, 2.0), (MEDIAN, 1.5), (COUNT, 8.0), (LAST, 4.0)):
        assert fold.estimate(values).value == pytest.approx(expected), fold.name
    assert MEDIAN.estimate([1.0, np.nan, 3.0]).value == 3.0  # what never comes is later than all
    assert MEDIAN.estimate([1.0, np.inf, np.inf]).value == np.inf
    assert SHARE.estimate([1.0, 0.0, 0.0, 1.0]).value == 0.5
    assert RMS.estimate(values) == root_mean_square(values)
    assert MEAN.estimate(values) == mean_of(values)
    assert MEAN.estimate([0.0, 0.0]).value == 0.0


def test_a_mean_of_what_may_be_negative_has_the_interval_of_student() -> None:
    values = [-1.0, 2.0, 4.0, 0.5]
    own = mean_of(values)
    exact = stats.t.interval(0.95, 3, loc=np.mean(values), scale=stats.sem(values))
    assert (own.lower, own.upper) == pytest.approx(exact)
    assert np.isnan(ratio_of_means(values, [1.0] * 4).value)


def test_a_share_has_the_interval_of_clopper_and_pearson() -> None:
    exact = stats.binomtest(3, 20).proportion_ci(0.95, "exact")
    own = SHARE.estimate([1.0] * 3 + [0.0] * 17)
    assert (own.lower, own.upper) == pytest.approx(tuple(exact))


def test_no_runs_and_what_is_no_fold_of_values_are_unknown() -> None:
    for unknown in (RMS.estimate([]), SHARE.estimate([]), OF_ERRORS.estimate([1.0])):
        assert np.isnan([unknown.value, unknown.lower, unknown.upper]).all()


def test_the_smallest_value_that_a_share_of_all_does_not_exceed() -> None:
    assert [order([4.0, 1.0, 3.0, 2.0], share) for share in (0.5, 0.75, 0.9)] == [2.0, 3.0, 4.0]
    assert np.isnan(order([1.0, np.inf], 0.9))
    assert np.isnan(order([], 0.5))
