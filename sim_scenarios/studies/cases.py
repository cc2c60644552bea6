"""The cases of a campaign, checked against the FMUs."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Final

from sim_scenarios.catalogue import scenario_path
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus, did_you_mean
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.scenario.tables import MOTION
from sim_scenarios.studies.case import Case, filter_labels
from sim_scenarios.studies.draws import Draw, draw
from sim_scenarios.studies.expectations import Expectations, known_name
from sim_scenarios.studies.plan import NamedCase, Plan, Source, load_plan
from sim_scenarios.studies.quantities import SERIES, figures
from sim_scenarios.studies.unfaulted import held_against_unfaulted

MOST_CASES: Final = 10_000


def cases(plan: Plan, fmus: Fmus) -> list[Case]:
    """Every scenario with every named case and every combination of the grid; before faults, without them.

    Raises
    ------
    InputError
        Something cannot be run; under the name of the campaign's file, if that is to blame.
    """
    try:
        return _made(plan, fmus)
    except InputError as error:
        if plan.source is None or not _is_of_the_file(str(error), plan.source, fmus):
            raise
        raise InputError(f"{plan.source.path}: {error}") from None


def _is_of_the_file(said: str, source: Source, fmus: Fmus) -> bool:
    """Whether the cases of a file that were chosen are refused alike without all else that is given."""
    if not any(source.given.values()):
        return True
    try:
        _made(load_plan(source.path, cases=source.given.get("cases")), fmus)
    except InputError as error:
        return str(error) == said
    return False


def _made(plan: Plan, fmus: Fmus) -> list[Case]:
    named = {**plan.cases} if plan.cases else {"": NamedCase()}
    made: list[Case] = []
    count = len(plan.scenarios) * len(named) * math.prod(map(len, plan.grid.values()))
    if count > MOST_CASES:
        raise InputError(f"grid: makes {count} cases, must make at most {MOST_CASES}")
    for source in plan.scenarios:
        if _own_filters(plan, source) == {}:
            continue
        for label, own in named.items():
            points = (dict(zip(plan.grid, values, strict=True)) for values in product(*plan.grid.values()))
            made += [_case(plan, source, label, own, point, fmus) for point in points]
    if not made:
        raise InputError("filters: none is for a scenario of the campaign")
    if isinstance(plan.filters, tuple):
        made = _selected(made, plan.filters)
    made = held_against_unfaulted(made, fmus)
    labels = [case.label for case in made]
    if twice := {label for label in labels if labels.count(label) > 1}:
        raise InputError(f"scenarios: {', '.join(sorted(twice))} is named more than once")
    _check_reference(plan, filter_labels(made))
    for expectations in plan.expect:
        _check_expectations(expectations, made)
    return made


def expected_of(expectations: Expectations, made: Sequence[Case]) -> list[Case]:
    """Cases that expectations are of."""
    return [case for case in made if not expectations.cases or case.label in expectations.cases]


def fingerprint(plan: Plan, made: Sequence[Case], versions: Mapping[str, str]) -> str:
    """Hash of all that decides what a campaign computes and keeps."""
    content = {
        "plan": plan.model_dump(mode="json", exclude={"description", "reference", "instants", "expect"}),
        "cases": {case.label: case.scenario.model_dump(mode="json") for case in made},
        "versions": dict(versions),
        "kept": [*SERIES, *figures(plan.asked), *(["errors"] if plan.asked.errors else [])],
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _case(plan: Plan, source: str, label: str, own: NamedCase, point: Mapping[str, Any], fmus: Fmus) -> Case:
    below = {name: value for name, value in plan.set.items() if name not in own.draw}
    settings = {**below, **own.set, **point}
    drawn = {**{name: given for name, given in plan.draw.items() if name not in own.set}, **own.draw}
    if clash := [name for name in drawn if name in settings]:
        raise InputError(f"draw: {clash[0]} is set and drawn{f' in {label}' if label else ''}")
    compare = _own_filters(plan, source)
    running = plan.filters if isinstance(plan.filters, tuple) else None
    scenario = load_scenario(
        source, fmus, seed=plan.seed, settings=settings, compare=compare, running=running
    )
    _check_period(plan.period, scenario)
    draws = tuple(draw(name, given, scenario, fmus) for name, given in drawn.items())
    _check_drawn(draws, scenario, running)
    return Case(
        " ".join([scenario.name, *([label] if label else []), *_texts(point)]),
        source,
        settings,
        scenario,
        draws,
    )


def _check_drawn(draws: Sequence[Draw], scenario: Scenario, running: Container[str] | None) -> None:
    """Refuse to draw for all filters what makes one of them what it is, and what has no effect."""
    of_plant = [name for one in draws if one.part == "plant" for name in one.units]
    if scenario.vehicle() is not None and (still := [n for n in of_plant if n.startswith(MOTION)]):
        raise InputError(f"draw: {still[0]} has no effect: {scenario.name} has a vehicle of its own")
    scalars = [name for one in draws if one.part == "filter" for name in one.units]
    for label, entry in scenario.compare.items():
        if (running is None or label in running) and (own := [name for name in scalars if name in entry]):
            raise InputError(f"draw: {own[0]} is for all filters, and {label} has one of its own")


def _texts(point: Mapping[str, Any]) -> list[str]:
    return [f"{name}={_text(value)}" for name, value in point.items()]


def _own_filters(plan: Plan, source: str) -> dict[str, dict[str, Any]] | None:
    """Filters of the campaign's own for a scenario; None if it compares those of the scenario."""
    if not isinstance(plan.filters, dict):
        return None
    compare, names = {}, [scenario_path(name).stem for name in plan.scenarios]
    for label, values in plan.filters.items():
        only = values.get("scenarios", names)
        if unknown := [name for name in only if name not in names]:
            hint = did_you_mean(unknown[0], names)
            raise InputError(f"filters.{label}: the campaign has no scenario {unknown[0]}{hint}")
        if scenario_path(source).stem in only:
            compare[label] = {name: value for name, value in values.items() if name != "scenarios"}
    return compare


