"""Figures of runs in closed form, one by one and folded; and those that other packages add."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from made_up import run_with

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import NAVIGATION_FILTER
from sim_scenarios.metrics import figures, judge
from sim_scenarios.metrics.figures import FIGURES, Figure, shipped
from sim_scenarios.metrics.folds import LAST
from sim_scenarios.studies import quantities
from sim_scenarios.studies.expectations import Expectations, Row
from sim_scenarios.timeline import Window
from sim_scenarios.units import ARCMIN

TIME = np.arange(601.0)

Register = Callable[[dict[str, str]], None]


def of(name: str, run: xr.Dataset, window: Window | None = None) -> float:
    return FIGURES[name].of(run, window or figures.window(run))


def test_every_figure_has_a_name_of_its_own_and_says_what_it_is() -> None:
    assert len(list(shipped._figures())) == len(FIGURES)
    for name, one in FIGURES.items():
        assert one.name == name
        assert one.title, name
        assert one.unit, name
        assert one.description, name


def test_rmse_of_a_constant_and_of_a_sine() -> None:
    assert of("heading_rmse", run_with(TIME, heading=-0.3), (300, 600)) == pytest.approx(0.3)
    sine = run_with(TIME, heading=0.1 * np.sin(2 * np.pi * TIME / 50))
    assert of("heading_rmse", sine, (300, 599)) == pytest.approx(0.1 / np.sqrt(2))


def test_rmse_wraps_and_ignores_what_is_outside_the_window() -> None:
    run = run_with(TIME, heading=np.where(TIME < 300, 1.0, 2 * np.pi - 0.01))
    assert of("heading_rmse", run, (300, 600)) == pytest.approx(0.01)


def test_a_window_without_an_instant_is_refused() -> None:
    for name in ("heading_rmse", "largest_velocity", "horizontal_at_end", "nees"):
        with pytest.raises(InputError, match="between 700 s and 800 s"):
            of(name, run_with(TIME), (700, 800))


def test_every_error_is_that_of_its_components() -> None:
    """East, north and up all differ, so that none can stand for another."""
    run = run_with(
        TIME, attitude=[3e-3, 4e-3, 9e-3], velocity=[0.2, 0.3, 0.6], position=[3.0, 4.0, 7.0], heading=-0.01
    )
    expected = {
        **{"heading": 0.01, "yaw": 0.01, "tilt": 5e-3, "tilt_east": 3e-3, "tilt_north": 4e-3},
        **{"velocity": 0.7, "velocity_east": 0.2, "largest_velocity": 0.3},
        **{"horizontal": 5.0, "vertical": 7.0, "horizontal_at_end": 5.0},
        **{f"{name}_rmse": value for name, value in (("heading", 0.01), ("tilt", 5e-3), ("velocity", 0.7))},
        **{"horizontal_rmse": 5.0, "vertical_rmse": 7.0},
        **{"heading_mean": -0.01, "heading_end": -0.01, "heading_largest": 0.01},
    }
    assert {name: of(name, run) for name in expected} == pytest.approx(expected)


def test_the_largest_is_of_any_component_and_the_end_is_of_the_window() -> None:
    velocity = np.array([[0.0, -4.0, 9.0], [3.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    position = np.array([[3.0, 4.0, 0.0], [6.0, 8.0, 1.0], [0.0, 1.0, 0.0]])
    run = run_with([0.0, 1.0, 2.0], velocity=velocity, position=position, heading=[3.0, -2.0, 1.0])
    assert of("largest_velocity", run) == 4.0
    assert of("largest_velocity", run, (1.0, 2.0)) == 3.0
    assert of("horizontal_at_end", run, (0.0, 1.0)) == 10.0
    assert of("heading_largest", run, (1.0, 2.0)) == 2.0
    assert of("heading_end", run, (0.0, 1.0)) == pytest.approx(1.0)  # of the run, whatever the window


def test_figures_of_what_a_run_does_not_have_are_none() -> None:
    run = run_with(TIME).drop_vars("position_error")
    for name in (
        "horizontal_rmse",
        "nis",
        "nis_sum",
        "nees",
        "used_fixes",
        "rejected_fixes",
        "hand_over_time",
    ):
        assert np.isnan(of(name, run)), name


def test_a_run_has_failed_whose_root_mean_square_is_beyond_twice_the_limit() -> None:
    for heading, failed in (([1.99, 1.99], 0), ([2.01, 2.01], 1), ([0.0, 3.0], 1), ([0.0, 2.8], 0)):
        assert of("failures", run_with([0.0, 1.0], heading=heading)) == failed, heading


def runs_with(*headings: list[float], limit: float = 0.9) -> list[xr.Dataset]:
    return [run_with(np.arange(float(len(one))), heading=one, limit=limit) for one in headings]


def folded(name: str, runs: list[xr.Dataset], window: Window | None = None) -> float:
    return FIGURES[name].of_runs(runs, window or figures.window(runs[0]))


def test_root_mean_squares_of_two_runs_are_folded_over_both_or_meant() -> None:
    runs = [
        run_with([0.0, 1.0], velocity=[[3, 4, 0], [0, 0, 0]], heading=[0.3, 0.0]),
        run_with([0.0, 1.0], velocity=[[0, -6, 0], [8, 0, 0]], heading=[0.0, 0.4]),
    ]
    assert folded("heading", runs) == pytest.approx(np.sqrt((0.09 + 0.16) / 4))
    assert folded("velocity", runs) == pytest.approx((np.sqrt(12.5) + np.sqrt(50)) / 2)
    assert folded("largest_velocity", runs) == pytest.approx((4 + 8) / 2)


def test_settling_is_of_the_root_mean_square_over_runs() -> None:
    runs = runs_with([3.0, 1.0, 0.95, 0.0], [3.0, 1.0, 0.8, 0.0])
    assert folded("settling", runs) == 2.0
    assert FIGURES["settling"].of_each(runs, (0.0, 3.0)).tolist() == [3.0, 2.0]
    assert folded("settling", runs_with([2.0, 2.0])) == np.inf
    runs[1].attrs["evaluation.heading_limit"] = 0.1  # the limit is that of the first
    assert folded("settling", runs) == 2.0
    assert np.isnan(of("convergence_time", runs_with([2.0, 2.0])[0]))


def test_the_median_run_settles_and_a_failed_one_is_counted() -> None:
    runs = runs_with([3.0, 1.0, 0.0], [3.0, 0.5, 0.0], [3.0, 3.0, 3.0])
    assert folded("median_settling", runs) == 2.0  # of 2 s, 1 s and never
    assert folded("failures", runs, (1.0, 2.0)) == 1
    assert folded("success", runs, (1.0, 2.0)) == pytest.approx(2 / 3)


def test_navigation_succeeds_within_its_own_limit_whatever_the_heading_does() -> None:
    for position, good in (([3.0, 4.0, 99.0], 1), ([3.1, 4.0, 0.0], 0)):
        run = run_with([0.0, 1.0], position=position, heading=9.0, limit=5.01)
        run.attrs["filter_fmu"] = NAVIGATION_FILTER
        assert of("success", run) == good, position


def test_the_nis_of_runs_is_that_of_all_their_fixes() -> None:
    """A fix with more channels, and a run with more fixes, weigh more."""

    def run(nis: list[float], channels: list[int], used: list[bool]) -> xr.Dataset:
        sigma = (np.arange(6) < np.array(channels)[:, None]).astype(float)
        return (
            run_with(TIME)
            .assign(nis=("fix", nis), innovation_sigma=(("fix", "axis6"), sigma), fix_used=("fix", used))
            .assign_coords(fix_time=("fix", np.arange(len(nis)) + 1.0))
        )

    one = run([3.0, 9.0, 100.0], [3, 6, 6], [True, True, False])
    other = run([2.0], [4], [True])
    assert of("nis", one) == pytest.approx(12 / 9)
    assert (of("nis_sum", one), of("nis_channels_sum", one)) == (12.0, 9.0)
    assert of("nis_sum", one, (2.0, 3.0)) == 9.0
    assert folded("nis", [one, other]) == pytest.approx(14 / 13)


def test_a_figure_of_another_package_is_told_wherever_figures_are(register: Register) -> None:
    register({"peak": "own_figures:heading_peak"})
    one = figures.known()["peak"]
    assert (one.name, one.fold) == ("peak", LAST)
    assert one.description == "The largest size of the heading error in the window"
    run = run_with(TIME, window=(1.0, 600.0), heading=np.where(TIME == 7, -30 * ARCMIN, 0.0))
    verdict = judge(run)
    assert verdict.headline()["largest size of the heading"] == "30 arcmin"
    assert json.loads(json.dumps(verdict.to_json()))["figures"] == {
        "peak": {"value": pytest.approx(30 * ARCMIN), "unit": "rad"}
    }
    assert list(quantities.figures())[-1] == "peak"
    assert quantities.outputs()[-1] == "robust.gamma_effective"
    assert quantities.kept(run, 1.0)["peak"] == pytest.approx(30 * ARCMIN)
    assert Expectations(figures={"UKF": {"peak": 1.0}}).figures["UKF"] == {"peak": 1.0}
    assert Row("UKF", "peak", 1.0, 1.0, None, None).title == "largest size of the heading [']"


@pytest.mark.parametrize(
    ("points", "sentence"),
    [
        ({"heading": "own_figures:heading_peak"}, "there is a figure of that name already"),
        ({"my peak": "own_figures:heading_peak"}, "its name must have letters, digits and _ only"),
        ({"peak": "own_figures:no_figure"}, "must be a function marked as a figure, not <function no_figure"),
        ({"peak": "own_figures:sums"}, "its fold is for figures that come with the package"),
        ({"peak": "no_such_module:peak"}, "ModuleNotFoundError: No module named 'no_such_module'"),
    ],
)
def test_what_is_no_figure_is_refused_by_name(
    register: Register, points: dict[str, str], sentence: str
) -> None:
    register(points)
    ((name, value),) = points.items()
    with pytest.raises(
        InputError, match=f"figure {name} = {value} \\(entry point truenorth.figures\\): {sentence}"
    ):
        figures.known()


def test_a_figure_that_cannot_be_told_says_which(register: Register) -> None:
    register({"mine": "own_figures:fails"})
    with pytest.raises(
        InputError, match=r"figure mine = own_figures:fails .*: ZeroDivisionError: of nothing"
    ):
        judge(run_with(TIME))


def test_without_entry_points_there_are_no_others() -> None:
    assert figures.known().keys() == {*FIGURES, *figures.own()}
    assert all(isinstance(one, Figure) for one in figures.known().values())
