"""What a filter has found in ten minutes it still knows after an hour, and after a day."""

from __future__ import annotations

import numpy as np
import pytest

import sim_scenarios
from sim_scenarios.fmus import Fmus

HOUR, DAY = 3600.0, 86400.0


def errors(fmus: Fmus, duration: float, seed: int, **settings: object) -> tuple[float, float]:
    """RMS of heading error and of its sigma over the last twelfth [arcmin]."""
    data = sim_scenarios.run(
        "swaying_ship",
        seed=seed,
        set={
            "duration": duration,
            "evaluation.start": duration * 11 / 12,
            "evaluation.stop": duration,
            "communication_step": 0.1,
            "recording_period": 1.0,
            **settings,
        },
        fmus=fmus,
    ).squeeze()
    late = data.sel(time=slice(duration * 11 / 12, None))
    arcmin = 60 * 180 / np.pi
    return (
        float(np.sqrt(np.mean(late["heading_error"].values ** 2))) * arcmin,
        float(np.sqrt(np.mean(late["heading_sigma"].values ** 2))) * arcmin,
    )


@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("scaling", ["printed", "rate_invariant", "ceiling"])
def test_h_infinity_knows_its_heading_after_an_hour(scaling: str, seed: int, fmus: Fmus) -> None:
    error, sigma = errors(fmus, HOUR, seed, **{"robust.scaling": scaling})
    assert error < 3 * sigma
    assert sigma < 25.0  # 16 after ten minutes


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("scaling", ["printed", "rate_invariant", "ceiling"])
def test_h_infinity_knows_its_heading_after_a_day(scaling: str, seed: int, fmus: Fmus) -> None:
    error, sigma = errors(fmus, DAY, seed, **{"robust.scaling": scaling})
    assert error < 3 * sigma
    assert sigma < 25.0
