"""The Monte-Carlo table: its arithmetic, and that its scenarios and filters exist."""

from __future__ import annotations

import pytest
from made_up import run_with

from sim_scenarios.bands import CHECKS, Band, Check, rows
from sim_scenarios.ensemble import Ensemble
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.figures import FIGURES
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import ARCMIN


def runs_with(headings: dict[str, list[float]]) -> Ensemble:
    """Runs with a constant heading error each [arcmin]."""
    return Ensemble(
        {
            label: [run_with([0.0, 1.0], heading=error * ARCMIN, limit=ARCMIN) for error in each]
            for label, each in headings.items()
        }
    )


def test_rows_are_root_mean_squares_over_runs() -> None:
    check = Check("any", [Band("a", 4, 6), Band("b", 0, 1), Band("a", 0.9, 1.1, over="b")])
    runs = runs_with({"a": [3, 4, 7], "b": [4, 3, 7]})
    a, b, ratio = rows(check, runs, 3)
    root_mean_square = ((9 + 16 + 49) / 3) ** 0.5
    assert (a.value, b.value) == pytest.approx((root_mean_square, root_mean_square))
    assert a.spread == pytest.approx((3, 7))
    assert ratio.value == pytest.approx(1)
    assert (a.ok, b.ok, ratio.ok) == (True, False, True)
    assert a.markdown() == "| any | a | heading RMSE ['] | 4.967 | 3 to 7 | 4 to 6 | ok | `--only any -n 3` |"
    assert "**missed**" in b.markdown()
    assert ratio.markdown().startswith("| any | a / b | heading RMSE | 1 |  | 0.9 to 1.1 | ok |")


def test_a_row_says_what_the_settings_make_of_its_scenario() -> None:
    check = Check("any", [Band("a", 4, 6)], settings={"plant.seed": 2}, case="seed 2")
    (row,) = rows(check, runs_with({"a": [5]}), 1)
    assert row.markdown().startswith("| any, seed 2 | a |")


def test_two_filters_may_have_to_be_one() -> None:
    check = Check("any", [Band("a", 0, 1e-7, minus="b")])
    assert check.labels == ["a", "b"]
    for other, ok in ((3 + 1e-5, True), (3 + 1e-3, False)):  # 3e-9 and 3e-7 rad
        (row,) = rows(check, runs_with({"a": [3, 5], "b": [other, 5]}), 2)
        assert row.value == pytest.approx((other - 3) * ARCMIN, rel=1e-6)
        assert row.ok is ok
        assert row.markdown().startswith("| any | a - b | largest difference [SI] |")


def test_a_band_may_be_open_above() -> None:
    (row,) = rows(Check("any", [Band("a", 40, float("inf"))]), runs_with({"a": [50]}), 1)
    assert row.ok
    assert "| above 40 |" in row.markdown()


def test_every_check_names_filters_that_its_scenario_compares(fmus: Fmus) -> None:
    for check in CHECKS:
        assert set(load_scenario(check.scenario, fmus).compare) >= set(check.labels), check.scenario
        assert {band.figure for band in check.bands} <= FIGURES.keys()
        assert all(band.low < band.high for band in check.bands)
