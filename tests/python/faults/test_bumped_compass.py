"""A compass that is bumped under way: by how much it is off is found once more."""

from __future__ import annotations

import numpy as np
import pytest
from wire import Wire, run

from sim_scenarios.attitude import wrap
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import certainty

DEGREE = np.pi / 180.0
BUMPED_AT, BUMP = 200.0, 20.0 * DEGREE


class Bumped:
    """The fault: what is on the wire stays there until the next measurement, and is turned once."""

    def __init__(self) -> None:
        self.number = 0.0

    def __call__(self, time: float, wire: Wire) -> None:
        if time > BUMPED_AT and wire["heading_aid.sample"] != self.number:
            self.number = wire["heading_aid.sample"]
            wire["heading_aid.heading"] = float(wrap(wire["heading_aid.heading"] + BUMP))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_compass_that_is_bumped_is_refused_and_then_learned_anew(seed: int, fmus: Fmus) -> None:
    settings = {
        "error_model": "invariant",
        "predictor": "linearised",
        "corrector": "standard",
        "coarse.enabled": False,
        "heading_aid.rate": 1.0,
        "heading_aid.noise_sigma": "0.5 deg",
        "prior.heading_aid_bias_sigma": "10 deg",
    }
    data = run("swaying_ship", fmus, Bumped(), seed=seed, settings=settings)
    assert certainty.of_run(data).wrongly < 2.0
    bias, sigma = data["aid.heading_aid.bias"], data["aid.heading_aid.bias_sigma"]
    before = data["aid.heading_aid.rejected"].sel(time=BUMPED_AT, method="nearest")
    assert 20 <= int(data["aid.heading_aid.rejected"][-1]) - int(before) <= 60
    assert int(data["aid.heading_aid.used"][-1]) > 500
    assert abs(float(bias[-1]) - BUMP) < 4.0 * float(sigma[-1]) < 2.0 * DEGREE
