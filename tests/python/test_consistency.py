"""A filter whose model is the plant's tells how wrong it is: NEES of the loosely coupled filter."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.studies import execution
from sim_scenarios.studies.ensemble import ensemble
from sim_scenarios.studies.execution import Workers

Array = NDArray[np.float64]

RUNS, STATES = 12, 12
INSTANTS = (60, 150)  # [s], before and in a turn
SOONER = {"duration": 150.0, "evaluation.stop": 150.0, "motion.segment.duration[1]": 100.0}
FIXES: dict[str, dict[str, object]] = {
    "positions alone": {"gnss.measures_velocity": False},
    "velocities alone": {"gnss.measures_position": False},
    "no height": {"gnss.measures_position[3]": False},
    "sigmas of each": {
        "gnss.reports_sigma": True,
        "gnss.noise_scale.step.factor": 6.0,
        "gnss.noise_scale.step.begin": 20.0,
        "gnss.noise_scale.step.end": 100.0,
    },
}


@pytest.fixture(scope="module")
def workers(fmus: Fmus) -> Iterator[Workers]:  # noqa: ARG001  (there must be FMUs)
    with execution.workers(None, None) as found:
        yield found


def total_nees(workers: Workers, first: int, settings: dict[str, object]) -> Array:
    """Sum over all runs and states at each of two instants."""
    runs = ensemble(workers, "flight_constant_speed", range(first, first + RUNS), ["EKF"], SOONER | settings)
    nees = [run["nees"].sel(time=list(INSTANTS), method="nearest").values for run in runs.filters["EKF"]]
    total: Array = STATES * np.sum(nees, axis=0)
    return total


@pytest.mark.parametrize("first", [1, 1001])
def test_nees_of_the_loose_filter(workers: Workers, first: int) -> None:
    """In its 99.9 % interval at each of two instants: one such test in 500 fails by chance."""
    lower, upper = chi_square_interval(RUNS * STATES, confidence=0.999)
    total = total_nees(workers, first, {})
    assert ((lower < total) & (total < upper)).all(), total


@pytest.mark.parametrize("fixes", FIXES)
def test_nees_with_fixes_that_do_not_have_everything(workers: Workers, fixes: str) -> None:
    """In its 95 % interval at the end, with the first seeds."""
    lower, upper = chi_square_interval(RUNS * STATES)
    total = total_nees(workers, 1, FIXES[fixes])[-1]
    assert lower < total < upper
