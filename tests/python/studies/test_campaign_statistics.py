"""Statistics of runs against independent oracles: scipy and closed forms."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from sim_scenarios.studies import table
from sim_scenarios.studies.plan import Plan
from sim_scenarios.studies.statistics import (
    consistency_course,
    error_course,
    nees_course,
    recovery_times,
    summarise,
)
from sim_scenarios.studies.store import State
from sim_scenarios.units import ARCMIN

TRIALS = 2000


def binomial_range(trials: int, probability: float) -> tuple[float, float]:
    """Range of a share that a true probability leaves once in 10 000 tests."""
    low, high = stats.binom.interval(1 - 1e-4, trials, probability)
    return low / trials, high / trials


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


RECOVERY_TIME = np.arange(0.0, 101.0)


def without_fault(runs: int = 1) -> dict[str, np.ndarray]:
    """Errors of one sigma; of the position the filter has none."""
    shape = runs, len(RECOVERY_TIME)
    good = {"heading": (1.0, 0.1), "velocity": (1.0, 0.2), "position": (np.nan, np.nan)}
    return {
        f"{name}_{what}": np.full(shape, value)
        for name, values in good.items()
        for what, value in zip(("deviation", "sigma"), values, strict=True)
    }


def recovered_after(fault_end: float, **faulted: np.ndarray) -> float:
    return float(
        recovery_times(RECOVERY_TIME, np.array([fault_end]), without_fault() | faulted, without_fault())[0]
    )


def course(value: float, other: float, begin: float, end: float) -> np.ndarray:
    inside = (begin <= RECOVERY_TIME) & (end > RECOVERY_TIME)
    return np.where(inside, other, value)[None, :]


def test_a_filter_has_recovered_when_error_and_sigma_are_as_they_would_be() -> None:
    assert recovered_after(30.0) == 0
    assert recovered_after(30.0, heading_deviation=course(1.0, 3.1, 20, 47)) == 17
    assert recovered_after(0.0, heading_deviation=course(1.0, 3.1, 0, 1)) == 1  # wrong at the first instant
    assert recovered_after(30.5, velocity_deviation=course(3.0, 3.1, 20, 47)) == 16.5
    assert recovered_after(30.0, velocity_sigma=course(0.3, 0.31, 20, 60)) == 30
    assert recovered_after(30.0, heading_deviation=course(1.0, np.nan, 31, 40)) == 10
    assert recovered_after(30.0, heading_deviation=course(1.0, 9.0, 10, 30)) == 0  # not after its end
    both = {"heading_deviation": course(1, 9, 20, 40), "heading_sigma": course(0.1, 1, 30, 55)}
    assert recovered_after(30.0, **both) == 25
    assert recovered_after(30.0, heading_deviation=course(1.0, 9.0, 80, 81)) == 51  # it has to last


def test_what_is_still_wrong_at_the_end_has_not_recovered() -> None:
    assert recovered_after(30.0, heading_sigma=course(0.1, 0.2, 30, 200)) == np.inf
    assert np.isnan(recovered_after(np.nan))
    assert np.isnan(recovered_after(101.0))


def test_what_the_noise_does_without_the_fault_too_is_no_want_of_recovery() -> None:
    noisy = without_fault()
    noisy["heading_deviation"] = course(1.0, 3.2, 70, 75)
    for size, expected in ((4.7, 0.0), (4.9, 45.0)):
        faulted = noisy | {"heading_deviation": course(1.0, size, 70, 75)}
        assert recovery_times(RECOVERY_TIME, np.array([30.0]), faulted, noisy) == [expected]


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


def test_the_table_has_the_figures_of_each_filter_in_a_line(results: xr.Dataset) -> None:
    """Worked out by hand: the interval is that of the squares 1, 1, 1 and 49 with Student's t of 3.1824."""
    results["heading_rmse"][:] *= ARCMIN
    results["heading_bound_rms"][:] *= ARCMIN
    results["nis_sum"][0, 1] = [2.0, 1.0, 3.0, np.nan]
    results["nis_channels_sum"][0, 1] = [4.0, 3.0, 5.0, np.nan]
    (case,) = summarise(results)
    _, a, b = table.figures(case)
    assert a == ["a", "3.61", "0.83 to 15.66", "7.21", "1", "1 / 4", "20.0", "1 / 3", "1.00", "4.00 *"]
    against_a = "3.00 (3.00 to 3.00)"
    assert b == ["b", "3.00", "3.00 to 3.00", "6.00", against_a, "1 / 4", "never", "-", "0.500", "1.00"]


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


