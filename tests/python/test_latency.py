"""A fix that arrives late is compared with the state as it was: waves, a lever arm, a fix a second old."""

from __future__ import annotations

import numpy as np
import pytest

import sim_scenarios
from sim_scenarios.fmus import Fmus

SETTINGS = {
    "gnss.velocity_sigma": 0.02,
    "measurement.velocity_sigma": 0.02,
    "plant.gnss.lever_arm": [5.0, 10.0, 3.0],
    "filter.gnss.lever_arm": [5.0, 10.0, 3.0],
}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("feedback", [True, False])
def test_a_late_fix_is_as_good_as_a_prompt_one(fmus: Fmus, seed: int, feedback: bool) -> None:
    """Both runs see the same noise; they may differ by a small part of what the filter says of itself."""
    prompt, late = (
        sim_scenarios.run(
            "waves", seed=seed, set={**SETTINGS, "feedback": feedback, "gnss.latency": latency}, fmus=fmus
        )
        for latency in (0.0, 1.0)
    )
    window = slice(300.0, 600.0)
    difference = (late["heading_error"] - prompt["heading_error"]).sel(time=window).values
    sigma = prompt["heading_sigma"].sel(time=window).values
    assert np.sqrt(np.mean(difference**2)) < 0.3 * np.sqrt(np.mean(sigma**2))
    assert int(late["rejected_fixes"][-1]) == 0
