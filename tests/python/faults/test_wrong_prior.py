"""A filter that was told a lie about its start says so, or is not converged, or is right all the same."""

from __future__ import annotations

import numpy as np
import pytest
from test_imu_and_clocks import longest, wrongly_sure
from wire import STATUS, run

from sim_scenarios.fmus import Fmus

DRAWS = 12


def lie(seed: int) -> dict[str, object]:
    """Errors of 8 to 20 of the sigmas that are told, of tilt, heading and velocity, one of them or all."""
    rng = np.random.default_rng(seed)
    times = rng.uniform(8.0, 20.0)
    which = rng.integers(0, 3)
    heading, tilt = rng.uniform(0.02, 0.3), rng.uniform(0.002, 0.02)
    velocity = rng.uniform(0.5, 5.0)
    sigma = {
        "prior.heading_sigma": heading / times if which in (0, 2) else heading,
        "prior.tilt_sigma": tilt / times if which in (1, 2) else tilt,
        "prior.velocity_sigma": velocity / times if which == 2 else velocity,
    }
    sign = rng.choice([-1.0, 1.0], 3)
    return {
        "initial_error.misalignment": [tilt * sign[0], tilt * sign[1], heading * sign[2]],
        "initial_error.velocity": [velocity * sign[1], -velocity * sign[0], 0.0],
        "duration": 300.0,
        "evaluation.start": 200.0,
        "evaluation.stop": 300.0,
        **sigma,
    }


@pytest.mark.parametrize("scenario", ["waves", "zigzag"])
@pytest.mark.parametrize("model", ["large_azimuth", "invariant"])
@pytest.mark.parametrize("seed", range(DRAWS))
def test_a_lie_about_the_start_is_found_out(seed: int, model: str, scenario: str, fmus: Fmus) -> None:
    settings = {**lie(seed), "error_model": model, "corrector": "standard"}
    if model == "invariant":
        settings |= {"predictor": "linearised", "coarse.enabled": False}
    data = run(scenario, fmus, lambda _, __: None, seed=100 + seed, settings=settings)
    # Before that, what it was told is all that it knows.
    late = wrongly_sure(data)[data["time"].values > 120.0]
    assert longest(late, 0.1) <= 10.0


def test_the_attitude_gives_a_lie_away_that_no_innovation_shows(fmus: Fmus) -> None:
    """Heading wrong by 10 deg with a sigma of 1 deg: found slowly, and never believed."""
    settings = {"prior.heading_sigma": "1 deg", "corrector": "standard"}
    data = run("swaying_ship", fmus, lambda _, __: None, settings=settings)
    assert not wrongly_sure(data)[data["time"].values > 120.0].any()
    assert (data["status"].values[2000:] == STATUS["inconsistent"]).all()
    assert float(data["nis_mean"][-1]) < 1.3