def _selected(made: Sequence[Case], labels: Sequence[str]) -> list[Case]:
    """The cases with the named filters alone; each must be compared by at least one case."""
    known = filter_labels(made)
    if not labels:
        raise InputError("filters: names no filter; without the entry all that the scenarios compare are run")
    for label in labels:
        if label not in known:
            hint = did_you_mean(label, known) or f"; there are {', '.join(known)}"
            raise InputError(f"filters: no scenario compares '{label}'{hint}")
    kept = []
    for case in made:
        scenario = case.scenario.with_filters(labels)
        if not scenario.filters():
            raise InputError(f"filters: {case.label} compares none of {', '.join(labels)}")
        kept.append(replace(case, scenario=scenario))
    return kept


def _check_period(period: float, scenario: Scenario) -> None:
    stride = period / scenario.recording_period
    if round(stride) < 1 or abs(stride - round(stride)) > 1e-6:
        raise InputError(
            f"period = {period:g} s: must be a whole multiple of the recording_period of {scenario.name}, "
            f"{scenario.recording_period:g} s"
        )


def _check_reference(plan: Plan, known: Sequence[str]) -> None:
    if plan.reference is not None and plan.reference not in known:
        hint = did_you_mean(plan.reference, list(known)) or f"; there are {', '.join(known)}"
        raise InputError(f"reference: there is no filter '{plan.reference}'{hint}")


def _check_expectations(expectations: Expectations, made: Sequence[Case]) -> None:
    labels = [case.label for case in made]
    try:
        for label in expectations.cases:
            known_name("case", label, labels)
        for case in expected_of(expectations, made):
            for label in expectations.filters():
                known_name("filter", label, list(case.filters()))
    except ValueError as error:
        raise InputError(f"expect: {error}") from None


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)