def test_an_error_that_is_no_number_counts_against_the_filter(results: xr.Dataset) -> None:
    """Neither its claims nor its NEES are left out; a time that the run does not reach is."""
    error = np.array([[0.0, 1.0, np.nan], [0.0, np.nan, np.nan]])
    sigma = np.array([[1.0, 1.0, np.nan], [1.0, 1.0, np.nan]])
    np.testing.assert_array_equal(nees_course(error, sigma).middle, [0.0, np.inf, np.nan])
    assert table.number(np.inf) == "inf"
    changed = results.copy(deep=True)
    changed["claimed_deviation"].values[:] = [1.0, *[np.inf] * (results.sizes["run"] - 1)]
    for case in summarise(changed):
        for one in case.filters.values():
            finished = one.runs - one.stopped
            assert one.claims == finished
            assert one.wrong_claims.value == pytest.approx((finished - 1) / finished)


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


def test_wrongly_sure_is_the_share_of_the_time_of_all_runs(results: xr.Dataset) -> None:
    results["sure_time"][0] = [[10, 20, 0, 70], [50, 50, 50, np.nan]]
    results["wrongly_sure_time"][0] = [[1, 0, 0, 4], [0, 0, 0, np.nan]]
    results["wrongly_sure_heading_time"][0] = [[1, 0, 0, 0], [0, 0, 0, np.nan]]
    results["wrongly_sure_velocity_time"][0] = [[0, 0, 0, 4], [0, 0, 0, np.nan]]
    results["wrongly_sure_position_time"][0] = np.nan
    results["longest_wrongly_sure"][0] = [[1, 0, 0, 2.5], [0, 0, 0, np.nan]]
    (case,) = summarise(results)
    a, b = case.filters["a"], case.filters["b"]
    assert (a.sure, a.wrongly_sure.value, a.longest_wrongly_sure) == (25, pytest.approx(0.05), 2.5)
    assert a.wrongly_sure.lower < 0.05 < a.wrongly_sure.upper
    assert a.wrongly_sure_in["heading"].value == pytest.approx(0.01)
    assert a.wrongly_sure_in["velocity"].value == pytest.approx(0.04)
    assert (b.wrongly_sure.value, b.longest_wrongly_sure) == (0, 0)
    assert b.wrongly_sure.upper == pytest.approx(1 - 0.025 ** (1 / 3))
    heading, first, second = table.certainty(case)
    assert heading == [
        "filter",
        "sure\n[s a run]",
        "wrongly\nsure [%]",
        "by\nheading [%]",
        "by\nvelocity [%]",
        "longest\n[s]",
    ]
    assert first[1] == "25.0"
    assert first[2].startswith("5.00 (")
    assert second[2] == "0.00 (0.00 to 70.76)"
    assert table.for_machines(case)["filters"]["a"]["wrongly_sure"][0] == pytest.approx(0.05)
    assert table.wrongly_sure([case])[1][1].endswith(", longest 2.50 s")
    assert table.recoveries([case]) == []


def test_a_fault_is_recovered_from_against_the_case_without(results: xr.Dataset) -> None:
    clean, faulted = results.copy(deep=True), results.copy(deep=True)
    for data in (clean, faulted):
        data["state"][0, 1] = [State.finished, State.finished, State.finished, State.failed]
    faulted["heading_deviation"][0, 0, 0] = [1, 9, 1]  # recovers at 2 s
    faulted["heading_deviation"][0, 0, 1] = [1, 1, 9]  # never
    faulted["fault_end"][0] = [0.5, 0.5, np.nan, 0.5]  # that of the third run does not end
    faulted["state"][0, 0, 3] = State.failed
    clean["state"][0, 0, 3] = State.finished
    both = xr.concat([clean, faulted], "scenario").assign_coords(scenario=["clean", "faulted"])
    (about,) = json.loads(results.attrs["cases"]).values()
    both.attrs["cases"] = json.dumps({"clean": about, "faulted": {**about, "unfaulted": "clean"}})
    without, case = summarise(both)
    assert np.isnan(without.filters["a"].recovered.value)
    a, b = case.filters["a"], case.filters["b"]
    exact = stats.binomtest(1, 3).proportion_ci(0.95, "exact")
    assert (a.recovered.value, a.recovered.lower, a.recovered.upper) == pytest.approx((1 / 3, *exact))
    assert a.recovery == pytest.approx((np.nan, np.nan), nan_ok=True)
    assert b.recovered.value == 1  # of two: what stops without the fault as well tells nothing
    assert b.recovery == (0, 0)
    assert table.certainty(case)[0][-2:] == ["recovered\n[%]", "median time to\nrecover [s]"]
    assert table.certainty(case)[1][-1] == "never"
    assert table.recoveries([without, case])[0] == ["median time to recover [s]", "faulted"]
    assert table.recoveries([without, case])[2][1].startswith("0.00 (100 %")
    assert table.for_machines(case)["filters"]["a"]["recovery_median"] is None


