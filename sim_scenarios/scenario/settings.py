"""Settings that override a scenario file: whose each is, what it changes, and what it must not."""

from __future__ import annotations

from collections.abc import Container, Mapping
from itertools import combinations
from typing import Any, Final

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu, Number, no_such_parameter
from sim_scenarios.scenario.entries import Parts
from sim_scenarios.scenario.tables import MOTION, VEHICLES, Scenario
from sim_scenarios.toml import dotted

_OF_THE_FILE: Final = ("name", "compare", "rivals")
"""Entries that are no settings."""


def setting_owner(name: str, parts: Parts) -> tuple[str, str]:
    """Which part of a scenario a setting belongs to (one of its FMUs, or "scenario"), and its name there."""
    owners = [part for part, fmu in parts.items() if fmu.has_parameter(name)]
    if len(owners) > 1:
        all_of_them = "both" if len(owners) == 2 else f"{len(owners)}"
        choices = " or ".join(f"{owner}.{name}" for owner in owners)
        raise InputError(f"{all_of_them} FMUs have a parameter {name}; say {choices}")
    if owners:
        return owners[0], name
    prefix, _, rest = name.partition(".")
    if prefix in parts:
        return prefix, rest
    if prefix == "alignment":
        raise InputError(f"the setting {name}: the scenario has no table alignment")
    if prefix in _OF_THE_FILE:
        raise InputError(f"the setting {name}: {prefix} is no setting; write a scenario file with extends")
    if prefix in Scenario.model_fields:
        return "scenario", name
    entries = [entry for entry in Scenario.model_fields if entry not in _OF_THE_FILE]
    raise no_such_parameter(name, parts, entries)


def with_settings(table: Mapping[str, Any], parts: Parts, settings: Mapping[str, object]) -> dict[str, Any]:
    """Scenario table with settings put where they belong; a filter's parameter goes to every variant."""
    own = {key: value for key, value in table.items() if key not in (*parts, "compare")}
    given = {part: dict(dotted(table.get(part, {}))) for part in parts}
    compare = {label: dict(dotted(variant)) for label, variant in table["compare"].items()}
    moved_by = [entry for entry in VEHICLES if own.get(entry) is not None or entry in settings]
    for name, value in settings.items():
        owner, parameter = setting_owner(name, parts)
        if owner == "plant" and parameter.startswith(MOTION) and moved_by:
            raise InputError(f"the setting {name}: has no effect: {moved_by[0]} says how the vehicle moves")
        if owner in parts:
            variants = [one for one in compare.values() if "filter_fmu" not in one]
            for values in (given[owner], *(variants if owner == "filter" else ())):
                _put(values, parts[owner], parameter, value)
        else:
            own = _with_entry(own, parameter.split("."), value)
    return {**own, **given, "compare": compare}


def _put(values: dict[str, object], fmu: Fmu, name: str, value: object) -> None:
    """Set a parameter after all that were set before (an element overrides what its array says)."""
    fmu.assignments(name, value)
    values.pop(name, None)
    values[name] = value


def _with_entry(table: Mapping[str, Any], path: list[str], value: object) -> dict[str, Any]:
    key, *rest = path
    if not rest:
        return {**table, key: value}
    inner = table.get(key, {})
    return {**table, key: _with_entry(inner if isinstance(inner, Mapping) else {}, rest, value)}


def refuse_overruled(stated: Scenario, changed: Scenario, running: Container[str] | None, fmu: Fmu) -> None:
    """Refuse settings that make a filter another than its entry says, or two filters one."""
    labels = [label for label in stated.compare if running is None or label in running]
    for label in labels:
        for name, value in stated.compare[label].items():
            if changed.compare[label][name] != value:
                raise InputError(
                    f"the setting {name}: {label} is what it is by its own {name} = "
                    f"{fmu.variables[name].display(value)}; leave it out (--filter of a campaign, or a "
                    "comparison of your own), or run one filter alone"
                )

    def are_one(scenario: Scenario, labels: tuple[str, str]) -> bool:
        one, other = ({**scenario.filter, **scenario.compare[label]} for label in labels)
        return all(
            one.get(name, fmu.start(name)) == other.get(name, fmu.start(name)) for name in {*one, *other}
        )

    for pair in combinations(labels, 2):
        if are_one(changed, pair) and not are_one(stated, pair):
            raise InputError(f"the settings make {' and '.join(pair)} the same filter; run one of them alone")


def with_bound_of_what_is_drawn(scenario: Scenario, settings: Mapping[str, object]) -> Scenario:
    """Scenario whose bound knows a sigma of drawn biases that settings have changed, unless they say what.

    Biases that are no longer drawn (sigma 0) leave the bound as it is: it would have to know them exactly.
    """
    known: dict[str, Number] = {}
    for sensor in ("gyro", "accelerometer"):
        name, entry = f"imu.{sensor}.bias_sigma", f"{sensor}_bias_sigma"
        is_changed = name in settings or f"plant.{name}" in settings
        is_said = "bound" in settings or f"bound.{entry}" in settings
        if is_changed and not is_said and scenario.plant[name] > 0:
            known[entry] = scenario.plant[name]
    return scenario.model_copy(update={"bound": scenario.bound.model_copy(update=known)})
