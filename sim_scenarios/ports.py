"""What a filter of somebody else's must have to stand beside ours: ports with our names, types and units.

It need not have them all. Its inputs take the signals of the plant that have their names; what it starts
from is set as far as it has parameters or inputs for it; and those of its outputs are recorded that our
filter has, too, arrays as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import NAVIGATION_FILTER, SIGNALS, START, Fmu, Variable

_JUDGED: Final = ("nav.heading",)
_JUDGED_OF_NAVIGATION: Final = ("nav.latitude", "nav.longitude", "nav.height")


def check(fmu: Fmu, plant: Fmu, standard: Fmu) -> None:
    """Refuse a filter that cannot be run on the signals of a plant, or not be judged.

    Parameters
    ----------
    fmu : Fmu
        The filter.
    plant : Fmu
        Whose signals it takes.
    standard : Fmu
        The filter of ours whose outputs and verdict its own are held against.

    Raises
    ------
    InputError
        It lacks what the verdict is about, takes no signal, or has a port with another type or unit.
    """
    for own, ours in _counterparts(fmu, plant, standard):
        if reason := _difference(own, ours):
            raise InputError(f"{fmu.path}: its {own.causality} {own.name} {reason}")
    judged = _JUDGED_OF_NAVIGATION if standard.name == NAVIGATION_FILTER else _JUDGED
    there = set(recorded(fmu, standard))
    if missing := [name for name in judged if name not in there]:
        raise InputError(f"{fmu.path} has no output {', '.join(missing)}, which the verdict is about")
    if not any(name.startswith(SIGNALS) for name in fmu.inputs()):
        raise InputError(f"{fmu.path} has no input for signals of {plant.name}, such as imu.delta_angle[1]")


def recorded(fmu: Fmu, standard: Fmu) -> list[str]:
    """Scalar outputs of a filter that are recorded: those that the standard has, arrays as a whole."""
    if fmu is standard:
        return fmu.outputs()
    theirs = set(standard.outputs())
    return [
        scalar
        for base, scalars in fmu.arrays.items()
        if scalars == standard.arrays.get(base)
        for scalar in scalars
        if scalar in theirs and fmu.variables[scalar].causality == "output"
    ]


def _counterparts(fmu: Fmu, plant: Fmu, standard: Fmu) -> Iterator[tuple[Variable, Variable]]:
    """Variables of a filter, each with what it is connected with, set from or compared with."""
    for name in recorded(fmu, standard):
        yield fmu.variables[name], standard.variables[name]
    for name, variable in fmu.variables.items():
        if name.startswith(START) and variable.settable and name in standard.variables:
            yield variable, standard.variables[name]
        elif variable.causality == "input" and name.startswith(SIGNALS) and name in plant.variables:
            yield variable, plant.variables[name]


def _difference(own: Variable, ours: Variable) -> str:
    """What keeps a variable from standing for another; nothing of a unit that is not declared."""
    if own.kind != ours.kind:
        return f"is {own.kind}: must be {ours.kind}"
    if own.unit.name not in ("1", ours.unit.name):
        return f"is in {own.unit.name}: must be in {ours.unit.name}"
    if strange := [item for item, number in own.items.items() if ours.items.get(item) != number]:
        known = ", ".join(f"{number} {item}" for item, number in ours.items.items())
        return f"has the item {own.items[strange[0]]} {strange[0]}: must have none but {known}"
    return ""
