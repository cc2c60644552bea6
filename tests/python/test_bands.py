"""The Monte-Carlo table: its arithmetic, and that it runs."""

import pytest

from sim_scenarios.bands import CHECKS, Check, heading_rmse, rows
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import load_scenario


def test_rows_are_root_mean_squares_over_runs() -> None:
    check = Check("any", {"a": (4, 6), "b": (0, 1)}, {("a", "b"): (0.9, 1.1)})
    a, b, ratio = rows(check, [{"a": 3.0, "b": 4.0}, {"a": 4.0, "b": 3.0}, {"a": 7.0, "b": 7.0}])
    root_mean_square = ((9 + 16 + 49) / 3) ** 0.5
    assert a.value == b.value == pytest.approx(root_mean_square)
    assert a.spread == (3, 7)
    assert (a.ok, b.ok, ratio.ok) == (True, False, True)
    assert a.markdown() == "| any | a | 4.97 | 3.00 to 7.00 | 4 to 6 | ok |"
    assert "**missed**" in b.markdown()


def test_every_check_names_filters_that_its_scenario_compares(fmus: Fmus) -> None:
    for check in CHECKS:
        filters = set(load_scenario(check.scenario, fmus).compare)
        assert filters >= {*check.bands, *(label for pair in check.ratios for label in pair)}, check.scenario


@pytest.mark.usefixtures("fmus")
def test_a_run_gives_a_figure_for_each_filter() -> None:
    figures = heading_rmse("overconfident_prior", 1)
    assert set(figures) == {"UKF", "robust UKF, heading only", "UKF, honest prior"}
    assert all(0 < figure < 120 for figure in figures.values())
