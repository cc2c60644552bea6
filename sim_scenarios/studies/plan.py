"""What a campaign consists of: scenarios, filters, seeds and a grid of parameters.

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
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError

from sim_scenarios import toml
from sim_scenarios.catalogue import CAMPAIGNS, files, located_filters, scenario_path
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.names import Label, Name, Text
from sim_scenarios.scenario.tables import Table
from sim_scenarios.studies.draws import Distribution
from sim_scenarios.studies.expectations import Expectations, asked
from sim_scenarios.studies.quantities import Asked
from sim_scenarios.toml import dotted

LARGEST_SEED: Final = 2**31 - 1
MOST_RUNS: Final = 1_000_000
"""Of a case: a hundred for each that a figure with three digits needs."""
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
    def source(self) -> Source | None:
        """Where it comes from; None of a scenario alone."""
        return self._source

    @property
    def asked(self) -> Asked:
        """What is kept of its runs because something is expected of them."""
        return asked(self.expect)

    @property
    def batch(self) -> int:
        """Runs of a task, which are stored together: few tasks, yet enough of them to share out evenly."""
        return max(1, min(self.runs // MOST_BATCHES, LARGEST_BATCH))


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


def _sentence(where: object, error: Any) -> str:
    key = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        return f"{where}: {key}: there is no such entry{did_you_mean(key, list(Plan.model_fields))}"
    if cause := error.get("ctx", {}).get("error"):
        return f"{where}: {key}: {cause}"
    message = (error["msg"][0].lower() + error["msg"][1:]).replace("tuple", "list")
    said = f", not {error['input']!r}" if isinstance(error["input"], int | float | str) else ""
    return f"{where}: {key}: {message}{said}"