def test_the_nees_is_told_at_the_instants_that_the_campaign_names(results: xr.Dataset) -> None:
    results.attrs["plan"] = '{"reference": null, "instants": [0.0, 2.0]}'
    results["heading_sigma"][0, 0, :, 2] = 0.1
    (case,) = summarise(results)
    found = case.filters["a"].nees_at
    assert [found[instant].value for instant in (0.0, 2.0)] == pytest.approx([1, 100])
    assert found[2.0].upper == pytest.approx(stats.chi2.ppf(0.975, 4) / 4)
    assert table.certainty(case)[0][-2:] == ["NEES at\n0 s", "NEES at\n2 s"]
    assert table.certainty(case)[1][-1] == "100 *"
    assert [table.span(time) for time in (3600, 21600, 5400)] == ["1 h", "6 h", "5400 s"]


def test_an_instant_that_no_run_reaches_has_no_nees(results: xr.Dataset) -> None:
    """After the end of a case that is shorter than others, after all of them, and between two rows."""
    (about,) = json.loads(results.attrs["cases"]).values()
    about["attributes"]["duration"] = 1.0
    results.attrs["cases"] = json.dumps({"case": about})
    results.attrs["plan"] = '{"reference": null, "instants": [0.5, 1.0, 2.0, 3600.0]}'
    (case,) = summarise(results)
    found = {instant: one.value for instant, one in case.filters["a"].nees_at.items()}
    assert found == pytest.approx({0.5: np.nan, 1.0: 4.0, 2.0: np.nan, 3600.0: np.nan}, nan_ok=True)
    assert table.certainty(case)[1][-1] == "-"


def test_reference_and_instants_are_those_of_the_plan_at_hand(results: xr.Dataset) -> None:
    """They may change from one call to the next, and are in no fingerprint."""
    plan = Plan(name="x", scenarios=("case",), reference="b", instants=(1.0,))
    (case,) = summarise(results, plan)
    assert case.reference == "b"
    assert case.filters["b"].ratio.value == 1
    assert list(case.filters["a"].nees_at) == [1.0]


def test_the_longer_of_filters_and_scenarios_goes_down(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    few, many = table.by_scenario([case]), table.by_scenario([case] * 3)
    assert [row[0] for row in few[1:]] == ["a", "b", "bound"]
    assert many[0][1:] == ["a", "b", "bound"]
    assert many[1:] == [[row[1] for row in few]] * 3


def test_the_hand_over_is_told_where_there_is_one(results: xr.Dataset) -> None:
    (case,) = summarise(results)
    assert "handed\nover [s]" not in table.figures(case)[0]
    results["hand_over_time"][0] = [[227, 226, 228, 227], [231, 230, 229, np.nan]]
    (case,) = summarise(results)
    assert [row[-1] for row in table.figures(case)] == ["handed\nover [s]", "226 to 228", "229 to 231"]
    assert table.for_machines(case)["filters"]["a"]["hand_over"] == [226, 228]


def test_a_figure_of_another_package_is_folded_as_it_says(
    results: xr.Dataset, register: Callable[[dict[str, str]], None]
) -> None:
    register({"peak": "own_figures:heading_peak"})
    results["peak"] = results["heading_rmse"].copy(data=[[[1, 5, 3, 2], [4, 2, 3, np.nan]]]) * ARCMIN
    (case,) = summarise(results)
    assert [one.own["peak"].value / ARCMIN for one in case.filters.values()] == pytest.approx([5, 4])
    assert table.own_figures(case) == [
        ["filter", "largest size of the heading [']\nlast"],
        ["a", "5.00"],
        ["b", "4.00"],
    ]
    assert table.for_machines(case)["filters"]["a"]["peak"] == [pytest.approx(5 * ARCMIN), None, None]
    (older,) = summarise(results.drop_vars("peak"))
    assert table.own_figures(older) == []


def test_a_filter_that_a_case_lacks_has_no_summary(results: xr.Dataset) -> None:
    results["state"][0, 1] = State.absent
    (case,) = summarise(results)
    assert list(case.filters) == ["a"]


def test_a_case_without_runs_is_empty(results: xr.Dataset) -> None:
    results["state"][0] = State.missing
    (case,) = summarise(results)
    assert case.filters == {}
