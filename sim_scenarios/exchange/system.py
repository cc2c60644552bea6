"""A scenario or a recording as a system of FMUs with all that is set in them, ready to be written down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

from sim_scenarios.connection import TRUTH, filter_values, initial_values, start_plant
from sim_scenarios.cosimulation import connected, handed_over
from sim_scenarios.fmus import ALIGNMENT_FILTER, PLAYBACK, Fmu, Fmus, Number
from sim_scenarios.scenario import Scenario

VEHICLE, PLANT, ALIGNMENT, FILTER = "vehicle", "plant", "alignment", "filter"
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
        Of the scenario or the recording.
    stop, step : float
        End and communication step [s].
    checked : float
        End of the reference results [s].
    plant, filter : Component
        Where the signals come from, and what they go into.
    alignment : Component or None
    connections : list of Connection
    vehicle : Component or None
        What moves the plant, if that does not move by itself.
    """

    name: str
    description: str
    stop: float
    step: float
    checked: float
    plant: Component
    filter: Component
    alignment: Component | None
    connections: list[Connection]
    vehicle: Component | None = None

    @property
    def recorded(self) -> bool:
        """Whether the signals are those of a recording."""
        return self.plant.fmu.name == PLAYBACK

    @property
    def components(self) -> list[Component]:
        """In the order of stepping."""
        parts = (self.vehicle, self.plant, self.alignment, self.filter)
        return [component for component in parts if component is not None]

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
    parts, values = {PLANT: plant, FILTER: filter_fmu}, {PLANT: scenario.plant, FILTER: scenario.filter}
    if scenario.alignment is None:
        values[FILTER] = filter_values(filter_fmu, start, scenario.filter)
    else:
        parts[ALIGNMENT] = fmus[ALIGNMENT_FILTER]
        values[ALIGNMENT] = filter_values(parts[ALIGNMENT], start, scenario.alignment)
    plan = Plan(
        scenario.name, scenario.description, scenario.duration, scenario.communication_step, scenario.duration
    )
    return connected_system(plan, parts, values, shown(plant))


@dataclass(frozen=True)
class Plan:
    """What a system is called and for how long it runs; as in a System."""

    name: str
    description: str
    stop: float
    step: float
    checked: float


def connected_system(
    plan: Plan, parts: Mapping[str, Fmu], values: Mapping[str, Mapping[str, Number]], told: Sequence[str]
) -> System:
    """Source of signals, filter and perhaps an alignment before it, connected.

    Parameters
    ----------
    plan : Plan
        What the system is called and for how long it runs.
    parts : mapping of str to Fmu
        The FMUs by the names of their components; `alignment` may be missing.
    values : mapping of str to mapping
        What is set in each of them, by scalar name.
    told : sequence of str
        Outputs of the source that are offered beside those that are connected.

    Returns
    -------
    System
    """
    source, filter_fmu = parts[PLANT], parts[FILTER]
    signals = connected(source.outputs(), filter_fmu)
    connections = [Connection(PLANT, FILTER, {name: name for name in signals})]
    alignment, handed, given = None, {}, values[FILTER]
    if ALIGNMENT in parts:
        fmu = parts[ALIGNMENT]
        sensed, handed = connected(source.outputs(), fmu), handed_over(fmu, filter_fmu)
        connections.insert(0, Connection(PLANT, ALIGNMENT, {name: name for name in sensed}))
        connections.append(Connection(ALIGNMENT, FILTER, handed))
        offered = list(dict.fromkeys([*handed.values(), *shown(fmu)]))
        alignment = Component(ALIGNMENT, fmu, values[ALIGNMENT], sensed, offered)
        given = {"initial.valid": False, **given}
    return System(
        **vars(plan),
        plant=Component(PLANT, source, values[PLANT], [], [*signals, *told]),
        filter=Component(FILTER, filter_fmu, given, [*signals, *handed], shown(filter_fmu)),
        alignment=alignment,
        connections=connections,
    )


def shown(fmu: Fmu) -> list[str]:
    """Outputs of general interest; none is an enumeration, which some tools do not know."""
    return [n for n in fmu.outputs() if n.startswith(SHOWN) and fmu.variables[n].kind != "Enumeration"]
