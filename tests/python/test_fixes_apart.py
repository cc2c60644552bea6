"""Fixes that measure a part of position and velocity, and fixes that say how good they are."""

from __future__ import annotations

from typing import Final

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import chi_square_interval

POSITION: Final = "gnss.measures_position"
VELOCITY: Final = "gnss.measures_velocity"
SHORT: Final = {"duration": 200.0, "evaluation.start": 100.0, "evaluation.stop": 200.0}
LOOSE: Final = "flight_nominal"
INVARIANT: Final = "swaying_ship"
SCENARIOS: Final[dict[str, dict[str, object]]] = {
    LOOSE: {},
    INVARIANT: {
        "error_model": "invariant",
        "predictor": "linearised",
        "corrector": "standard",
        "coarse.enabled": False,
    },
}
ALIKE: Final = {LOOSE: (1e-6, 1e-4, 1e-6), INVARIANT: (1e-3, 1.5e-3, 1e-5)}
"""Differences of heading [rad], velocity [m/s] and the heading's sigma [rad]. The invariant model takes the
place of a fix for its velocity in inertial space: noise of 5 m is up to w_ie x 20 m there, unless the place
is not measured. Its covariance depends on the biases that it has found, and so on these."""


def run(scenario: str, fmus: Fmus, **settings: object) -> xr.Dataset:
    return sim_scenarios.run(scenario, set={**SHORT, **SCENARIOS[scenario], **settings}, fmus=fmus)


def largest(one: xr.Dataset, other: xr.Dataset, name: str) -> float:
    return float(np.abs(one[name].values - other[name].values).max())


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(
    ("absent", "blind"),
    [
        ({VELOCITY: False}, {"measurement.velocity_sigma": 1e5}),
        ({POSITION: False}, {"measurement.position_sigma": 1e7, "measurement.height_sigma": 1e7}),
        ({f"{POSITION}[3]": False}, {"measurement.height_sigma": 1e7}),
    ],
    ids=["velocity", "position", "height"],
)
def test_what_is_not_measured_is_as_good_as_what_is_measured_without_any_accuracy(
    scenario: str, absent: dict[str, object], blind: dict[str, object], fmus: Fmus
) -> None:
    """Two filters that must know the same: one is not told, the other is told nothing that counts."""
    without = run(scenario, fmus, **{"gate.enabled": False}, **absent)
    worthless = run(scenario, fmus, **{"gate.enabled": False}, **blind)
    assert int(without["used_fixes"][-1]) == 200
    heading, velocity, sigma = ALIKE[scenario]
    assert largest(without, worthless, "heading_error") < heading
    assert largest(without, worthless, "heading_sigma") < sigma
    assert largest(without, worthless, "velocity_error") < velocity
    assert largest(without, worthless, "velocity_sigma") < 1e-5


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_the_sigma_of_a_fix_stands_for_that_of_the_parameters(scenario: str, fmus: Fmus) -> None:
    wrong = {f"measurement.{name}_sigma": 77.0 for name in ("position", "height", "velocity")}
    told = run(scenario, fmus, **{"gnss.reports_sigma": True}, **wrong)
    right = run(scenario, fmus)
    assert largest(told, right, "heading_error") < 1e-9
    assert largest(told, right, "velocity_error") < 1e-9


@pytest.mark.parametrize("seed", [1, 2])
def test_sigmas_that_change_from_fix_to_fix_keep_the_innovations_consistent(seed: int, fmus: Fmus) -> None:
    """Six times the noise from 60 to 140 s, which the receiver tells; NIS within 99.9 %."""
    noise = {
        "gnss.noise_scale.step.factor": 6.0,
        "gnss.noise_scale.step.begin": 60.0,
        "gnss.noise_scale.step.end": 140.0,
        "gate.enabled": False,
        "seed": seed,
    }
    silent = run("flight_nominal", fmus, **noise)
    telling = run("flight_nominal", fmus, **noise, **{"gnss.reports_sigma": True})
    channels = float(telling["nis_channels"].sum())
    lower, upper = chi_square_interval(channels, 0.999)
    assert lower < float(telling["nis"].sum()) < upper
    assert float(silent["nis"].sum()) > 2.0 * upper


def test_a_receiver_without_velocity_cannot_feed_a_model_that_measures_nothing_else(fmus: Fmus) -> None:
    blind = sim_scenarios.run(
        "swaying_ship",
        set={"duration": 30.0, "evaluation.start": 0.0, "evaluation.stop": 30.0, VELOCITY: False},
        fmus=fmus,
    )
    assert int(blind["used_fixes"][-1]) == 0
    assert int(blind["rejected_fixes"][-1]) == 30
    assert "it measures nothing that the model can use" in str(blind.attrs)
