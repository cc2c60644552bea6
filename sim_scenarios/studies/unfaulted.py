"""What a case with a fault of the plant (`fault.*`) is held against: the same without it, a case too.

There is one for all faults of a scenario, and it runs first.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

from sim_scenarios import faults
from sim_scenarios.fmus import Fmus
from sim_scenarios.studies.case import Case


def held_against_unfaulted(made: Sequence[Case], fmus: Fmus) -> list[Case]:
    """The cases, and before them what those with faults are held against.

    Cases that differ in nothing but faults and length are held against one, as long as the longest of them.
    """
    groups: dict[str, list[Case]] = {}
    for case in made:
        groups.setdefault(_without_faults(case), []).append(case)
    faults_in = {key: [case for case in group if _has_fault(case, fmus)] for key, group in groups.items()}
    names = [faulted[0].scenario.name for faulted in faults_in.values() if faulted]
    added: list[Case] = []
    clean: dict[str, str] = {}
    for key, faulted in faults_in.items():
        if not faulted:
            continue
        longest = max(faulted, key=lambda case: case.scenario.duration)
        labels = [case.label for case in faulted]
        there = [
            case.label
            for case in groups[key]
            if case.label not in labels and case.scenario.duration >= longest.scenario.duration
        ]
        if not there:
            alone = names.count(longest.scenario.name) == 1
            added.append(_unfaulted(longest, longest.scenario.name if alone else longest.label))
            there = [added[-1].label]
        clean |= dict.fromkeys(labels, there[0])
    return [*added, *(replace(case, unfaulted=clean.get(case.label)) for case in made)]


def _without_faults(case: Case) -> str:
    """What cases share that differ in nothing but faults and length."""
    scenario = case.scenario.model_dump(mode="json", exclude={"notes", "duration", "evaluation"})
    content = {
        "source": case.source,
        "scenario": {**scenario, "plant": faults.without(scenario["plant"])},
        "draws": [repr(one) for one in case.draws if not faults.concerns(one.name)],
    }
    return json.dumps(content, sort_keys=True)


def _has_fault(case: Case, fmus: Fmus) -> bool:
    drawn = any(faults.concerns(one.name) and one.name.endswith(".kind") for one in case.draws)
    return drawn or faults.end(case.scenario.plant, fmus.plant) is not None


def _unfaulted(case: Case, of: str) -> Case:
    """The same case without the faults of its plant."""
    scenario = case.scenario.model_copy(update={"plant": faults.without(case.scenario.plant)})
    settings = {name: value for name, value in case.settings.items() if not faults.concerns(name)}
    draws = tuple(one for one in case.draws if not faults.concerns(one.name))
    return Case(f"{of} unfaulted", case.source, settings, scenario, draws)
