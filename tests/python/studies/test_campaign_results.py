"""A campaign as a data set: labelled, the figures of single runs, and the same whoever computes it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import provenance
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import judge
from sim_scenarios.stepping import Master
from sim_scenarios.studies.campaign import campaign
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.quantities import KEPT, OTHERS, SERIES
from sim_scenarios.studies.runs import Bench
from sim_scenarios.studies.store import NAME, State, open_results
from sim_scenarios.units import ARCMIN

SETTINGS = {"duration": 40.0, "evaluation.start": 20.0, "evaluation.stop": 40.0}


@pytest.fixture(scope="module")
def results(results_folder: Path) -> xr.Dataset:
    return open_results(results_folder)


def files(folder: Path) -> dict[str, bytes]:
    root = folder / NAME
    return {str(p.relative_to(root)): p.read_bytes() for p in sorted(root.rglob("*")) if p.is_file()}


def test_everything_is_labelled(results: xr.Dataset) -> None:
    assert dict(results.sizes) == {"scenario": 4, "filter": 2, "run": 5, "time": 21}
    assert results["seed"].values.tolist() == [3, 4, 5, 6, 7]
    assert results["time"].values[[0, 1, -1]].tolist() == [0, 2, 40]
    assert {*map(str, results.variables)} - {*SERIES, *KEPT} <= {*OTHERS}
    for name in (*SERIES, *KEPT, "heading_bound", "heading_bound_rms"):
        assert results[name].attrs["units"], name
        assert results[name].attrs["description"], name


def test_absent_filters_stay_empty(results: xr.Dataset) -> None:
    state = results["state"].sel(filter="EKF").values
    assert (state[:2] == State.finished).all()
    assert (state[2:] == State.absent).all()
    assert np.isnan(results["heading_rmse"].sel(filter="EKF").values[2:]).all()
    assert np.isfinite(results["heading_error"].sel(filter="UKF").values).all()


def test_a_run_has_the_figures_that_it_has_alone(results: xr.Dataset, fmus: Fmus) -> None:
    alone = sim_scenarios.compare("zigzag", seed=6, set={**SETTINGS, "gnss.rate": 2.0}, fmus=fmus)
    one = results.sel(scenario="zigzag gnss.rate=2.0", filter="UKF").isel(run=3)
    run = alone.sel(filter="UKF")
    verdict = judge(run).to_json()
    assert float(one["heading_rmse"]) / ARCMIN == verdict["heading_rmse_arcmin"]
    assert float(one["nis_sum"]) / float(one["nis_channels_sum"]) == pytest.approx(
        verdict["nis_per_channel"], rel=1e-15
    )
    assert float(one["heading_bound_rms"]) / ARCMIN == pytest.approx(verdict["bound_arcmin"], rel=1e-12)
    np.testing.assert_array_equal(one["heading_error"].values, run["heading_error"].values[::20])
    east, north = run["position_error"].values[::20, 0], run["position_error"].values[::20, 1]
    np.testing.assert_allclose(one["horizontal_error"].values, np.hypot(east, north), rtol=1e-15)


def test_every_fix_counts_once(results: xr.Dataset) -> None:
    one = results.sel(scenario="zigzag gnss.rate=2.0", filter="EKF")
    np.testing.assert_array_equal(one["nis_channels"].sum("time"), 2 * one["used_fixes"])
    inside = one["nis"].sel(time=slice(22, 40)).sum("time")  # fixes after 20 s; the one at 20 s counts too
    assert (inside < one["nis_sum"]).all()
    np.testing.assert_array_equal(one["nis_channels_sum"], 2 * 41)


def test_the_python_master_stores_the_same_bytes(
    results_folder: Path, plan_file: Path, fmus: Fmus, tmp_path: Path
) -> None:
    campaign(plan_file, tmp_path, workers=1, master=Master.python, fmus=fmus)
    assert files(tmp_path) == files(results_folder)


def test_a_filter_that_fails_leaves_the_others_alone(fmus: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text('scenarios = ["waves"]\n[filters.good]\n[filters.bad]\n"robust.gamma" = -1.0\n')
    (case,) = cases(load_plan(path, set=SETTINGS), fmus)
    attributes = provenance.attributes(case.scenario, fmus)
    outcome = Bench(1.0, Master.auto, fmus).run(case, 1, attributes)
    assert outcome.state == {"good": State.finished, "bad": State.failed}
    assert "bad (AlignmentFilter) failed" in outcome.failure
    assert "robust.gamma" in outcome.failure
    assert set(outcome.kept) == {"good"}


def test_another_campaign_does_not_touch_the_results(
    results_folder: Path, plan_file: Path, fmus: Fmus
) -> None:
    with pytest.raises(InputError, match="other settings, figures or FMUs \\(5 runs from seed 3\\)"):
        campaign(plan_file, results_folder, seed=4, fmus=fmus)


def test_settings_and_versions_travel_with_the_results(results: xr.Dataset, fmus: Fmus) -> None:
    about = json.loads(results.attrs["cases"])["zigzag gnss.rate=2.0"]
    assert about["settings"] == {**SETTINGS, "gnss.rate": 2.0}
    assert json.loads(about["attributes"]["versions"])["AlignmentFilter"] == fmus.filter.guid
    assert json.loads(results.attrs["plan"])["runs"] == 5


def test_results_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no results of a campaign"):
        open_results(tmp_path)
