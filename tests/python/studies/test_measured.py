"""What a campaign has stored, as runs and as figures of them; several runs beside each other."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from made_up import run_with

from sim_scenarios import recording
from sim_scenarios.metrics.figures import FIGURES, Figure
from sim_scenarios.metrics.folds import OF_ERRORS
from sim_scenarios.studies import measured
from sim_scenarios.studies.ensemble import Ensemble
from sim_scenarios.studies.measured import Stored
from sim_scenarios.timeline import Window
from sim_scenarios.units import ARCMIN

CASES, FILTERS, RUNS, INSTANTS = ("one", "other"), ("a", "b"), 3, 5
THERE = 4
"""Instants of the second case, which is shorter."""
FIGURE = ("scenario", "filter", "run")


@pytest.fixture
def data() -> xr.Dataset:
    """Results of two cases; every value is one of a kind."""
    shape = (len(CASES), len(FILTERS), RUNS)
    time = np.tile(np.arange(float(INSTANTS)), (len(CASES), 1))
    time[1, THERE:] = np.nan
    axes = {name: () if name == "heading_error" else (3,) for name in recording.ERRORS}
    errors = {
        f"recorded.{name}": (
            (*FIGURE, "instant", *("axis3" for _ in axis)),
            np.arange(np.prod((*shape, INSTANTS, *axis)), dtype=float).reshape(*shape, INSTANTS, *axis),
        )
        for name, axis in axes.items()
    }
    figures = {
        name: (FIGURE, (size + np.arange(np.prod(shape)).reshape(shape)) * ARCMIN)
        for name, size in (("heading", 100.0), ("heading.1-3", 200.0))
    }
    windows = {"one": (0.0, 1.0), "other": (2.0, 3.0)}
    cases = {
        case: {"attributes": {"evaluation.start": start, "evaluation.stop": stop}}
        for case, (start, stop) in windows.items()
    }
    return xr.Dataset(
        {"recorded.time": (("scenario", "instant"), time), **errors, **figures},
        coords={"scenario": list(CASES), "filter": list(FILTERS)},
        attrs={"cases": json.dumps(cases)},
    )


def test_runs_that_are_stored_are_those_of_their_case_and_filter(data: xr.Dataset) -> None:
    """As long as the case is, each with its own errors and the window of the case."""
    stored = Stored(data, "other")
    assert stored.count == RUNS
    assert stored.window == (2.0, 3.0)
    runs = stored.runs("b")
    assert len(runs) == RUNS
    for number, run in enumerate(runs):
        assert run["time"].values.tolist() == [0.0, 1.0, 2.0, 3.0]
        assert run.attrs["evaluation.start"] == 2.0
        for name in recording.ERRORS:
            kept = data[f"recorded.{name}"].sel(scenario="other", filter="b", run=number)
            np.testing.assert_array_equal(run[name], kept[:THERE])


def test_figures_that_are_stored_are_those_of_their_case_filter_and_window(data: xr.Dataset) -> None:
    stored = Stored(data, "other")
    assert stored.each(FIGURES["heading"], "b", None) == pytest.approx(np.array([109, 110, 111]) * ARCMIN)
    assert stored.of_each("heading", "b") == pytest.approx([109, 110, 111])
    assert stored.of_each("heading", "b", (1.0, 3.0)) == pytest.approx([209, 210, 211])
    assert stored.figure("heading", "b", (1.0, 3.0), over="a") == pytest.approx(210 / 207, rel=1e-4)


def test_a_figure_of_errors_over_another_filters_is_of_the_errors_of_both() -> None:
    """The heading is within its limit from 3 s on with one filter, from 1 s on with the other."""
    time = np.arange(6.0)
    runs = Ensemble(
        {
            label: [run_with(time, heading=np.where(time < settled, 2.0, 0.1), limit=1.0)]
            for label, settled in (("late", 3.0), ("early", 1.0))
        }
    )
    assert runs.figure("settling", "late", over="early") == pytest.approx(3.0)


def test_a_figure_of_the_errors_of_all_runs_is_over_the_window_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def last(run: xr.Dataset, window: Window) -> float:
        return float(run["heading_error"].sel(time=window[1]))

    one = Figure("last", "last", "1", "At the end of the window", last, OF_ERRORS)
    monkeypatch.setattr(measured, "known", lambda: {"last": one})
    runs = Ensemble({"a": [run_with([0.0, 1.0, 2.0], heading=[0.1, 0.2, size]) for size in (0.1, 0.7)]})
    assert runs.figure("last", "a") == pytest.approx(0.5)
    assert runs.figure("last", "a", window=(0.0, 1.0)) == pytest.approx(0.2)


@pytest.mark.parametrize("error", ["attitude", "velocity", "position"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_largest_difference_is_that_of_any_axis(error: str, axis: int) -> None:
    """The attitude about up is the heading's, whose error is told apart."""
    if (error, axis) == ("attitude", 2):
        error = "heading"
    apart = np.zeros((2, 1 if error == "heading" else 3))
    apart[1, 0 if error == "heading" else axis] = -1e-6
    runs = Ensemble({"a": [run_with([0.0, 1.0])], "b": [run_with([0.0, 1.0], **{error: apart.squeeze()})]})
    assert runs.largest_difference("b", "a") == pytest.approx(1e-6)
