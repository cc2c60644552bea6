"""When an alignment handed over, and what is said when it did not, on made-up runs."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from statuses import FLAGS
from test_navigation import TIME, WINDOW, consistent

from sim_scenarios.metrics import hand_over, judge
from sim_scenarios.metrics.figures import FIGURES
from sim_scenarios.studies.ensemble import gathered, thinned
from sim_scenarios.units import ARCMIN


def handed_over(converged_at: float, start: float) -> xr.Dataset:
    """A run that navigates from `start` on; the alignment's heading error falls by 0.1 arcmin a second."""
    run = consistent()
    run["hand_over_time"] = start
    run["alignment.heading_error"] = ("time", (200 - 0.1 * TIME) * ARCMIN)
    run["alignment.heading_sigma"] = ("time", (300 - 0.2 * TIME) * ARCMIN)
    run["alignment.converged"] = ("time", converged_at <= TIME)
    run["alignment.status"] = ("time", np.full(len(TIME), 2), FLAGS)
    errors = ("position_error", "velocity_error", "attitude_error", "heading_error")
    return run.assign({name: run[name].where(run["time"] >= start) for name in errors})


@pytest.mark.parametrize(
    ("converged_at", "start"), [(60.0, 60.0), (WINDOW[0] + 1, WINDOW[0] + 1), (60.0, np.nan)]
)
def test_what_is_kept_of_a_hand_over_makes_the_same_figures(converged_at: float, start: float) -> None:
    run = handed_over(converged_at, start)
    filters = xr.DataArray(["UKF"], dims="filter", name="filter")
    ((kept,),) = gathered([thinned(xr.concat([run], dim=filters, combine_attrs="override"))]).filters.values()
    for name, figure in FIGURES.items():
        assert np.array_equal(figure.of(kept, WINDOW), figure.of(run, WINDOW), equal_nan=True), name


def test_a_run_without_an_alignment_has_no_hand_over() -> None:
    assert hand_over.of_run(consistent()) is None


def test_what_is_known_at_the_hand_over() -> None:
    run = handed_over(60.0, 60.0)
    found, verdict = hand_over.of_run(run), judge(run)
    assert found == hand_over.HandOver(60.0, 60.0, WINDOW[0], 194 * ARCMIN, 288 * ARCMIN, "aligning")
    assert verdict.ok
    assert verdict.headline()["Alignment handed over"] == "at 60.0 s"
    assert verdict.headline()["Its heading error then"] == "+194.00 arcmin, sigma 288.00 arcmin"
    figures = verdict.to_json()
    assert figures["hand_over_time_s"] == 60
    assert figures["hand_over_heading_error_arcmin"] == pytest.approx(194)
    assert figures["hand_over_heading_sigma_arcmin"] == pytest.approx(288)
    without = judge(consistent()).to_json()
    assert {name: figures[name] for name in without} == {**without, "sure_for_s": 941.0}  # of 1001 s


@pytest.mark.parametrize(
    ("converged_at", "start", "sentence"),
    [
        (
            np.inf,
            np.nan,
            "Not navigated: the alignment has not converged; it is aligning at the end, its heading sigma"
            " 100.00 arcmin",
        ),
        (
            WINDOW[0] + 1,
            WINDOW[0] + 1,
            "Not navigated: the alignment handed over at 101.0 s, after the evaluation began at 100 s",
        ),
        (
            60.0,
            np.nan,
            "Not navigated: the alignment converged at 60.0 s, but navigation did not take it over",
        ),
    ],
)
def test_a_hand_over_that_fails_is_told(converged_at: float, start: float, sentence: str) -> None:
    verdict = judge(handed_over(converged_at, start))
    assert not verdict.ok
    assert verdict.sentence() == sentence
    figures = json.loads(json.dumps(verdict.to_json(), allow_nan=False))
    assert figures["horizontal_rmse_m"] is None
    assert "Horizontal RMSE" not in verdict.headline()
    assert verdict.row()["horiz.\n[m]"] == "-"
    assert verdict.row().keys() == judge(consistent()).row().keys()
