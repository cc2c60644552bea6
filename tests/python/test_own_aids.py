"""What a filter knows of its motion without a sensor: standstill, and wheels that do not slip."""

from __future__ import annotations

from contextlib import ExitStack, closing
from typing import Any, Final

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.connection import filter_values, initial_values, start_plant
from sim_scenarios.fmus import NAVIGATION_FILTER, Fmus, Number
from sim_scenarios.instance import Instance, Port
from sim_scenarios.scenario import load_scenario

DEGREE: Final = np.pi / 180.0
STANDING: Final[dict[str, Any]] = {"standstill.velocity_sigma": 0.02, "standstill.rate_sigma": "10 deg/h"}
AS_OF_A_CAR: Final[dict[str, Any]] = {"standstill.rate_deviation": 0.03, "standstill.force_deviation": 0.1}
"""What an engine that runs makes of a car that stands."""


def run(scenario: str, fmus: Fmus, duration: float, seed: int = 1, **settings: Any) -> xr.Dataset:
    window = {"evaluation.start": 0.5 * duration, "evaluation.stop": duration}
    return sim_scenarios.run(scenario, seed=seed, set={"duration": duration, **window, **settings}, fmus=fmus)


def horizontal(data: xr.Dataset, time: float) -> float:
    return float(np.hypot(*data["position_error"].sel(time=time, method="nearest").values[:2]))


@pytest.fixture(scope="module")
def town(fmus: Fmus) -> dict[int, xr.Dataset]:
    """The comparison that is shipped, to the end of the outage, for some seeds."""
    return {
        seed: sim_scenarios.compare("car_odometer", seed=seed, set={"duration": 221.0}, fmus=fmus)
        for seed in range(1, 9)
    }


def test_an_odometer_carries_a_car_through_an_outage(town: dict[int, xr.Dataset]) -> None:
    """At most a tenth of the error without, RMS of the seeds; each within what its filter says."""
    ends: dict[str, list[float]] = {}
    for data in town.values():
        for label in data["filter"].values:
            end = data.sel(filter=label)
            ends.setdefault(str(label), []).append(horizontal(end, 220.0))
            assert int(end["rejected_fixes"][-1]) == 0
    rms = {label: float(np.sqrt(np.mean(np.square(found)))) for label, found in ends.items()}
    assert rms["with all of them"] < 0.1 * rms["without"]
    assert rms["with all of them"] <= rms["odometer alone"]


@pytest.mark.parametrize("label", ["with all of them", "without a standstill"])
def test_the_sigmas_of_the_car_are_honest(label: str, town: dict[int, xr.Dataset]) -> None:
    for data in town.values():
        one = data.sel(filter=label)
        off = np.abs(one["position_error"].values) / one["position_sigma"].values
        assert np.mean(off[60:] < 3.0) > 0.97
        assert float(one["aid.nonholonomic.nis_mean"][-1]) < 1.5
        assert int(one["aid.nonholonomic.rejected"][-1]) <= 1


def test_a_stop_is_seen_within_seconds_and_nothing_else_is(town: dict[int, xr.Dataset]) -> None:
    """The car stands until 30 s, from 89 s to 104 s, and from 191 s to 203 s in the outage."""
    for data in town.values():
        one = data.sel(filter="with all of them")
        time = one["time"].values
        detected = one["aid.standstill.detected"].values.astype(bool)
        stands = np.zeros(len(time), bool)
        late = np.zeros(len(time), bool)
        for begin, end in ((0.0, 30.0), (89.0, 104.0), (191.0, 203.0)):
            stands |= (time >= begin - 0.2) & (time <= end + 1.5)  # the last window ends in the first second
            late |= (time >= begin + 4.0) & (time <= end)
        assert not np.any(detected & ~stands)
        assert np.mean(detected[late]) > 0.9
        assert int(one["aid.standstill.used"][-1]) >= 45


