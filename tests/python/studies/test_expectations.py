"""What is expected beside what was measured: its arithmetic, its words, and that what is stored is enough."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from made_up import run_with
from pydantic import ValidationError

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.studies import execution
from sim_scenarios.studies.campaign import Campaign
from sim_scenarios.studies.ensemble import Ensemble, ensemble
from sim_scenarios.studies.expectations import Band, Expectations, asked, rows
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.table import expectations as table
from sim_scenarios.units import ARCMIN


def runs_with(headings: dict[str, list[float]]) -> Ensemble:
    """Runs with a constant heading error each [arcmin]."""
    return Ensemble(
        {
            label: [run_with([0.0, 1.0], heading=error * ARCMIN, limit=ARCMIN) for error in each]
            for label, each in headings.items()
        }
    )


def of(**figures: dict[str, object]) -> Expectations:
    return Expectations.model_validate(
        {"figures": {k.replace("_over_", " / "): v for k, v in figures.items()}}
    )


def test_rows_are_root_mean_squares_over_runs() -> None:
    expected = of(a={"heading": [4, 6]}, b={"heading": [0, 1]}, a_over_b={"heading": [0.9, 1.1]})
    found = [*rows(expected, runs_with({"a": [3, 4, 7], "b": [4, 3, 7]}), "any")]
    a, b, ratio = found
    root_mean_square = ((9 + 16 + 49) / 3) ** 0.5
    assert (a.measured, b.measured) == pytest.approx((root_mean_square, root_mean_square))
    assert a.spread == pytest.approx((3, 7))
    assert ratio.measured == pytest.approx(1)
    assert [row.missed for row in found] == [False, True, False]
    _, first, second, third = table(found, digits=4)
    assert first[:5] == ["any", "a", "heading RMSE [']", "4 to 6", "4.967"]
    assert first[6:] == ["3 to 7", "ok"]
    assert table(found)[1][4] == "4.97"
    assert second[-1] == "**missed**"
    assert third[:5] == ["any", "a / b", "heading RMSE", "0.9 to 1.1", "1"]
    assert third[6:] == ["", "ok"]
    assert [row["missed"] for row in json.loads(json.dumps([row.to_json() for row in found]))] == [0, 1, 0]


def test_two_filters_may_have_to_be_one() -> None:
    expected = Expectations(figures={"a - b": {"largest_difference": (0, 1e-7)}})
    assert expected.filters() == ["a", "b"]
    for other, missed in ((3 + 1e-5, False), (3 + 1e-3, True)):  # 3e-9 and 3e-7 rad
        (row,) = rows(expected, runs_with({"a": [3, 5], "b": [other, 5]}))
        assert row.measured == pytest.approx((other - 3) * ARCMIN, rel=1e-6)
        assert row.missed is missed
        assert row.cells()[:2] == ["a - b", "largest difference [SI]"]


def test_a_band_may_be_open_above_and_a_run_that_stopped_keeps_none() -> None:
    expected = of(a={"heading": [40, float("inf")]})
    (row,) = rows(expected, runs_with({"a": [50]}))
    assert not row.missed
    assert row.cells()[2] == "above 40"
    (row,) = rows(expected, runs_with({"a": [50, float("nan")]}))
    assert row.missed


def test_a_band_is_made_of_what_stands_for_it() -> None:
    figures = of(a={"heading": {"mean": 3.0, "deviation": 1.0}, "nees_at_end": {"states": 12}}).figures["a"]
    assert figures["heading"] == Band(low=3 - 1.1, high=3 + 1.1)
    consistent = figures["nees_at_end"]
    assert isinstance(consistent, Band)
    low, high = chi_square_interval(12 * 20)
    assert consistent.of(20) == Band(low=low / 240, high=high / 240)


@pytest.mark.parametrize(
    ("why", "sentences"),
    [
        ("", []),
        ("As printed", ["As printed"]),
        (
            {"nees": "By chance", "largest_difference": "To be one"},
            ["NEES / states: By chance", "largest difference [SI]: To be one"],
        ),
    ],
)
def test_a_reason_is_of_all_figures_or_of_each(why: object, sentences: list[str]) -> None:
    assert Expectations.model_validate({"figures": {}, "why": why}).reasons() == sentences


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        ({"a": {"headings": 1.0}}, "there is no figure 'headings'; did you mean 'heading'"),
        ({"a": {"heading": [2, 1]}}, "2 to 1: the first must be below the second"),
        ({"a": {"largest_difference": [0, 1]}}, "largest_difference is of two filters"),
        ({"a - b": {"heading": [0, 1]}}, "largest_difference is of two filters"),
    ],
)
def test_what_cannot_be_expected_is_refused(figures: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        Expectations.model_validate({"figures": figures})


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"figures": {"UFK": {"heading": 1.0}}}, "expect: there is no filter 'UFK'; did you mean 'UKF'"),
        (
            {"cases": ["zigzig"], "figures": {"UKF": {"heading": 1.0}}},
            "there is no case 'zigzig'; did you mean",
        ),
    ],
)
def test_what_the_campaign_does_not_have_is_refused(
    entry: dict[str, object], words: str, fmus: Fmus, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        Campaign.of(load_plan("zigzag", expect=(entry,)), tmp_path, fmus=fmus)


def test_errors_at_every_instant_are_kept_only_where_they_count() -> None:
    kept = asked([of(a={"heading": 1.0}, b={"nis": 1.0})])
    assert (kept.figures, kept.errors) == ((("heading", None), ("nis", None)), False)
    assert [one.name for one in kept] == ["heading", "nis", "nis_sum", "nis_channels_sum"]
    assert asked([of(a={"settling": 1.0})]).errors
    assert asked([Expectations(figures={"a - b": {"largest_difference": (0, 1)}})]).errors


def test_what_is_stored_measures_the_same_as_whole_runs(fmus: Fmus, tmp_path: Path) -> None:
    """To the last bit: figures, folds and windows of every kind, and the difference of two filters."""
    short = {"duration": 60.0, "evaluation.start": 20.0, "evaluation.stop": 50.0}
    names = (
        "heading",
        "settling",
        "median_settling",
        "failures",
        "nis",
        "largest_velocity",
        "yaw",
        "tilt_east",
    )
    figures = {
        **{label: dict.fromkeys(names, 1.0) for label in ("UKF", "EKF")},
        "UKF / EKF": {"heading": 1.0, "settling": 1.0, "nis": 1.0},
        "UKF - EKF": {"largest_difference": (0.0, 1.0)},
    }
    entries = [{"figures": figures}, {"figures": figures, "window": (10.0, 31.4)}]
    plan = load_plan("swaying_ship", runs=3, seed=4, set=short, filters=("UKF", "EKF"), expect=entries)
    campaign = Campaign.of(plan, tmp_path, fmus=fmus)
    campaign.run(workers=1)
    with execution.workers(1, None) as workers:
        runs = ensemble(workers, "swaying_ship", [4, 5, 6], ["UKF", "EKF"], short)
    expected = [row for one in plan.expect for row in rows(one, runs, "swaying_ship")]
    assert repr(campaign.measured()) == repr(expected)  # also where a figure is no number
