"""Scenario of a file, with settings, checked against the FMUs."""

from __future__ import annotations

from collections.abc import Container, Mapping
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from sim_scenarios import ports
from sim_scenarios.catalogue import located, read_scenario, scenario_path, with_filter_fmu
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, Fmus
from sim_scenarios.scenario.entries import Parts
from sim_scenarios.scenario.sentences import sentence
from sim_scenarios.scenario.settings import refuse_overruled, with_bound_of_what_is_drawn, with_settings
from sim_scenarios.scenario.tables import MOTION, VEHICLES, Scenario
from sim_scenarios.toml import dotted

EKF_UKF_ROBUST: Final[dict[str, dict[str, Any]]] = {
    "EKF": {"predictor": "linearised", "corrector": "standard"},
    "UKF": {"predictor": "unscented", "corrector": "standard"},
    "robust UKF": {"predictor": "unscented", "corrector": "h_infinity"},
}
"""The comparison of Zhou 2011, for scenarios that name no other."""


def load_scenario(
    name: str | Path,
    fmus: Fmus,
    *,
    seed: int | None = None,
    settings: Mapping[str, object] | None = None,
    compare: Mapping[str, Mapping[str, object]] | None = None,
    running: Container[str] | None = (),
) -> Scenario:
    """Scenario of a shipped name or a path, with settings that override the file.

    Parameters
    ----------
    name : str or Path
        Name of a shipped scenario, or path of a TOML file, whose `.toml` may be left out.
    fmus : Fmus
        They have the FMUs whose parameters and units the file uses.
    seed : int, optional
        Seed of the plant.
    settings : mapping, optional
        Values by name: an FMU parameter (`imu.gyro.bias`), prefixed with `plant.`, `filter.` or `alignment.`
        where several FMUs have it, or an entry of the scenario (`duration`, `initial_error.misalignment`).
    compare : mapping, optional
        Filters to compare in place of the scenario's: parameters by label.
    running : container of str, optional
        Labels of the filters that are compared, None for all of them: no setting may overrule what one of
        these says of itself, for its label would not be true.

    Returns
    -------
    Scenario
    """
    path = scenario_path(name)
    table = {"name": path.stem, **read_scenario(path)}
    overriding = {**(settings or {}), **({} if seed is None else {"plant.seed": seed})}
    if "filter_fmu" in overriding:  # decides what the other entries may be
        given = located({"filter_fmu": overriding.pop("filter_fmu")}, Path())["filter_fmu"]
        table = with_filter_fmu(table, str(given))
    filter_fmu = str(table.get("filter_fmu", ALIGNMENT_FILTER))
    table.setdefault("compare", EKF_UKF_ROBUST if filter_fmu == ALIGNMENT_FILTER else {})
    try:
        parts = {"plant": fmus.plant, "filter": fmus[filter_fmu]}
        if "alignment" in table:
            parts["alignment"] = fmus[ALIGNMENT_FILTER]
            if filter_fmu != NAVIGATION_FILTER:
                raise InputError(
                    f"alignment: is handed over to a {NAVIGATION_FILTER}, and filter_fmu is {filter_fmu}"
                )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    unchanged = _check(table, parts, fmus, path)
    if compare is not None:
        table["compare"] = compare
    changed = _check(with_settings(table, parts, overriding), parts, fmus, "the settings")
    if running is None or running:
        says = unchanged if compare is None else _check(table, parts, fmus, "the filters")
        refuse_overruled(says, changed, running, parts["filter"])
    changed = with_bound_of_what_is_drawn(changed, overriding)
    if not (unchanged.notes and settings):
        return changed
    names = ", ".join(settings)
    return changed.model_copy(
        update={"notes": f"Of the scenario as it is written, before {names} changed: {changed.notes.strip()}"}
    )


def _check(table: Mapping[str, Any], parts: Parts, fmus: Fmus, where: Path | str) -> Scenario:
    context = {"parts": parts, "fmus": fmus}
    try:
        scenario = Scenario.model_validate(_driven(_with_rivals_apart(table, where)), context=context)
    except ValidationError as error:
        raise InputError("\n".join(sentence(where, e) for e in error.errors())) from None
    external = parts["plant"].variables["motion.kind"].items["external"]
    if scenario.plant.get("motion.kind") == external and scenario.vehicle() is None:
        raise InputError(
            f"{where}: plant.motion.kind = external: needs a trajectory or waypoints to say how it moves"
        )
    rivals = (rival.filter_fmu for rival in scenario.rivals.values())
    for name in dict.fromkeys((scenario.filter_fmu, *rivals)):
        if name != scenario.standard:
            ports.check(fmus[name], fmus.plant, fmus[scenario.standard])
    return scenario


def _driven(table: dict[str, Any]) -> dict[str, Any]:
    """Scenario table whose plant moves as a trajectory or waypoints say, if it has any."""
    if all(table.get(name) is None for name in VEHICLES):
        return table
    plant = {name: value for name, value in dotted(table.get("plant", {})) if not name.startswith(MOTION)}
    return {**table, "plant": {**plant, "motion.kind": "external"}}


def _with_rivals_apart(table: Mapping[str, Any], where: Path | str) -> dict[str, Any]:
    """Scenario table with the filters of `compare` that have an FMU of their own in a table `rivals`."""
    if "rivals" in table:
        raise InputError(f"{where}: rivals: there is no such entry; a filter_fmu in compare makes one")
    compare = table.get("compare")
    if not isinstance(compare, Mapping):
        return dict(table)
    rivals = {k: v for k, v in compare.items() if isinstance(v, Mapping) and "filter_fmu" in v}
    return {**table, "compare": {k: v for k, v in compare.items() if k not in rivals}, "rivals": rivals}
