"""The container FMU against the co-simulation master: the same results to the last bit."""

from __future__ import annotations

import platform

import numpy as np
import pytest

from sim_scenarios import provenance
from sim_scenarios.container import obstacle
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.runner import why_no_container
from sim_scenarios.stepping import Master
from sim_scenarios.studies.case import Case
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.runs import Bench

supported = pytest.mark.skipif(
    obstacle(0.1, 1.0) is not None, reason=f"no container for {platform.system()} {platform.machine()}"
)


def case_of(fmus: Fmus, scenario: str, **settings: object) -> Case:
    short = {"duration": 45.0, "evaluation.start": 20.0, **settings}
    (case,) = cases(load_plan(scenario, set=short), fmus)
    return case


@supported
@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("swaying_ship", {"duration": 600.0, "evaluation.start": 300.0}),
        ("gnss_outliers", {"gnss.rate": 10.0}),  # a fix at every recorded instant
        ("waves", {"gnss.latency": 0.35, "plant.gnss.lever_arm": [0.5, 2.0, 8.0]}),
        ("flight_loose_tight", {}),  # the NavigationFilter, with its Boolean signals
        ("parked_vehicle", {"communication_step": 0.02, "recording_period": 0.2}),
    ],
)
def test_the_container_gives_the_results_of_the_master(
    fmus: Fmus, scenario: str, settings: dict[str, object]
) -> None:
    case = case_of(fmus, scenario, **settings)
    attributes = provenance.attributes(case.scenario, fmus)
    period = 10 * case.scenario.recording_period
    master, container = (
        Bench(period, master, fmus).run(case, 5, attributes) for master in (Master.python, Master.container)
    )
    assert container.state == master.state
    for label, values in master.kept.items():
        assert np.isfinite(values["heading_rmse"])
        for name, value in values.items():
            np.testing.assert_array_equal(container.kept[label][name], value, err_msg=f"{label}: {name}")


@supported
def test_more_fixes_than_recorded_instants_are_for_the_master(fmus: Fmus) -> None:
    case = case_of(fmus, "waves", **{"gnss.rate": 20.0})
    assert "20 fixes a second" in str(why_no_container(case.scenario, fmus))
    assert not Bench(1.0, Master.auto, fmus).runner.uses_container(case.scenario)
    with pytest.raises(InputError, match="waves cannot run in a container: 20 fixes"):
        Bench(1.0, Master.container, fmus).runner.uses_container(case.scenario)