@pytest.mark.parametrize("speed", [0.0, 10.0])
@pytest.mark.parametrize("told", [{}, AS_OF_A_CAR], ids=["quiet", "as of a car"])
def test_a_swaying_ship_never_stands(speed: float, told: dict[str, Any], fmus: Fmus) -> None:
    """Ten minutes, moored and under way; the estimate is not asked."""
    settings: dict[str, Any] = {**STANDING, **told, "standstill.largest_speed": 1e3, "motion.speed": speed}
    data = run("swaying_ship", fmus, 600.0, **settings)
    assert not data["aid.standstill.detected"].values.any()
    for aid in ("standstill", "standstill_rate"):
        assert int(data[f"aid.{aid}.used"][-1]) == int(data[f"aid.{aid}.rejected"][-1]) == 0


@pytest.mark.parametrize("speed", [1.0, 20.0])
def test_a_smooth_cruise_is_never_taken_for_standing(speed: float, fmus: Fmus) -> None:
    """Two minutes with fixes and three without, at a constant velocity that no shake tells from a stop."""
    settings: dict[str, Any] = {
        "body_velocity.rate": 0.0,
        "motion.speed": speed,
        "motion.segment.duration": 16 * [0.0],
        "gnss.outage.begin[1]": 120.5,
        "gnss.outage.end[1]": 1e9,
    }
    data = run("car_odometer", fmus, 300.0, **settings)
    assert not data["aid.standstill.detected"].values.any()
    assert int(data["aid.standstill.used"][-1]) == 0


ALIGNMENTS: Final[dict[str, dict[str, Any]]] = {
    "large_azimuth": {},
    "euler_platform": {"error_model": "euler_platform"},
    "euler_platform_large_azimuth": {"error_model": "euler_platform_large_azimuth"},
    "euler_platform_small": {"error_model": "euler_platform_small"},
    "invariant": {"error_model": "invariant", "predictor": "linearised", "coarse.enabled": False},
}
STILL: Final[dict[str, Any]] = {
    "motion.vibration.angle": [0.0, 0.0, 0.0],
    "motion.vibration.acceleration": [0.0, 0.0, 0.0],
}
"""A base at rest, for models that are for no other."""
NO_BIAS: Final[dict[str, Any]] = {"imu.gyro.bias_sigma": 0.0, "imu.accelerometer.bias_sigma": 0.0}
NO_FIX: Final[dict[str, Any]] = {"gnss.outage.begin[1]": -1e9, "gnss.outage.end[1]": 1e9}


@pytest.mark.parametrize("model", ALIGNMENTS)
def test_every_model_of_an_alignment_stands_without_fixes(model: str, fmus: Fmus) -> None:
    """A parked vehicle that shakes: what zero-velocity fixes are for elsewhere, the filter knows itself."""
    shaken: dict[str, Any] = {"standstill.rate_deviation": 0.002, "standstill.force_deviation": 0.03}
    start: dict[str, Any] = {
        "initial_error.misalignment": ["0.1 deg", "0.1 deg", "2 deg"],
        "prior.heading_sigma": "2 deg",
        "prior.velocity_sigma": 0.1,
        "motion.settle.angle": [0.0, 0.0],  # it would turn, by degrees per hour
        **(STILL if model.startswith("euler") else {}),
    }
    settings: dict[str, Any] = {
        **ALIGNMENTS[model],
        **NO_FIX,
        **start,
        **shaken,
        "standstill.velocity_sigma": 0.02,
        "standstill.rate_sigma": "1 deg/h",
    }
    data = run("parked_vehicle", fmus, 120.0, **settings)
    free = run("parked_vehicle", fmus, 120.0, **{**ALIGNMENTS[model], **NO_FIX, **start})
    assert int(data["aid.standstill.used"][-1]) >= 110
    assert int(data["aid.standstill.rejected"][-1]) == 0
    used = int(data["aid.standstill_rate.used"][-1])
    assert used == 0 if model.startswith("euler") else used >= 110
    bound, drifted = (np.abs(run["velocity_error"].values[-1, :2]).max() for run in (data, free))
    assert bound < 0.02
    assert drifted > 5.0 * bound
    assert float(np.abs(data["heading_error"][-1])) < 3.0 * float(data["heading_sigma"][-1])


