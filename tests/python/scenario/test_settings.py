"""Settings that override a scenario file: where they go, and those that are refused."""

import pytest

from sim_scenarios.catalogue import scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import DEGREE


def test_settings_override_file_and_every_filter(fmus: Fmus) -> None:
    scenario = load_scenario(
        "swaying_ship",
        fmus,
        seed=9,
        settings={
            "imu.gyro.bias[1]": "0.1 deg/h",
            "filter.interval": 0.5,
            "robust.scaling": "printed",
            "plant.gnss.lever_arm": [0, 0, 5],
            "duration": 900,
            "evaluation.stop": 900,
        },
    )
    assert scenario.plant["seed"] == 9
    assert scenario.plant["imu.gyro.bias[1]"] == pytest.approx(0.1 * DEGREE / 3600)
    assert scenario.plant["gnss.lever_arm[3]"] == 5
    assert "gnss.lever_arm[3]" not in scenario.filter
    assert (scenario.duration, scenario.evaluation.stop, scenario.evaluation.start) == (900, 900, 300)
    for values in (scenario.filter, *scenario.filters().values()):
        assert values["filter.interval"] == 0.5
        assert values["robust.scaling"] == 1


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"gnss.lever_arm": 1.0},
            "both FMUs have a parameter gnss.lever_arm; say plant.gnss.lever_arm or filter",
        ),
        ({"robust.gama": 2.0}, "the setting robust.gama: .*did you mean 'robust.gamma'"),
        ({"plant.robust.gamma": 2.0}, "TruthPlant has no parameter 'robust.gamma'"),
        ({"robust.gamma": "2 deg"}, "robust.gamma: '2 deg' is not in a unit"),
        ({"duration": -1.0}, "duration = -1 s"),
        ({"evaluation.begin": 1.0}, "evaluation.begin: there is no such entry"),
    ],
)
def test_bad_settings_are_refused(fmus: Fmus, settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scenario("swaying_ship", fmus, settings=settings)


@pytest.mark.parametrize(
    ("scenario", "settings", "labels", "words"),
    [
        ("swaying_ship", {"predictor": "unscented"}, ["EKF"], "predictor: EKF is what it is by its own"),
        ("swaying_ship", {"filter.corrector": "igg"}, ["UKF"], "corrector: UKF is what it is by its own"),
        ("swaying_ship", {"corrector": "standard"}, ["UKF", "robust UKF"], "UKF and robust UKF the same"),
        ("gnss_outliers", {"gate.enabled": True}, ["UKF, no gate"], "gate.enabled: UKF, no gate is what"),
    ],
)
def test_no_setting_makes_a_filter_another_than_its_label_says(
    fmus: Fmus, scenario: str, settings: dict[str, object], labels: list[str], words: str
) -> None:
    """Of those that run: of one filter alone, anything may be set, and of all what none of them says."""
    for running in (None, labels):
        with pytest.raises(InputError, match=words if running else "filter"):
            load_scenario(scenario, fmus, settings=settings, running=running)
    load_scenario(scenario, fmus, settings=settings)
    load_scenario(scenario, fmus, settings=settings, running=["robust UKF, ceiling"])
    load_scenario(scenario, fmus, settings={"process.angle_random_walk": 1e-6}, running=None)


def test_no_axis_is_overruled(fmus: Fmus) -> None:
    compare = {"standard": {"corrector": "standard"}, "igg": {"corrector": "igg"}}
    with pytest.raises(InputError, match="standard is what it is by its own corrector = standard"):
        load_scenario("waves", fmus, settings={"corrector": "h_infinity"}, compare=compare, running=None)


@pytest.mark.parametrize("name", scenarios())
def test_no_scenario_says_the_same_filter_by_what_it_has_set(fmus: Fmus, name: str) -> None:
    """A setting of the plant changes no filter."""
    load_scenario(name, fmus, settings={"plant.seed": 5, "gnss.rate": 1.0}, running=None)
