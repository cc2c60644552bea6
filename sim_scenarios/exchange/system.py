"""A scenario as a system of FMUs with all that is set in them, ready to be written down."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass

from sim_scenarios.cosimulation import connected, handed_over
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Fmus, Number
from sim_scenarios.scenario import Scenario
from sim_scenarios.simulation import TRUTH, filter_values, initial_values, start_plant

PLANT, ALIGNMENT, FILTER = "plant", "alignment", "filter"
SHOWN = ("nav.", "misalignment", "heading_sigma", "converged", "rejected_", "used_fixes", "truth.")
"""Beginnings of the names of outputs that are offered to other tools beside the connected ones."""

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Component:
    """An FMU in a system.

    Attributes
    ----------
    name : str
    fmu : Fmu
        FMI 2.
    values : mapping of str to number
        What is set before initialisation, by scalar name.
    inputs, outputs : list of str
        Scalars that are connected, or offered to other tools.
    """

    name: str
    fmu: Fmu
    values: Mapping[str, Number]
    inputs: list[str]
    outputs: list[str]

    def value(self, name: str) -> Number:
        """Value of a scalar before initialisation: what is set, else the FMU's own."""
        return self.values[name] if name in self.values else self.fmu.start(name)

    @property
    def units(self) -> dict[str, dict[str, int]]:
        """Units by name, with the exponents of their SI base units; half-integer ones cannot be said."""
        return {
            str(unit.name): {base: power for base in BASES if (power := getattr(unit.baseUnit, base))}
            for unit in self.fmu.model.unitDefinitions
            if unit.baseUnit is not None
        }


@dataclass(frozen=True)
class Connection:
    """Outputs of a component that go into inputs of another.

    Attributes
    ----------
    start, end : str
        Names of the components.
    outputs : mapping of str to str
        Output of the one by input of the other, scalars.
    """

    start: str
    end: str
    outputs: Mapping[str, str]


@dataclass(frozen=True)
class System:
    """A plant and a filter, connected by equal names; with an alignment between them, which hands over.

    Attributes
    ----------
    name, description : str
        Of the scenario.
    stop, step : float
        End and communication step [s].
    plant, filter : Component
    alignment : Component or None
    connections : list of Connection
    """

    name: str
    description: str
    stop: float
    step: float
    plant: Component
    filter: Component
    alignment: Component | None
    connections: list[Connection]

    @property
    def components(self) -> list[Component]:
        """In the order of stepping."""
        return [self.plant, *([self.alignment] if self.alignment else []), self.filter]

    @property
    def units(self) -> dict[str, dict[str, int]]:
        """Units of the FMUs."""
        return {name: base for component in self.components for name, base in component.units.items()}


def of_scenario(scenario: Scenario, fmus: Fmus) -> System:
    """FMUs of a scenario; the first filter starts from the truth with the scenario's errors."""
    plant, filter_fmu = fmus.plant, fmus[scenario.filter_fmu]
    with ExitStack() as stack:
        truth = start_plant(scenario, fmus, stack).read(TRUTH)
    start = initial_values(scenario, plant, dict(zip(TRUTH, truth, strict=True)))
    signals = connected(plant.outputs(), filter_fmu)
    connections = [Connection(PLANT, FILTER, {name: name for name in signals})]
    alignment, handed = None, {}
    if scenario.alignment is None:
        given = filter_values(filter_fmu, start, scenario.filter)
    else:
        fmu = fmus[ALIGNMENT_FILTER]
        sensed, handed = connected(plant.outputs(), fmu), handed_over(fmu, filter_fmu)
        connections.insert(0, Connection(PLANT, ALIGNMENT, {name: name for name in sensed}))
        connections.append(Connection(ALIGNMENT, FILTER, handed))
        alignment = Component(
            ALIGNMENT,
            fmu,
            filter_values(fmu, start, scenario.alignment),
            sensed,
            list(dict.fromkeys([*handed.values(), *_shown(fmu)])),
        )
        given = {"initial.valid": False, **scenario.filter}
    return System(
        name=scenario.name,
        description=scenario.description,
        stop=scenario.duration,
        step=scenario.communication_step,
        plant=Component(PLANT, plant, scenario.plant, [], [*signals, *_shown(plant)]),
        filter=Component(
            FILTER,
            filter_fmu,
            given,
            [*signals, *handed],
            _shown(filter_fmu),
        ),
        alignment=alignment,
        connections=connections,
    )


def _shown(fmu: Fmu) -> list[str]:
    """Outputs of general interest; none is an enumeration, which some tools do not know."""
    return [n for n in fmu.outputs() if n.startswith(SHOWN) and fmu.variables[n].kind != "Enumeration"]
