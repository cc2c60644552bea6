"""The corrector `combined` beside those that are each made for one disturbance: its regret on a few seeds."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.navigation import judge
from sim_scenarios.scenario import load_scenario
from sim_scenarios.simulation import run_filters

SEEDS = (1, 2, 3)
FILTERS: Mapping[str, Mapping[str, object]] = {
    "standard": {"corrector": "standard", "gate.enabled": False},
    "standard, gate": {"corrector": "standard", "gate.enabled": True},
    "IGG": {"corrector": "igg", "gate.enabled": False},
    "variational Bayes": {"corrector": "variational_bayes", "gate.enabled": False},
    "combined": {"corrector": "combined", "gate.enabled": True},
}
NOISE_X_6: Mapping[str, object] = {
    "gnss.noise_scale.step.factor": 6.0,
    "gnss.noise_scale.step.begin": 300.0,
    "gnss.noise_scale.step.end": 500.0,
}


def regrets(scenario: str, fmus: Fmus, **settings: object) -> dict[str, float]:
    """Horizontal RMSE of each filter by that of the best, over all seeds."""
    squares = dict.fromkeys(FILTERS, 0.0)
    for seed in SEEDS:
        given = {"duration": 600.0, "communication_step": 0.1, **settings}
        loaded = load_scenario(scenario, fmus, seed=seed, settings=given, compare=FILTERS)
        runs = run_filters(loaded, fmus, loaded.filters())
        for label in FILTERS:
            squares[label] += judge(runs.sel(filter=label)).horizontal ** 2
    best = min(squares.values())
    return {label: float(np.sqrt(square / best)) for label, square in squares.items()}


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("flight_nominal", {}),
        ("flight_nominal", NOISE_X_6),
        ("flight_outliers", {}),
        ("flight_outliers", NOISE_X_6),
        ("flight_accelerometer_fault", {}),
    ],
)
def test_it_is_near_the_best(scenario: str, settings: Mapping[str, object], fmus: Fmus) -> None:
    assert regrets(scenario, fmus, **settings)["combined"] < 1.25  # of three seeds


def test_the_gate_alone_is_lost_when_noise_grows(fmus: Fmus) -> None:
    assert regrets("flight_nominal", fmus, **NOISE_X_6)["standard, gate"] > 3.0
