"""What a campaign consists of: scenarios, filters, seeds and a grid of parameters, and the cases they make.

A campaign file is a TOML file with a list `scenarios`; a scenario alone is a campaign of that one scenario ::

    description = "Filters on and off a steady course"
    scenarios = ["swaying_ship", "zigzag"]
    runs = 100                       # seeds 1 to 100, the same ones for every filter and every case
    seed = 1
    filters = ["EKF", "UKF"]         # labels that the scenarios compare (all of them, if left out)

    [set]                            # as --set of `truenorth run`, for every case
    "gate.enabled" = true

    [draw]                           # for every run from its seed (see `draws`); or log_uniform, choice
    "motion.speed" = { uniform = [5.0, "20 kn"] }

    [grid]                           # every combination of these values is a case
    "gnss.rate" = [1.0, 5.0]

    [cases."GNSS falls silent"]      # a case by name, with settings and draws of its own
    set = { "fault.gnss.kind" = "silence", "fault.gnss.begin" = 300.0 }
    draw = { "fault.gnss.duration" = { log_uniform = ["1 s", "60 s"] } }

Each scenario is run with each of the named cases, if there are any, and each point of the grid. What the
command line sets (`--set`, `--grid`) stands in place of what the file sets or draws, in its named cases too.

Filters of the campaign's own stand in tables `[filters."name"]` with their parameters, and perhaps with a
`filter_fmu`, as in the table `compare` of a scenario (what is set or drawn for the filter is not for these).
With an entry `scenarios` (a list of names) they are run in these alone; a scenario without any is left out.

What is expected of the figures of filters stands in tables `[[expect]]` (see `expectations`).

A case with a fault of the plant (`fault.*`) is held against the same scenario without it: that is a case too,
once for all faults of the scenario, and runs first.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError

from sim_scenarios import faults, toml
from sim_scenarios.catalogue import CAMPAIGNS, files, located_filters, scenario_path
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus, Number, did_you_mean
from sim_scenarios.names import Label, Name, Text
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.scenario.tables import FILTER, MOTION, Table
from sim_scenarios.studies.draws import Distribution, Draw, draw
from sim_scenarios.studies.expectations import Expectations, asked, known_name
from sim_scenarios.studies.quantities import SERIES, Asked, figures
from sim_scenarios.toml import dotted

LARGEST_SEED: Final = 2**31 - 1
MOST_RUNS: Final = 1_000_000
"""Of a case: a hundred for each that a figure with three digits needs."""
MOST_CASES: Final = 10_000
MOST_BATCHES: Final = 50
LARGEST_BATCH: Final = 16


def _checked_filters(given: object) -> object:
    """What a file says of filters, as far as it can be said in a sentence what is wrong with it."""
    if isinstance(given, Mapping):
        for label, entry in given.items():
            if not isinstance(entry, Mapping):
                raise InputError(f"{label} = {entry!r}: must be a table of parameters")
            only = entry.get("scenarios", [])
            if not isinstance(only, list) or not all(isinstance(name, str) for name in only):
                raise InputError(f"{label}.scenarios = {only!r}: must be a list of names of scenarios")
    elif given is not None and not (
        isinstance(given, list | tuple) and all(isinstance(label, str) for label in given)
    ):
        raise InputError(f"{given!r}: must be a list of labels, or tables of parameters by label")
    return given


def _in_one_table(given: object) -> object:
    """Settings under their dotted names, quoted in the file or not."""
    return dict(dotted(given)) if isinstance(given, Mapping) else given


def _distributions(given: object) -> object:
    """Distributions under their dotted names, quoted in the file or not."""
    return dict(_leaves(given)) if isinstance(given, Mapping) else given


def _leaves(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping) and value and all(isinstance(one, Mapping) for one in value.values()):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


Filters = Annotated[tuple[str, ...] | dict[Label, dict[str, Any]] | None, BeforeValidator(_checked_filters)]
Settings = Annotated[dict[str, Any], BeforeValidator(_in_one_table)]
Draws = Annotated[dict[str, Distribution], BeforeValidator(_distributions)]
Values = Annotated[dict[str, Annotated[list[Any], Field(min_length=1)]], BeforeValidator(_in_one_table)]


class NamedCase(Table):
    """What a named case sets and draws, beside and in place of what all cases do."""

    set: Settings = Field(default={})
    draw: Draws = Field(default={})


@dataclass(frozen=True)
class Source:
    """File that a plan is of, and what is given in place of what it says."""

    path: Path
    given: Mapping[str, Any]


class Plan(Table):
    """A campaign, as its file says it."""

    name: Name
    description: Text = ""
    scenarios: Annotated[tuple[str, ...], Field(min_length=1)]
    filters: Filters = None
    reference: str | None = None
    runs: Annotated[int, Field(ge=1, le=MOST_RUNS)] = 100
    seed: Annotated[int, Field(ge=0)] = 1
    period: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 1.0
    instants: tuple[Annotated[float, Field(ge=0, allow_inf_nan=False)], ...] = ()
    """When the NEES is looked at, beside the end of the evaluation [s]."""
    set: Settings = Field(default={})
    draw: Draws = Field(default={})
    grid: Values = Field(default={})
    cases: dict[Label, NamedCase] = Field(default={})
    expect: tuple[Expectations, ...] = ()
    _source: Source | None = PrivateAttr(default=None)

    @property
    def asked(self) -> Asked:
        """What is kept of its runs because something is expected of them."""
        return asked(self.expect)

    @property
    def batch(self) -> int:
        """Runs of a task, which are stored together: few tasks, yet enough of them to share out evenly."""
        return max(1, min(self.runs // MOST_BATCHES, LARGEST_BATCH))


@dataclass(frozen=True)
class Case:
    """A scenario with a named case and one combination of the grid, checked against the FMUs.

    Attributes
    ----------
    label : str
        Unique in its campaign: the scenario, the name of the case, and what the grid sets.
    source : str
        Name or path of the scenario.
    settings : dict of str to object
        Values by name that differ from the scenario file, as for `sim_scenarios.run`.
    scenario : Scenario
        With the filters of the campaign as those that it compares.
    draws : tuple of Draw
        What differs from run to run.
    unfaulted : str or None
        Label of the same case without the faults of its plant; None of a case that has none.
    """

    label: str
    source: str
    settings: dict[str, Any]
    scenario: Scenario
    draws: tuple[Draw, ...] = ()
    unfaulted: str | None = None

    def filters(self) -> dict[str, dict[str, Number]]:
        """Parameters of each filter, by label."""
        return filters_of(self.scenario)

    def with_seed(self, seed: int) -> Scenario:
        """The scenario of one run: its seed, and what is drawn for it."""
        drawn: dict[str, dict[str, Number]] = {"plant": {"seed": seed}, "filter": {}, "alignment": {}}
        for one in self.draws:
            drawn[one.part] |= one.drawn(seed)
        of_filter = drawn["filter"]
        update: dict[str, Any] = {"plant": {**self.scenario.plant, **drawn["plant"]}}
        if of_filter:
            compare = {label: {**values, **of_filter} for label, values in self.scenario.compare.items()}
            update |= {"filter": {**self.scenario.filter, **of_filter}, "compare": compare}
        if self.scenario.alignment is not None:
            update["alignment"] = {**self.scenario.alignment, **drawn["alignment"]}
        return self.scenario.model_copy(update=update)

    def drawn(self, seed: int) -> dict[str, Number]:
        """What is drawn for one run, in SI units under the names that `--set` takes."""
        return {one.label(scalar): value for one in self.draws for scalar, value in one.drawn(seed).items()}


def filters_of(scenario: Scenario) -> dict[str, dict[str, Number]]:
    """Parameters of each filter of a scenario, by label."""
    return scenario.filters() or {FILTER: dict(scenario.filter)}


def load_plan(name: str | Path, **given: Any) -> Plan:
    """Campaign of a file, of a shipped name, or of a single scenario.

    Parameters
    ----------
    name : str or Path
        Shipped campaign or scenario, or path of a TOML file of either.
    given : object
        Entries in place of the file's (`runs`, `seed`, `filters` ...), None for the file's own; `set` and
        `grid` add to the file's and win over what it sets or draws; labels in `filters` and `cases` select.
    """
    path = _campaign_path(name)
    table = _of_scenario(name) if path is None else {"name": path.stem, **_read(path)}
    for key, value in given.items():
        if value is not None:
            table[key] = _given(table.get(key), value, key)
    try:
        plan = Plan.model_validate(table)
    except ValidationError as error:
        raise InputError("\n".join(_sentence(path or name, e) for e in error.errors())) from None
    if plan.seed + plan.runs - 1 > LARGEST_SEED:
        raise InputError(
            f"{path or name}: seed = {plan.seed}: the last of {plan.runs} seeds must not exceed "
            f"{LARGEST_SEED}"
        )
    plan = _overridden(plan, {**(given.get("set") or {}), **(given.get("grid") or {})})
    plan._source = None if path is None else Source(path, given)
    return plan


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
        if plan._source is None or not _is_of_the_file(str(error), plan._source, fmus):
            raise
        raise InputError(f"{plan._source.path}: {error}") from None


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
    made = _held_against_unfaulted(made, fmus)
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


def filter_labels(made: Sequence[Case]) -> list[str]:
    """Labels of all filters, in the order in which the cases name them."""
    return list(dict.fromkeys(label for case in made for label in case.filters()))


def fingerprint(plan: Plan, made: Sequence[Case], versions: Mapping[str, str]) -> str:
    """Hash of all that decides what a campaign computes and keeps."""
    content = {
        "plan": plan.model_dump(mode="json", exclude={"description", "reference", "instants", "expect"}),
        "cases": {case.label: case.scenario.model_dump(mode="json") for case in made},
        "versions": dict(versions),
        "kept": [*SERIES, *figures(plan.asked), *(["errors"] if plan.asked.errors else [])],
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _given(table: Any, value: Any, key: str) -> Any:
    """Entry of a campaign with what is given in its place: tables are joined, labels select of a table."""
    if isinstance(table, Mapping) and isinstance(value, tuple):
        if unknown := [label for label in value if label not in table]:
            hint = did_you_mean(unknown[0], table) or f"; there are {', '.join(table)}"
            raise InputError(f"{key}: there is no '{unknown[0]}'{hint}")
        return {label: table[label] for label in value}
    if key == "cases" and table is None:
        raise InputError(f"cases: the campaign has none by name, and {value[0]} is asked for")
    return {**table, **value} if isinstance(table, Mapping) and isinstance(value, Mapping) else value


def _overridden(plan: Plan, given: Mapping[str, Any]) -> Plan:
    """Plan in which nothing else sets or draws what is given on the command line."""

    def rest(table: Mapping[str, Any]) -> dict[str, Any]:
        return {name: value for name, value in table.items() if name not in given}

    named = {label: NamedCase(set=rest(case.set), draw=rest(case.draw)) for label, case in plan.cases.items()}
    return plan.model_copy(update={"draw": rest(plan.draw), "cases": named})


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


def _held_against_unfaulted(made: Sequence[Case], fmus: Fmus) -> list[Case]:
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


def _campaign_path(name: str | Path) -> Path | None:
    """Path of a campaign file; None if the name is a scenario's."""
    if isinstance(name, str) and (shipped := files(CAMPAIGNS).get(name)):
        return shipped
    try:
        path = scenario_path(name)
    except InputError:
        return None
    return path if "scenarios" in _read(path) else None


def _of_scenario(name: str | Path) -> dict[str, Any]:
    return {"name": scenario_path(name).stem, "scenarios": (str(name),)}


def _read(path: Path) -> dict[str, Any]:
    """Content of a campaign file; scenario files and FMUs stand relative to it."""
    table = toml.read(path)
    if isinstance(named := table.get("scenarios"), list):
        table["scenarios"] = tuple(
            str(path.parent / entry) if str(entry).endswith(".toml") else entry for entry in named
        )
    if "filters" in table:
        table["filters"] = located_filters(table["filters"], path.parent)
    return table


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


def _sentence(where: object, error: Any) -> str:
    key = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        return f"{where}: {key}: there is no such entry{did_you_mean(key, list(Plan.model_fields))}"
    if cause := error.get("ctx", {}).get("error"):
        return f"{where}: {key}: {cause}"
    message = (error["msg"][0].lower() + error["msg"][1:]).replace("tuple", "list")
    said = f", not {error['input']!r}" if isinstance(error["input"], int | float | str) else ""
    return f"{where}: {key}: {message}{said}"
