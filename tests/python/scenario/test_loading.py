"""Scenario files: what is accepted, what is refused and how."""

import re
from pathlib import Path

import pytest

from sim_scenarios.catalogue import scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import DEGREE

SHIPPED = {
    "align_then_navigate",
    "swaying_ship",
    "swaying_ship_printed",
    "waves",
    "any_heading",
    "coloured_noise",
    "zigzag",
    "turn",
    "overconfident_prior",
    "gnss_outliers",
    "parked_vehicle",
    "flight_constant_speed",
    "flight_outliers",
    "flight_wrong_start",
    "flight_accelerometer_fault",
    "flight_varying_noise",
    "flight_loose_tight",
    "gnss_outage_turn",
    "gnss_outage_turn_tight",
    "static_large_misalignment",
    "static_large_misalignment_azimuth",
    "static_large_misalignment_small",
    "swaying_ship_coloured",
    "flight_nominal",
    "flight_tight",
    "flight_tight_outliers",
    "dvl_alignment",
    "compass_start",
    "car_odometer",
}


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(f'description = "mine"\n{text}', encoding="utf-8")
    return path


def test_all_scenarios_are_shipped_and_described() -> None:
    assert set(scenarios()) == SHIPPED
    assert all(len(description) > 30 for description in scenarios().values())


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_shipped_scenarios_are_valid(name: str, fmus: Fmus) -> None:
    scenario = load_scenario(name, fmus)
    assert scenario.name == name
    assert len(scenario.filters()) >= 2


def test_the_comparison_with_zhou_says_what_holds(fmus: Fmus) -> None:
    notes = load_scenario("swaying_ship_printed", fmus).notes.replace("\n", " ")
    assert "16.9' is near the optimum for the printed conditions" in notes
    assert "4.3' cannot be a statistic of them" in notes


def test_units_names_and_broadcasting(tmp_path: Path, fmus: Fmus) -> None:
    path = written(
        tmp_path,
        """
        duration = 400.0
        [initial_error]
        misalignment = ["30 arcmin", 0.1, "60 deg"]
        [plant]
        imu.gyro.bias = "0.1 deg/h"
        motion.kind = "parked_vehicle"
        [filter]
        corrector = "h_infinity"
        [compare."A"]
        robust.gamma = 3.0
        """,
    )
    scenario = load_scenario(path, fmus)
    assert scenario.name == "mine"
    assert scenario.initial_error.misalignment == pytest.approx((0.5 * DEGREE, 0.1, 60 * DEGREE))
    assert scenario.plant["imu.gyro.bias[3]"] == pytest.approx(0.1 * DEGREE / 3600)
    assert scenario.plant["motion.kind"] == 2
    assert scenario.filters() == {"A": {"corrector": 2, "robust.gamma": 3.0}}


def test_a_scenario_that_names_no_filters_compares_ekf_ukf_and_robust_ukf(tmp_path: Path, fmus: Fmus) -> None:
    assert list(load_scenario(written(tmp_path, ""), fmus).compare) == ["EKF", "UKF", "robust UKF"]


def test_a_scenario_names_its_filter(tmp_path: Path, fmus: Fmus) -> None:
    both = Fmus({**fmus, "Other": fmus.filter})
    path = written(tmp_path, 'filter_fmu = "Other"\n[filter]\nrobust.gamma = 3.0')
    scenario = load_scenario(path, both)
    assert (scenario.filter_fmu, scenario.filter, scenario.compare) == ("Other", {"robust.gamma": 3.0}, {})
    assert load_scenario("waves", both).filter_fmu == fmus.filter.name == "AlignmentFilter"
    assert load_scenario("waves", both, settings={"filter_fmu": "Other"}).filter_fmu == "Other"


