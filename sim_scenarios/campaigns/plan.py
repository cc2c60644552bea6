"""What a campaign consists of: scenarios, filters, seeds and a grid of parameters, and the cases they make.

A campaign file is a TOML file with a list `scenarios`; a scenario alone is a campaign of that one scenario ::

    description = "Filters on and off a steady course"
    scenarios = ["swaying_ship", "zigzag"]
    runs = 100                       # seeds 1 to 100, the same ones for every filter and every case
    seed = 1
    filters = ["EKF", "UKF"]         # labels that the scenarios compare (all of them, if left out)

    [set]                            # as --set of `truenorth run`, for every case
    "gate.enabled" = true

    [grid]                           # every combination of these values is a case
    "gnss.rate" = [1.0, 5.0]

Filters of the campaign's own stand in tables `[filters."name"]` with their parameters.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import Field, ValidationError

from sim_scenarios import toml
from sim_scenarios.campaigns.quantities import FIGURES, SERIES
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus, Number, did_you_mean
from sim_scenarios.names import Label, Name, Text
from sim_scenarios.scenario import Scenario, Table, load_scenario, scenario_path

SHIPPED: Final = Path(__file__).parent / "shipped"
LARGEST_SEED: Final = 2**31 - 1
MOST_RUNS: Final = 1_000_000
"""Of a case: a hundred for each that a figure with three digits needs."""
MOST_CASES: Final = 10_000
MOST_BATCHES: Final = 50
LARGEST_BATCH: Final = 16

Filters = tuple[str, ...] | dict[Label, dict[str, Any]] | None


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
    set: dict[str, Any] = Field(default={})
    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field(default={})

    @property
    def batch(self) -> int:
        """Runs of a task, which are stored together: few tasks, yet enough of them to share out evenly."""
        return max(1, min(self.runs // MOST_BATCHES, LARGEST_BATCH))


@dataclass(frozen=True)
class Case:
    """A scenario with one combination of the grid, checked against the FMUs.

    Attributes
    ----------
    label : str
        Unique in its campaign: the scenario, and what the grid sets.
    source : str
        Name or path of the scenario.
    settings : dict of str to object
        Values by name that differ from the scenario file, as for `sim_scenarios.run`.
    scenario : Scenario
        With the filters of the campaign as those that it compares.
    """

    label: str
    source: str
    settings: dict[str, Any]
    scenario: Scenario

    def filters(self) -> dict[str, dict[str, Number]]:
        """Parameters of each filter, by label."""
        return self.scenario.filters() or {"filter": dict(self.scenario.filter)}

    def with_seed(self, seed: int) -> Scenario:
        """The scenario of one run."""
        return self.scenario.model_copy(update={"plant": {**self.scenario.plant, "seed": seed}})


def load_plan(name: str | Path, **given: Any) -> Plan:
    """Campaign of a file, of a shipped name, or of a single scenario.

    Parameters
    ----------
    name : str or Path
        Shipped campaign or scenario, or path of a TOML file of either.
    given : object
        Entries in place of the file's (`runs`, `seed`, `filters` ...), None for the file's own; `set` and
        `grid` add to the file's.
    """
    path = _campaign_path(name)
    table = _of_scenario(name) if path is None else {"name": path.stem, **_read(path)}
    for key, value in given.items():
        if value is not None:
            table[key] = {**table.get(key, {}), **value} if isinstance(value, Mapping) else value
    try:
        plan = Plan.model_validate(table)
    except ValidationError as error:
        raise InputError("\n".join(_sentence(path or name, e) for e in error.errors())) from None
    if plan.seed + plan.runs - 1 > LARGEST_SEED:
        raise InputError(f"seed = {plan.seed}: the last of {plan.runs} seeds must not exceed {LARGEST_SEED}")
    return plan


def cases(plan: Plan, fmus: Fmus) -> list[Case]:
    """Every scenario with every combination of the grid."""
    own = plan.filters if isinstance(plan.filters, dict) else None
    made = []
    count = len(plan.scenarios) * math.prod(map(len, plan.grid.values()))
    if count > MOST_CASES:
        raise InputError(f"grid: makes {count} cases, must make at most {MOST_CASES}")
    for source in plan.scenarios:
        for values in product(*plan.grid.values()):
            point = dict(zip(plan.grid, values, strict=True))
            settings = {**plan.set, **point}
            scenario = load_scenario(source, fmus, seed=plan.seed, settings=settings, compare=own)
            label = " ".join([scenario.name, *(f"{name}={_text(value)}" for name, value in point.items())])
            _check_period(plan.period, scenario)
            made.append(Case(label, source, settings, scenario))
    if isinstance(plan.filters, tuple):
        made = _selected(made, plan.filters)
    labels = [case.label for case in made]
    if twice := {label for label in labels if labels.count(label) > 1}:
        raise InputError(f"scenarios: {', '.join(sorted(twice))} is named more than once")
    _check_reference(plan, filter_labels(made))
    return made


def filter_labels(made: Sequence[Case]) -> list[str]:
    """Labels of all filters, in the order in which the cases name them."""
    return list(dict.fromkeys(label for case in made for label in case.filters()))


def fingerprint(plan: Plan, made: Sequence[Case], versions: Mapping[str, str]) -> str:
    """Hash of all that decides what a campaign computes and keeps."""
    content = {
        "plan": plan.model_dump(mode="json", exclude={"description", "reference"}),
        "cases": {case.label: case.scenario.model_dump(mode="json") for case in made},
        "versions": dict(versions),
        "kept": [*SERIES, *FIGURES],
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _campaign_path(name: str | Path) -> Path | None:
    """Path of a campaign file; None if the name is a scenario's."""
    shipped = SHIPPED / f"{name}.toml"
    if isinstance(name, str) and toml.exists(shipped):
        return shipped
    path = Path(name)
    if path.suffix == ".toml" and toml.exists(path) and "scenarios" in _read(path):
        return path
    return None


def _of_scenario(name: str | Path) -> dict[str, Any]:
    return {"name": scenario_path(name).stem, "scenarios": (str(name),)}


def _read(path: Path) -> dict[str, Any]:
    """Content of a campaign file; scenario files stand relative to it."""
    table = toml.read(path)
    if isinstance(named := table.get("scenarios"), list):
        table["scenarios"] = tuple(
            str(path.parent / entry) if str(entry).endswith(".toml") else entry for entry in named
        )
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
        compare = {label: values for label, values in case.scenario.compare.items() if label in labels}
        if not compare:
            raise InputError(f"filters: {case.label} compares none of {', '.join(labels)}")
        scenario = case.scenario.model_copy(update={"compare": compare})
        kept.append(Case(case.label, case.source, case.settings, scenario))
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


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _sentence(where: object, error: Any) -> str:
    key = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        return f"{where}: {key}: there is no such entry{did_you_mean(key, list(Plan.model_fields))}"
    message = error["msg"][0].lower() + error["msg"][1:]
    return f"{where}: {key}: {message.replace('tuple', 'list')}"
