"""Aids besides the receiver, through plant and filter."""

from __future__ import annotations

from contextlib import closing
from typing import Any, Final

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Instance
from sim_scenarios.metrics import certainty
from sim_scenarios.scenario import load_scenario

DEGREE: Final = np.pi / 180.0
WITHOUT_FIXES: Final = {"gnss.outage.begin[1]": -1e9, "gnss.outage.end[1]": 1e9}
INVARIANT: Final = {
    "error_model": "invariant",
    "predictor": "linearised",
    "corrector": "standard",
    "coarse.enabled": False,
}
MODELS: Final = {
    "10 states": {"error_model": "large_azimuth"},
    "10 states, open loop": {"error_model": "large_azimuth", "feedback": False},
    "invariant": INVARIANT,
}


def run(
    duration: float, fmus: Fmus, seed: int = 2, scenario: str = "swaying_ship", **settings: Any
) -> xr.Dataset:
    window = {"evaluation.start": 0.5 * duration, "evaluation.stop": duration}
    return sim_scenarios.run(scenario, seed=seed, set={"duration": duration, **window, **settings}, fmus=fmus)


def at(data: xr.Dataset, time: float, name: str) -> float:
    return float(np.abs(data[name].sel(time=time, method="nearest")))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_ship_without_gnss_aligns_with_a_log(seed: int, fmus: Fmus) -> None:
    data = run(400.0, fmus, seed, "dvl_alignment")
    assert data["used_fixes"].size == 0
    assert int(data["aid.body_velocity.used"][-1]) >= 395
    assert at(data, 400.0, "heading_error") < 1.0 * DEGREE
    assert at(data, 400.0, "heading_error") < 3.0 * at(data, 400.0, "heading_sigma")
    assert float(np.abs(data["velocity_error"][-1]).max()) < 0.3


@pytest.mark.parametrize("model", MODELS)
def test_a_log_does_for_every_model_what_fixes_do(model: str, fmus: Fmus) -> None:
    """As long as neither is told anything wrong."""
    log = run(
        300.0,
        fmus,
        **MODELS[model],
        **WITHOUT_FIXES,
        **{
            "body_velocity.rate": 1.0,
            "body_velocity.noise_sigma": 0.1,
            "measurement.body_velocity_sigma": 0.1,
        },
    )
    fixes = run(300.0, fmus, **MODELS[model])
    assert at(log, 300.0, "heading_error") < 3.0 * at(log, 300.0, "heading_sigma")
    assert at(log, 300.0, "heading_sigma") < 1.5 * at(fixes, 300.0, "heading_sigma")
    assert float(np.abs(log["velocity_error"][-1]).max()) < 0.5


def test_the_axis_that_a_log_does_not_measure_is_as_good_as_one_without_any_accuracy(fmus: Fmus) -> None:
    """A log of one axis, forward, beside one that says of its other axes that they are worthless."""
    log = {"body_velocity.rate": 1.0, "gate.enabled": False, "body_velocity.reports_sigma": True, **INVARIANT}
    one = run(100.0, fmus, **log, **{f"body_velocity.measures[{axis}]": False for axis in (1, 3)})
    worthless = run(100.0, fmus, **log, **{f"body_velocity.noise_sigma[{axis}]": 1e3 for axis in (1, 3)})
    every_axis = run(100.0, fmus, **log)
    heading, velocity = one["heading_error"].values, one["velocity_error"].values
    assert np.abs(heading - worthless["heading_error"].values).max() < 1e-3
    assert np.abs(velocity - worthless["velocity_error"].values).max() < 2e-3
    assert np.abs(velocity - every_axis["velocity_error"].values).max() > 2e-2
    assert int(one["aid.body_velocity.used"][-1]) == 100


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("sigma", [1.0, 5.0])
def test_a_heading_is_worth_what_bayes_says(model: str, sigma: float, fmus: Fmus) -> None:
    """One heading, before anything else is known: information adds up (closed form)."""
    settings = {
        **MODELS[model],
        "heading_aid.rate": 1.0,
        "heading_aid.noise_sigma": f"{sigma} deg",
        "measurement.heading_aid_sigma": f"{sigma} deg",
        "prior.heading_aid_bias_sigma": 0.0,
        "gate.enabled": False,
    }
    data = run(2.0, fmus, **settings)
    blind = run(2.0, fmus, **{**settings, "heading_aid.rate": 0.0})
    expected = (at(blind, 1.5, "heading_sigma") ** -2 + (sigma * DEGREE) ** -2) ** -0.5
    # Large azimuths are no linear matter: a prior of 10 deg makes some per cent of it.
    assert at(data, 1.5, "heading_sigma") == pytest.approx(expected, rel=0.03)
    assert int(data["aid.heading_aid.used"][-1]) == 2


