"""Aids that fail, with and without fixes: what they spoil, and whether the filter comes back.

Each fault is on the wire between plant and filter, on the ship of `dvl_alignment` or `swaying_ship`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import pytest
import xarray as xr
from wire import STATUS, Fault, Wire, run

from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import certainty

DEGREE: Final = np.pi / 180.0
FAILS_AT: Final = 300.0
LOG: Final = {
    "error_model": "invariant",
    "predictor": "linearised",
    "corrector": "standard",
    "body_velocity.rate": 1.0,
    "body_velocity.noise_sigma": 0.05,
    "measurement.body_velocity_sigma": 0.05,
}


class OfAnAid:
    """Changes each measurement of an aid once, from a time on; it stays on the wire until the next."""

    def __init__(self, aid: str, change: Callable[[Wire], None], begin: float = FAILS_AT) -> None:
        self.sample, self.change, self.begin = f"{aid}.sample", change, begin
        self.number = 0.0

    def __call__(self, time: float, wire: Wire) -> None:
        if time > self.begin and wire[self.sample] != self.number:
            self.number = wire[self.sample]
            self.change(wire)


def nothing(time: float, wire: Wire) -> None:
    """No fault."""


def on_the_log(fmus: Fmus, fault: Fault, seed: int, duration: float = 600.0, **settings: Any) -> xr.Dataset:
    window = {"evaluation.start": 0.5 * duration, "evaluation.stop": duration}
    everything = {"duration": duration, **window, **settings}
    return run("dvl_alignment", fmus, fault, seed=seed, settings=everything)


def at(data: xr.Dataset, time: float, name: str) -> float:
    return float(data[name].sel(time=time, method="nearest"))


@pytest.mark.parametrize("behind", [18.0, 3600.0])
def test_a_log_whose_clock_is_behind_from_the_beginning_is_used(behind: float, fmus: Fmus) -> None:
    """Of a log in UTC beside an IMU in GPS time, or one that counts from its own start."""

    def shift(wire: Wire) -> None:
        wire["body_velocity.time"] -= behind

    data = on_the_log(fmus, OfAnAid("body_velocity", shift, begin=0.0), seed=1, duration=300.0)
    assert int(data["aid.body_velocity.used"][-1]) >= 295
    assert abs(at(data, 300.0, "heading_error")) < 3.0 * at(data, 300.0, "heading_sigma")


@pytest.mark.parametrize("seed", [1, 2])
def test_a_barometer_in_the_wrong_datum_does_not_spoil_the_position_on_a_log(seed: int, fmus: Fmus) -> None:
    """47 m too high, as a geoid is, from 300 s on; before, there was no barometer."""

    class Connected(OfAnAid):
        def __call__(self, time: float, wire: Wire) -> None:
            if time <= FAILS_AT:
                wire["height_aid.sample"] = 0.0
            super().__call__(time, wire)

    def lift(wire: Wire) -> None:
        wire["height_aid.height"] += 47.0

    data = on_the_log(fmus, Connected("height_aid", lift), seed, **{"height_aid.rate": 1.0})
    clean = on_the_log(fmus, nothing, seed)
    assert int(data["aid.height_aid.rejected"][-1]) > 0
    assert int(data["aid.body_velocity.rejected"][-1]) == int(clean["aid.body_velocity.rejected"][-1])
    for run_ in (data, clean):
        assert (np.abs(run_["position_error"]) < 3.0 * run_["position_sigma"])[-1, :2].all()
    assert float((data["position_sigma"] / clean["position_sigma"])[-1, :2].max()) < 1.1
    assert abs(at(data, 600.0, "heading_error")) < 3.0 * at(data, 600.0, "heading_sigma")


def bump(angle: float) -> Callable[[Wire], None]:
    def turn(wire: Wire) -> None:
        wire["heading_aid.heading"] = float(wrap(wire["heading_aid.heading"] + angle))

    return turn


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("angle", [5.0, 20.0])
def test_a_compass_that_is_bumped_without_fixes_costs_no_log(angle: float, seed: int, fmus: Fmus) -> None:
    """Heading or compass, one of them is wrong; the velocity that a log has given turns with the heading."""
    fault = OfAnAid("heading_aid", bump(angle * DEGREE))
    compass = {"heading_aid.rate": 1.0, "heading_aid.noise_sigma": "0.5 deg"}
    data = on_the_log(fmus, fault, seed, duration=900.0, **compass)
    refused = data["aid.body_velocity.rejected"]
    before = int(refused.sel(time=FAILS_AT, method="nearest"))
    assert int(refused[-1]) - before <= 5
    assert certainty.of_run(data).longest < 10.0
    assert abs(at(data, 900.0, "heading_error")) < 3.0 * at(data, 900.0, "heading_sigma")


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("angle", [5.0, 20.0])
def test_a_compass_that_is_bumped_beside_fixes_comes_back(angle: float, seed: int, fmus: Fmus) -> None:
    """By more than it was said to be off (0.5 deg, the default): found, used again, and told."""
    compass = {"heading_aid.rate": 1.0, "heading_aid.noise_sigma": "0.5 deg", "coarse.enabled": False}
    fault = OfAnAid("heading_aid", bump(angle * DEGREE))
    data = run("swaying_ship", fmus, fault, seed=seed, settings={**LOG, "body_velocity.rate": 0.0, **compass})
    used = data["aid.heading_aid.used"]
    assert int(used[-1]) - int(used.sel(time=FAILS_AT, method="nearest")) > 200
    bias, sigma = (at(data, 600.0, f"aid.heading_aid.{name}") for name in ("bias", "bias_sigma"))
    assert abs(bias - angle * DEGREE) < 4.0 * sigma < 2.0 * DEGREE
    assert int(data["status"][-1]) == STATUS["inconsistent"]
    assert certainty.of_run(data).wrongly < 2.0


@pytest.mark.parametrize("enabled", [True, False])
def test_a_gap_of_the_imu_under_water_waits_for_no_fix(enabled: bool, fmus: Fmus) -> None:
    """Aligned with fixes, then on the log alone, then 15 s without IMU: the log goes on where it can."""
    settings = {
        **LOG,
        "coarse.enabled": enabled,
        "gnss.outage.begin[1]": 250.0,
        "gnss.outage.end[1]": 1e9,
        "fault.imu.kind": "silence",
        "fault.imu.begin": FAILS_AT,
        "fault.imu.duration": 15.0,
    }
    data = run("swaying_ship", fmus, nothing, seed=2, settings=settings)
    used = data["aid.body_velocity.used"]
    assert int(used[-1]) - int(used.sel(time=320.0, method="nearest")) > 200
    assert int(data["status"][-1]) != STATUS["coarse"]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("rate", [1.0, 100.0])
def test_a_heading_that_is_far_off_is_never_called_converged_on_a_log_alone(
    rate: float, seed: int, fmus: Fmus
) -> None:
    """A heading 50 deg off, known to 60 deg: what is not linear in it leaves sigmas too small, and tells."""
    far = {"initial_error.misalignment": [0.0, 0.0, "50 deg"], "prior.heading_sigma": "60 deg"}
    data = on_the_log(fmus, nothing, seed, duration=400.0, **{"body_velocity.rate": rate, **far})
    assert certainty.of_run(data).wrongly == 0.0
    assert STATUS["inconsistent"] in set(data["status"].values.tolist())
