"""The regret of a filter, against what can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.studies import regret
from sim_scenarios.studies.store import State

RUNS = ("scenario", "filter", "run")


@pytest.fixture
def results() -> xr.Dataset:
    """Two cases with filters a and b in four runs; b has not been run in the second."""
    shape = (2, 2, 4)
    data = xr.Dataset(
        {
            "heading_rmse": (RUNS, np.ones(shape)),
            "horizontal_rmse": (RUNS, np.full(shape, np.nan)),
            "state": (RUNS, np.full(shape, State.finished, np.int8)),
        },
        coords={"scenario": ["one", "other"], "filter": ["a", "b"]},
    )
    data["heading_rmse"][0, 0] = [3.0, 3.0, 1.0, 1.0]
    data["heading_rmse"][0, 1] = [1.0, 1.0, 1.0, 1.0]
    data["state"][1, 1] = State.missing
    return data


def test_regret_is_the_ratio_to_the_best(results: xr.Dataset) -> None:
    found = regret.regrets(results, "heading")
    assert found["one"]["a"].value == pytest.approx(np.sqrt(5.0))
    assert found["one"]["a"].lower < np.sqrt(5.0) < found["one"]["a"].upper
    assert found["one"]["b"].value == 1.0
    assert found["other"]["a"].value == 1.0
    assert "b" not in found["other"]


def test_runs_that_one_has_not_finished_do_not_count(results: xr.Dataset) -> None:
    results["state"][0, 1, :2] = State.failed
    results["heading_rmse"][0, 1, :2] = np.nan
    results["heading_rmse"][0, 1, 2:] = 0.5
    assert regret.regrets(results, "heading")["one"]["a"].value == 2.0


def test_a_figure_of_a_run_that_failed_does_not_count(results: xr.Dataset) -> None:
    results["state"][0, 0, :2] = State.failed  # of which a has finished two with 1, as b has
    assert [one.value for one in regret.regrets(results, "heading")["one"].values()] == [1.0, 1.0]


@pytest.mark.parametrize(
    ("each", "failed", "regrets"),
    [
        ([0.0, 0.0, 0.0, 2.2], 0, [1.0, 1.1]),  # a smaller mean, but a larger RMSE
        ([1.2, 1.2, 1.2, 1.2], 2, [1.0, 1.2]),  # two that count for nothing are no small errors
        ([0.5, 0.5, 0.5, 0.5], 0, [2.0, 1.0]),
    ],
)
def test_the_best_has_the_smallest_rmse_of_the_runs_that_it_finished(
    results: xr.Dataset, each: list[float], failed: int, regrets: list[float]
) -> None:
    results["heading_rmse"][0] = [[1.0] * 4, each]
    results["heading_rmse"][0, 1, :failed] = np.nan
    results["state"][0, 1, :failed] = State.failed
    found = regret.regrets(results, "heading")["one"]
    assert [one.value for one in found.values()] == pytest.approx(regrets)


def test_the_table_has_cases_of_several_filters_and_the_largest(results: xr.Dataset) -> None:
    ((title, rows),) = regret.tables(results).items()
    assert title == "Regret: heading RMSE by that of the best filter of the case"
    assert rows[0] == ["filter", "one", "largest"]
    assert [row[0] for row in rows[1:]] == ["a", "b"]
    assert rows[1][-1] == "2.24"
    assert rows[2][-1] == "1.00"


def test_a_line_has_every_case_and_the_largest_of_all(results: xr.Dataset) -> None:
    """Of filters that one case or the other has; a case that lacks the filter has an empty place."""
    results["state"][1, 1] = State.finished
    results["heading_rmse"][1, 1] = 4.0
    together = xr.concat([results, results.isel(filter=[0]).assign_coords(filter=["c"])], "filter")
    together["state"][0, 2] = State.missing
    together["heading_rmse"][1, 2] = 2.0
    ((_, rows),) = regret.tables(together).items()
    assert rows[0] == ["filter", "one", "other", "largest"]
    assert [(row[0], row[-1]) for row in rows[1:]] == [("a", "2.24"), ("b", "4.00"), ("c", "2.00")]
    assert [bool(place) for place in rows[3]] == [True, False, True, True]


def test_positions_have_a_table_of_their_own_before_the_headings(results: xr.Dataset) -> None:
    results["horizontal_rmse"][:] = 1.0
    titles = list(regret.tables(results))
    assert [title.partition(" RMSE")[0] for title in titles] == [
        "Regret: horizontal position",
        "Regret: heading",
    ]


def test_a_campaign_of_one_filter_has_no_table(results: xr.Dataset) -> None:
    assert regret.tables(results.isel(filter=[0])) == {}