def test_a_compass_shortens_the_way_and_leaves_the_end_alone(fmus: Fmus) -> None:
    with_it = run(300.0, fmus, scenario="compass_start")
    without = run(300.0, fmus, scenario="compass_start", **{"heading_aid.rate": 0.0})
    assert at(with_it, 60.0, "heading_sigma") < 0.5 * at(without, 60.0, "heading_sigma")
    for data in (with_it, without):
        for time in (60.0, 120.0, 300.0):
            assert at(data, time, "heading_error") < 3.0 * at(data, time, "heading_sigma")


@pytest.mark.parametrize("scenario", ["compass_start", "dvl_alignment"])
def test_the_comparison_that_is_shipped_runs_with_every_filter(scenario: str, fmus: Fmus) -> None:
    short = {"duration": 5.0, "evaluation.start": 1.0, "evaluation.stop": 5.0}
    data = sim_scenarios.compare(scenario, set=short, fmus=fmus)
    assert data.sizes["filter"] == 2
    assert np.isfinite(data["heading_error"].values).all()


def test_a_height_binds_the_vertical_channel_without_fixes(fmus: Fmus) -> None:
    settings = {**WITHOUT_FIXES, **INVARIANT, "body_velocity.rate": 1.0, "body_velocity.measures[3]": False}
    height = {
        "height_aid.rate": 1.0,
        "height_aid.noise_sigma": 1.0,
        "measurement.height_aid_sigma": 1.0,
        "prior.height_aid_bias_sigma": 0.0,
    }
    bound = run(300.0, fmus, **settings, **height)
    free = run(300.0, fmus, **settings)
    assert int(bound["aid.height_aid.used"][-1]) == 300
    assert float(np.abs(bound["position_error"][-1, 2])) < 2.0
    assert float(np.abs(free["position_error"][-1, 2])) > 5.0


def test_wheels_bind_what_an_odometer_leaves_free(fmus: Fmus) -> None:
    """Two minutes without fixes on a straight road: velocity forward from the one, across from the others."""
    settings = {
        **WITHOUT_FIXES,
        "motion.kind": "road_vehicle",
        "motion.speed": 15.0,
        "motion.segment.duration": 16 * [0.0],
        "body_velocity.rate": 1.0,
        "body_velocity.measures[1]": False,
        "body_velocity.measures[3]": False,
    }
    wheels = {"nonholonomic.velocity_sigma": 0.05}
    bound = run(120.0, fmus, scenario="flight_loose_tight", **settings, **wheels)
    free = run(120.0, fmus, scenario="flight_loose_tight", **settings)
    across = [float(np.linalg.norm(data["velocity_error"][-1, [0, 2]])) for data in (bound, free)]
    assert across[0] < 0.2 * across[1]
    assert int(bound["aid.nonholonomic.used"][-1]) >= 115
    assert int(free["aid.nonholonomic.used"][-1]) == 0


FALSE_HEADING: Final = {
    "heading_aid.rate": 1.0,
    "plant.heading_aid.bias_sigma": "60 deg",
    "heading_aid.noise_sigma": "0.5 deg",
    "prior.heading_sigma": "1 deg",
    "initial_error.misalignment": [0.0, 0.0, "0.5 deg"],
}


