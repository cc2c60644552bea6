"""A filter whose model is the plant's tells how wrong it is: NEES of the loosely coupled filter."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.studies import execution
from sim_scenarios.studies.ensemble import ensemble
from sim_scenarios.studies.execution import Workers

RUNS, STATES = 12, 12
INSTANTS = (60, 150)  # [s], before and in a turn
SOONER = {"duration": 150.0, "evaluation.stop": 150.0, "motion.segment.duration[1]": 100.0}


@pytest.fixture(scope="module")
def workers(fmus: Fmus) -> Iterator[Workers]:  # noqa: ARG001  (there must be FMUs)
    with execution.workers(None, None) as found:
        yield found


@pytest.mark.parametrize("first", [1, 1001])
def test_nees_of_the_loose_filter(workers: Workers, first: int) -> None:
    """In its 99.9 % interval at each of two instants: one such test in 500 fails by chance."""
    runs = ensemble(workers, "flight_constant_speed", range(first, first + RUNS), ["EKF"], SOONER)
    lower, upper = chi_square_interval(RUNS * STATES, confidence=0.999)
    nees = [run["nees"].sel(time=list(INSTANTS), method="nearest").values for run in runs.filters["EKF"]]
    total = STATES * np.sum(nees, axis=0)
    assert ((lower < total) & (total < upper)).all(), total
