"""What made a data set, and how it is judged: the attributes that every run of a scenario carries."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence

from sim_scenarios.connection import parameter
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Fmus, Number
from sim_scenarios.instance import Message
from sim_scenarios.scenario import Scenario
from sim_scenarios.version import product_version


def attributes(scenario: Scenario, fmus: Fmus, messages: Sequence[Message] = ()) -> dict[str, str | float]:
    """What made a data set, and how to judge it."""
    window = scenario.evaluation
    plant, filter_fmu = fmus.plant, fmus[scenario.filter_fmu]
    settings = {"plant": _readable(scenario.plant, plant), "filter": _readable(scenario.filter, filter_fmu)}
    if scenario.alignment is not None:
        settings["alignment"] = _readable(scenario.alignment, fmus[ALIGNMENT_FILTER])
    for moved_by in (scenario.trajectory, scenario.waypoints):
        if moved_by is not None:
            settings["vehicle"] = {name: str(value) for name, value in moved_by.model_dump().items()}
    return {
        "scenario": scenario.name,
        "description": scenario.description,
        "notes": scenario.notes,
        "seed": int(parameter(scenario, plant, "seed")),
        "duration": scenario.duration,
        "communication_step": scenario.communication_step,
        "evaluation.start": window.start,
        "evaluation.stop": min(window.stop, scenario.duration),
        "evaluation.heading_limit": window.heading_limit,
        "evaluation.horizontal_limit": _horizontal_limit(scenario, plant),
        "filter_fmu": scenario.standard,
        "settings": json.dumps(settings),
        "filters": json.dumps(
            {k: _readable(v, fmus[scenario.fmu_of(k)]) for k, v in scenario.filters().items()}
        ),
        "versions": json.dumps(
            {
                "truenorth": product_version() or "not installed (checkout)",
                **{name: fmus[name].version for name in scenario.fmu_names()},
            }
        ),
        "messages": json.dumps([str(message) for message in messages]),
    }


def _horizontal_limit(scenario: Scenario, plant: Fmu) -> float:
    """Horizontal RMSE up to which a filter navigates [m]: of a single fix, or as the scenario has it."""
    if scenario.evaluation.horizontal_limit is not None:
        return scenario.evaluation.horizontal_limit
    return math.hypot(*(float(parameter(scenario, plant, f"gnss.position_sigma[{i}]")) for i in (1, 2)))


def _readable(values: Mapping[str, Number], fmu: Fmu) -> dict[str, str]:
    return {name: fmu.variables[name].display(value) for name, value in values.items()}