def test_an_aid_that_fixes_contradict_is_found_out_and_the_filter_not_sure(fmus: Fmus) -> None:
    """A compass 60 deg off beside good fixes: refused, then learned; nothing is spoilt, nothing promised."""
    data = run(200.0, fmus, seed=3, **FALSE_HEADING)
    assert 20 <= int(data["aid.heading_aid.rejected"][-1]) < 60
    assert "the prediction is blamed" not in str(data.attrs)
    assert "its constant errors are in doubt" in str(data.attrs)
    assert at(data, 200.0, "aid.heading_aid.bias") > 30.0 * DEGREE
    assert at(data, 200.0, "aid.heading_aid.bias_sigma") < 1.0 * DEGREE
    assert at(data, 200.0, "heading_error") < 3.0 * at(data, 200.0, "heading_sigma")
    assert not bool(data["converged"].values[10:].any())


def test_without_fixes_there_is_a_way_back_from_refusing_an_aid(fmus: Fmus) -> None:
    """The start is wrong by 60 deg, and told to within one; a log and a good compass find out."""
    data = run(
        300.0,
        fmus,
        **INVARIANT,
        **WITHOUT_FIXES,
        **{
            "body_velocity.rate": 1.0,
            "heading_aid.rate": 1.0,
            "heading_aid.noise_sigma": "0.5 deg",
            "prior.heading_sigma": "1 deg",
            "initial_error.misalignment": [0.0, 0.0, "60 deg"],
        },
    )
    assert "the prediction is blamed" in str(data.attrs)
    assert int(data["aid.heading_aid.used"][-1]) > 100
    assert at(data, 300.0, "heading_error") < 0.5 * DEGREE


def test_a_log_beside_fixes_keeps_the_ten_states_consistent(fmus: Fmus) -> None:
    """Its vertical velocity is no state of theirs, and as noisy as the last fix left it."""
    data = run(
        200.0,
        fmus,
        **{
            "body_velocity.rate": 1.0,
            "body_velocity.noise_sigma": 0.02,
            "measurement.body_velocity_sigma": 0.02,
        },
    )
    assert int(data["aid.body_velocity.rejected"][-1]) <= 1
    assert float(data["aid.body_velocity.nis_mean"][-1]) < 1.5
    assert bool(data["converged"][-1])


def test_the_scale_of_a_log_is_told_when_fixes_return(fmus: Fmus) -> None:
    """Nine minutes on a log that is 1 % off; the first fixes after it are taken, and nothing was promised."""
    data = run(
        700.0,
        fmus,
        **INVARIANT,
        **{
            "gnss.outage.begin[1]": 60.0,
            "gnss.outage.end[1]": 600.5,
            "body_velocity.rate": 1.0,
            "plant.body_velocity.scale_sigma": 0.01,
            "filter.body_velocity.scale_sigma": 0.01,
        },
    )
    assert certainty.of_run(data).wrongly < 1.0
    assert int(data["rejected_fixes"][-1]) == 0


CONSTANT_ERRORS: Final = {
    "body_velocity.rate": 1.0,
    **{f"{part}.body_velocity.scale_sigma": 0.02 for part in ("plant", "filter")},
    **{f"{part}.body_velocity.boresight_sigma": ["0 deg", "1 deg", "1 deg"] for part in ("plant", "filter")},
    "heading_aid.rate": 1.0,
    "plant.heading_aid.bias_sigma": "3 deg",
    "filter.prior.heading_aid_bias_sigma": "3 deg",
    "heading_aid.noise_sigma": "1 deg",
    "measurement.heading_aid_sigma": "1 deg",
    "height_aid.rate": 1.0,
    "plant.height_aid.bias_sigma": 30.0,
    "filter.prior.height_aid_bias_sigma": 30.0,
    "measurement.height_aid_sigma": 1.0,
    "height_aid.noise_sigma": 1.0,
}
PRIOR: Final = {
    "aid.body_velocity.scale": 0.02,
    "aid.heading_aid.bias": 3.0 * DEGREE,
    "aid.height_aid.bias": 30.0,
}


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.parametrize("model", ["invariant", "10 states"])
def test_what_sensors_are_constantly_off_by_is_found_beside_fixes(model: str, seed: int, fmus: Fmus) -> None:
    data = run(300.0, fmus, seed, **{**CONSTANT_ERRORS, **MODELS[model]})
    assert certainty.of_run(data).wrongly < 2.0
    found = {name: float(data[name][-1]) for name in PRIOR}
    sigma = {name: float(data[f"{name}_sigma"][-1]) for name in PRIOR}
    true = errors_drawn(seed, fmus)
    for name, prior in PRIOR.items():
        if model == "10 states" and name == "aid.height_aid.bias":
            continue  # it has no height beside fixes
        assert sigma[name] < 0.5 * prior, name
        assert abs(found[name] - true[name]) < 4.0 * sigma[name], name