@pytest.mark.parametrize("model", ["loose", "full_state", "tight", "invariant"])
def test_every_model_of_a_navigation_stands_and_rolls_without_fixes(model: str, fmus: Fmus) -> None:
    """The car before it starts, and on its first hundred metres."""
    sensors = NO_BIAS if model == "full_state" else {}  # which has no states for them
    data = run("car_odometer", fmus, 80.0, **NO_FIX, **sensors, error_model=model, predictor="unscented")
    assert int(data["aid.standstill.used"][-1]) >= 25
    used = int(data["aid.standstill_rate.used"][-1])
    assert used == 0 if model == "full_state" else used >= 25
    assert int(data["aid.nonholonomic.used"][-1]) >= 75
    assert float(np.abs(data["velocity_error"].sel(time=30.0, method="nearest")).max()) < 0.02
    assert float(np.abs(data["velocity_error"][-1]).max()) < 0.5


def test_zero_rotation_tells_the_gyro_biases(fmus: Fmus) -> None:
    """Within the half minute before the car starts; the closed form of a constant in white noise."""
    data = run("car_odometer", fmus, 30.0)
    noise = np.hypot(10.0 * DEGREE / 3600.0, 0.2 * DEGREE / 60.0)  # of the mean of a second [rad/s]
    count = int(data["aid.standstill_rate.used"][-1])
    expected = ((30.0 * DEGREE / 3600.0) ** -2 + count * noise**-2) ** -0.5
    sigma = data["gyro_bias_sigma"].values[-1]
    assert count >= 27
    np.testing.assert_allclose(sigma[2], expected, rtol=0.01)
    assert np.all(sigma[:2] < expected)  # the tilts that level ones make are seen besides
    assert np.all(np.abs((data["gyro_bias"] - data["truth.gyro_bias"]).values[-1]) < 4.0 * sigma)


def test_a_state_carries_a_standstill_bit_for_bit(fmus: Fmus) -> None:
    """Saved in the middle of a window of a car that stands, and gone on with from there twice."""
    scenario = load_scenario("car_odometer", fmus)
    known = fmus[NAVIGATION_FILTER]
    outputs = known.outputs()
    with ExitStack() as stack:
        plant = start_plant(scenario, fmus, stack)
        truth = [name for name in fmus.plant.outputs() if name.startswith("truth.")]
        start = initial_values(scenario, fmus.plant, dict(zip(truth, plant.read(truth), strict=True)))
        told = filter_values(known, start, scenario.filter)
        one, other = (stack.enter_context(closing(Instance(known, n, told))) for n in ("one", "other"))
        for instance in (one, other):
            instance.begin_initialisation(0.0, 40.0)
            instance.finish_initialisation()
        names = [name for name in known.inputs() if name in set(fmus.plant.outputs())]
        source = Port(plant, names)
        sinks = {instance: Port(instance, names) for instance in (one, other)}

        def step(k: int, *filters: Instance) -> list[list[Number]]:
            plant.step(0.01 * k, 0.01)
            source.read()
            for instance in filters:
                sinks[instance].signals.assign([source.signals.value(name) for name in names])
                sinks[instance].write()
                instance.step(0.01 * k, 0.01)
            return [instance.read(outputs) for instance in filters]

        for k in range(1042):
            step(k, one)
        assert one.read(["aid.standstill.detected"]) == [1]
        other.restore(one.state())
        used = one.read(["aid.standstill.used"])[0]
        for k in range(1042, 1500):
            first, second = step(k, one, other)
            assert first == second, k
        assert one.read(["aid.standstill.used"])[0] >= used + 4