def test_extending_replaces_entries_and_the_whole_comparison(tmp_path: Path, fmus: Fmus) -> None:
    path = written(tmp_path, 'extends = "zigzag"\n[plant]\ngnss.rate = 5.0\n[compare."only"]\n')
    scenario, base = load_scenario(path, fmus), load_scenario("zigzag", fmus)
    assert scenario.plant == {**base.plant, "gnss.rate": 5.0}
    assert scenario.filter == base.filter
    assert list(scenario.compare) == ["only"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("duratoin = 3.0", "mine.toml: duratoin: there is no such entry; did you mean 'duration'"),
        (
            "[evaluation]\nstrat = 3",
            "mine.toml: evaluation.strat: there is no such entry; did you mean 'start'",
        ),
        (
            "[plant]\nmotion.turn.angel = 3",
            "mine.toml: plant: .*'motion.turn.angel'; did you mean 'motion.turn.angle'",
        ),
        (
            "[filter]\npredictor = 'unscentd'",
            "mine.toml: filter: predictor: 'unscentd' is none of .*'unscented'",
        ),
        (
            '[filter]\nprior.heading_sigma = "1 mg"',
            "prior.heading_sigma: '1 mg' is not in a unit .* rad, deg",
        ),
        ("[filter]\nimu.rate = 100.0", "AlignmentFilter has no parameter 'imu.rate'"),
        ("[compare.'UKF']\ncorector = 1", "mine.toml: compare.UKF: .*'corector'; did you mean 'corrector'"),
        (
            "[initial_error]\nmisalignment = ['1 deg', '2 m', 0]",
            r"initial_error.misalignment.1: '2 m' is not",
        ),
        ("duration = 'long'", "mine.toml: duration: 'long' is neither a number nor"),
        ("duration = 100.0", "evaluation.start = 300: must be below duration"),
        ("communication_step = 0.0", "communication_step = 0 s: must be greater than 0"),
        (
            "[evaluation]\nstart = 500.0\nstop = 400.0",
            "evaluation.start = 500 s: must be .* before evaluation.stop",
        ),
        ("plant = 3", "mine.toml: plant: '3' is not a table"),
        ("plant = [", "mine.toml: not valid TOML"),
        ("filter_fmu = 'Teapot'", "mine.toml: Teapot.fmu is not in .*; run `make fmus`"),
        ('extends = "zigzig"', "mine.toml: extends: there is no scenario 'zigzig'; did you mean 'zigzag'"),
    ],
)
def test_errors_name_file_and_key(tmp_path: Path, fmus: Fmus, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario(written(tmp_path, text), fmus)


def test_a_circle_of_scenarios_is_refused(tmp_path: Path, fmus: Fmus) -> None:
    path = written(tmp_path, f'extends = "{tmp_path}/mine.toml"')
    with pytest.raises(InputError, match="extends this file in turn"):
        load_scenario(path, fmus)


def test_a_description_is_required(tmp_path: Path, fmus: Fmus) -> None:
    path = tmp_path / "mute.toml"
    path.touch()
    with pytest.raises(InputError, match=r"mute.toml: description: field required"):
        load_scenario(path, fmus)


def test_an_alignment_has_the_parameters_and_units_of_its_fmu(fmus: Fmus) -> None:
    settings = {
        "alignment.error_model": "large_azimuth",
        "alignment.prior.heading_sigma": "20 deg",
        "filter.prior.position_sigma": 3.0,
        "process.gyro_bias_random_walk": 1e-9,  # of NavigationFilter alone
        "velocity_form": "transposed",  # of AlignmentFilter alone
    }
    scenario = load_scenario("align_then_navigate", fmus, settings=settings)
    assert scenario.fmu_names() == ["TruthPlant", "AlignmentFilter", "NavigationFilter"]
    assert scenario.alignment is not None
    assert scenario.alignment["error_model"] == 1
    assert scenario.alignment["prior.heading_sigma"] == pytest.approx(20 * DEGREE)
    assert scenario.alignment["velocity_form"] == fmus.filter.assignments("velocity_form", "transposed").pop(
        "velocity_form"
    )
    for values in scenario.filters().values():
        assert values["prior.position_sigma"] == 3.0
        assert values["process.gyro_bias_random_walk"] == 1e-9
    assert load_scenario("waves", fmus).alignment is None


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        (
            "align_then_navigate",
            {"corrector": "standard"},
            "both FMUs have a parameter corrector; say filter.corrector or alignment.corrector",
        ),
        (
            "align_then_navigate",
            {"gnss.lever_arm": 0.0},
            "3 FMUs have a parameter gnss.lever_arm; say plant.* or filter.* or alignment.gnss.lever_arm",
        ),
        (
            "align_then_navigate",
            {"alignment.robust.gama": 2.0},
            "AlignmentFilter has no parameter .*robust.gamma",
        ),
        (
            "align_then_navigate",
            {"alignment.prior.heading_sigma": "2 m"},
            "'2 m' is not in a unit .* rad, deg",
        ),
        (
            "align_then_navigate",
            {"filter.initial.heading": 1.0},
            r"filter: initial.heading is handed over; the alignment starts from alignment.initial.\*",
        ),
        (
            "align_then_navigate",
            {"filter_fmu": "AlignmentFilter"},
            "alignment: is handed over to a NavigationFilter, and filter_fmu is AlignmentFilter",
        ),
        ("swaying_ship", {"alignment.error_model": "invariant"}, "the scenario has no table alignment"),
    ],
)
def test_bad_alignments_are_refused(fmus: Fmus, name: str, settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario(name, fmus, settings=settings)


def test_a_wrong_name_is_answered_with_the_right_one(fmus: Fmus) -> None:
    with pytest.raises(InputError, match="'swaying_shp'; did you mean 'swaying_ship'"):
        load_scenario("swaying_shp", fmus)
    with pytest.raises(InputError, match=r"there is no scenario file nowhere/x.toml"):
        load_scenario("nowhere/x.toml", fmus)


def test_the_scenario_of_the_documents_is_one(tmp_path: Path, fmus: Fmus) -> None:
    page = (Path(__file__).parents[3] / "docs" / "scenarios.md").read_text()
    shown, trajectory, waypoints, _of_your_own_filter = re.findall(
        r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL
    )
    (tmp_path / "mine.toml").write_text(shown)
    (tmp_path / "way.toml").write_text(waypoints)
    way = load_scenario(tmp_path / "way", fmus)
    assert way.waypoints is not None
    assert way.waypoints.speed == 8.0
    (tmp_path / "file.toml").write_text(trajectory)
    with pytest.raises(InputError, match=r"trajectory: there is no file .*ship\.csv"):
        load_scenario(tmp_path / "file", fmus)
    scenario = load_scenario(tmp_path / "mine", fmus)
    assert scenario.plant["gnss.rate"] == 5.0
    assert scenario.bound.gyro_bias_sigma == scenario.plant["imu.gyro.bias_sigma"]
