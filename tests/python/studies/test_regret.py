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


def test_the_table_has_cases_of_several_filters_and_the_largest(results: xr.Dataset) -> None:
    ((title, rows),) = regret.tables(results).items()
    assert "heading" in title
    assert rows[0] == ["filter", "one", "largest"]
    assert [row[0] for row in rows[1:]] == ["a", "b"]
    assert rows[1][-1] == "2.24"
    assert rows[2][-1] == "1.00"


def test_a_campaign_of_one_filter_has_no_table(results: xr.Dataset) -> None:
    assert regret.tables(results.isel(filter=[0])) == {}
