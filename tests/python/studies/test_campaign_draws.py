"""What is drawn for each run: from which distribution, from which stream, and how a run is repeated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.studies.case import Case, filters_of
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.draws import Distribution, Draw, draw
from sim_scenarios.studies.plan import load_plan

DRAWS = 500


@pytest.fixture(scope="module")
def scenario(fmus: Fmus) -> Scenario:
    return load_scenario("waves", fmus)


def single(one: Draw, seeds: int = DRAWS) -> np.ndarray:
    return np.array([next(iter(one.drawn(seed).values())) for seed in range(seeds)])


def test_a_range_is_drawn_evenly_in_its_unit(scenario: Scenario, fmus: Fmus) -> None:
    values = single(draw("motion.speed", Distribution(uniform=(1.0, "3 m/s")), scenario, fmus))
    assert stats.kstest(values, stats.uniform(1, 2).cdf).pvalue > 1e-4
    angle = draw("motion.course", Distribution(uniform=("10 deg", "20 deg")), scenario, fmus)
    assert angle.units == {"motion.course": "rad"}
    assert (np.rad2deg(single(angle)) >= 10).all()
    assert (np.rad2deg(single(angle)) < 20).all()


def test_a_logarithmic_range_has_as_many_values_in_each_decade(scenario: Scenario, fmus: Fmus) -> None:
    given = Distribution(log_uniform=(1e-4, 1.0))
    values = single(draw("fault.imu.size", given, scenario, fmus))
    assert stats.kstest(np.log10(values), stats.uniform(-4, 4).cdf).pvalue > 1e-4


def test_whole_numbers_include_both_ends(scenario: Scenario, fmus: Fmus) -> None:
    one = draw("fault.imu.axis", Distribution(uniform=(1, 3)), scenario, fmus)
    values = single(one)
    assert all(isinstance(value, int) for value in one.drawn(1).values())
    numbers, counts = np.unique(values, return_counts=True)
    assert numbers.tolist() == [1, 2, 3]
    assert stats.chisquare(counts).pvalue > 1e-4


def test_a_choice_is_one_of_those_given(scenario: Scenario, fmus: Fmus) -> None:
    kinds = Distribution(choice=["silence", "zeros"])
    items = fmus.plant.variables["fault.imu.kind"].items
    drawn = set(single(draw("fault.imu.kind", kinds, scenario, fmus)).tolist())
    assert drawn == {items["silence"], items["zeros"]}
    turns = Distribution(choice=[["1 deg", "2 deg", "3 deg"], 0.0])
    sway = draw("motion.sway.amplitude", turns, scenario, fmus)
    vectors = {tuple(np.round(np.rad2deg(list(sway.drawn(seed).values())), 9)) for seed in range(20)}
    assert vectors == {(1, 2, 3), (0, 0, 0)}


def test_each_name_has_a_stream_of_its_own(scenario: Scenario, fmus: Fmus) -> None:
    given = Distribution(uniform=(0.0, 1.0))
    names = ("fault.imu.begin", "fault.gnss.begin", "fault.imu.duration")
    values = [single(draw(name, given, scenario, fmus)) for name in names]
    np.testing.assert_array_equal(values[0], single(draw(names[0], given, scenario, fmus)))
    correlation = np.corrcoef(values)[np.triu_indices(3, 1)]
    assert np.abs(correlation).max() < 4 / np.sqrt(DRAWS)


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        (
            "fault.imu.begin",
            {"uniform": (3.0, 2.0)},
            "uniform 3.0 to 2.0: the first must be below",
        ),
        ("fault.imu.size", {"log_uniform": (0.0, 2.0)}, "log_uniform 0.0 to 2.0: must be greater than 0"),
        ("fault.imu.kind", {"uniform": ("none", "silence")}, "has no values between; use choice"),
        ("fault.imu.kind", {"choice": ["silense"]}, "did you mean 'silence'"),
        ("motion.speed", {"uniform": ("1 deg", 3.0)}, "'1 deg' is not in a unit of this quantity"),
        ("fault.imu.begn", {"uniform": (0.0, 1.0)}, "did you mean 'fault.imu.begin'"),
        ("duration", {"uniform": (10.0, 20.0)}, "duration is no parameter of an FMU"),
    ],
)
def test_what_is_refused(scenario: Scenario, fmus: Fmus, name: str, given: dict, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        draw(name, Distribution(**given), scenario, fmus)
    assert words in str(refusal.value)


CAMPAIGN = """
scenarios = ["waves"]
filters = ["EKF", "UKF"]
[set]
duration = 40.0
"evaluation.start" = 20.0
"evaluation.stop" = 40.0
"fault.gnss.kind" = "velocity_sign"
"fault.gnss.duration" = 5.0
[draw]
"fault.gnss.begin" = { uniform = [10.0, 20.0] }
"measurement.velocity_sigma" = { log_uniform = [0.05, 0.5] }
"""


@pytest.fixture
def case(tmp_path: Path, fmus: Fmus) -> Case:
    path = tmp_path / "drawn.toml"
    path.write_text(CAMPAIGN, encoding="utf-8")
    return cases(load_plan(path), fmus)[-1]


def test_settings_of_what_was_drawn_repeat_a_run(case: Case, fmus: Fmus) -> None:
    """The scenario of a run is that of `truenorth compare --seed 7 --set ...` with the values drawn."""
    drawn = case.drawn(7)
    assert list(drawn) == ["fault.gnss.begin", "measurement.velocity_sigma"]
    repeated = load_scenario("waves", fmus, seed=7, settings={**case.settings, **drawn})
    run = case.with_seed(7)
    assert run.plant == repeated.plant
    assert run.filter == repeated.filter
    assert run.compare == {label: repeated.compare[label] for label in ("EKF", "UKF")}
    assert case.with_seed(8).plant != {**run.plant, "seed": 8}


def test_all_filters_of_a_run_have_what_is_drawn_for_them(case: Case) -> None:
    sigmas = {values["measurement.velocity_sigma"] for values in filters_of(case.with_seed(3)).values()}
    assert sigmas == {case.drawn(3)["measurement.velocity_sigma"]}