def errors_drawn(seed: int, fmus: Fmus) -> dict[str, float]:
    """What the sensors are off by: measurements of the plant without noise, beside the truth."""
    silent = {f"plant.{aid}.noise_sigma": 0.0 for aid in ("body_velocity", "heading_aid", "height_aid")}
    settings = {name.removeprefix("plant."): value for name, value in CONSTANT_ERRORS.items()}
    own = {f"plant.{name}": value for name, value in settings.items() if fmus.plant.has_parameter(name)}
    plant = load_scenario("swaying_ship", fmus, seed=seed, settings={**own, **silent}).plant
    with closing(Instance(fmus.plant, "plant", plant)) as instance:
        instance.begin_initialisation(0.0, 10.0)
        instance.finish_initialisation()
        instance.step(0.0, 1.0)
        names = [f"body_velocity.velocity[{i}]" for i in (1, 2, 3)] + [
            f"truth.velocity[{i}]" for i in (1, 2, 3)
        ]
        velocities = np.array(instance.read(names)).reshape(2, 3)
        names = ["heading_aid.heading", "truth.heading", "height_aid.height", "truth.height"]
        heading, true_heading, height, true_height = instance.read(names)
    measured, true = np.linalg.norm(velocities, axis=1)
    return {
        "aid.body_velocity.scale": measured / true - 1.0,
        "aid.heading_aid.bias": float(wrap(heading - true_heading)),
        "aid.height_aid.bias": height - true_height,
    }


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_compass_that_is_constantly_off_makes_no_filter_wrongly_sure(
    told: bool, seed: int, fmus: Fmus
) -> None:
    """As it did for 473 s of 473 s."""
    settings = {"plant.heading_aid.bias_sigma": "3 deg"}
    if told:
        settings["filter.prior.heading_aid_bias_sigma"] = "3 deg"
    data = run(600.0, fmus, seed, "compass_start", **settings)
    how_sure = certainty.of_run(data)
    if told:
        assert how_sure.wrongly < 2.0
        assert bool(data["converged"][-1])
    else:
        assert how_sure.longest < 60.0
        off = at(data, 600.0, "heading_error") > 3.0 * at(data, 600.0, "heading_sigma")
        assert not (off and bool(data["converged"][-1]))


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_filter_on_a_log_alone_finds_back_from_a_gyro_that_was_wrong(axis: int, fmus: Fmus) -> None:
    """Twenty seconds of 0.05 rad/s too much, a turn of 57 deg, and no fix to say so.

    About up the log agrees with what is false, and the way back takes the longest; the sigma is not honest
    then, and the filter says so.
    """
    fault = {"kind": "bias_step", "begin": 400.0, "duration": 20.0, "size": 0.05, "axis": axis}
    data = run(
        1500.0, fmus, 2, "dvl_alignment", **{f"fault.imu.{name}": value for name, value in fault.items()}
    )
    assert certainty.of_run(data).longest < 10.0
    assert at(data, 1500.0, "heading_error") < 2.0 * DEGREE
    right = at(data, 1500.0, "heading_error") < 3.0 * at(data, 1500.0, "heading_sigma")
    assert right or not bool(data["converged"][-1])
    assert right or axis == 3


def test_measurements_that_cannot_be_are_refused_with_the_reason(fmus: Fmus) -> None:
    data = run(20.0, fmus, **{"height_aid.rate": 1.0, "height_aid.bias_sigma": 1e7})
    assert int(data["aid.height_aid.used"][-1]) == 0
    assert int(data["aid.height_aid.rejected"][-1]) == 20
    assert "height_aid 1 (height_aid.time = 1 s) rejected" in str(data.attrs)
