"""Reference results of a system: what each component takes and puts out, step by step.

All components step at once from the values at the beginning of the step (Jacobi), as the masters of other
tools do.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.compiled import Loop
from sim_scenarios.cosimulation import AlignmentSource, FmuSource, Sink, Source, Table
from sim_scenarios.exchange.forms import Entry
from sim_scenarios.exchange.start_values import text
from sim_scenarios.exchange.system import Component, Connection, System
from sim_scenarios.fmus import Number, Variable
from sim_scenarios.instance import Instance, Port
from sim_scenarios.stepping import Order

Columns = Mapping[str, NDArray[Any]]
OUTPUT_INTERVAL = 1.0
"""Between two rows of the outputs [s]; inputs have a row for each step."""

ENDLESS = 1e9
"""Longer than any experiment [s]."""


@dataclass(frozen=True)
class Results:
    """What a component took and put out.

    Attributes
    ----------
    inputs, outputs : mapping of str to ndarray
        Columns by name, the first being the time; `inputs` is empty for what has none.
    state : bytes
        Of the FMI 2 instance at the end.
    """

    inputs: Columns
    outputs: Columns
    state: bytes


def simulate(system: System) -> dict[str, Results]:
    """Run a system; the results of its components by their names.

    The FMUs are not told when the experiment ends, so that an importer may go on from their last states.
    """
    times = system.step * np.arange(round(system.checked / system.step) + 1)
    every = max(1, round(OUTPUT_INTERVAL / system.step))
    rows = (len(times) - 1) // every + 1
    with ExitStack() as stack:
        by_name = {
            c.name: stack.enter_context(closing(Instance(c.fmu, c.name, c.values))) for c in system.components
        }
        source, sink = _connected(system, by_name)
        signals = [
            Table(Port(by_name[c.start], list(c.outputs.values())), len(times)) for c in system.connections
        ]
        outputs = {c.name: Table(Port(by_name[c.name], c.outputs), rows) for c in system.components}
        for table in (*signals, *outputs.values()):
            table.append()
        for step, (time, end) in enumerate(pairwise(times.tolist()), start=1):
            sink.receive()
            source.advance(time, end - time)
            sink.advance(time, end - time)
            for table in signals:
                table.append()
            if step % every == 0:
                for table in outputs.values():
                    table.append()
        inputs: dict[str, dict[str, NDArray[Any]]] = {c.name: {} for c in system.components}
        for connection, table in zip(system.connections, signals, strict=True):
            columns = table.columns()
            inputs[connection.end] |= {name: columns[output] for name, output in connection.outputs.items()}
        states = {name: instance.state() for name, instance in by_name.items()}
        shown = {name: {"time": times[::every], **table.columns()} for name, table in outputs.items()}
    return {
        name: Results({"time": times, **inputs[name]} if inputs[name] else {}, shown[name], states[name])
        for name in shown
    }


def _connected(system: System, instances: Mapping[str, Instance]) -> tuple[Source, Sink]:
    """Instances of a system, initialised and connected: what makes the signals, and the filter."""

    def begun(component: Component, source: Source) -> Sink:
        return Sink.initialised(instances[component.name], source, 0.0, ENDLESS)

    plant, fed = instances[system.plant.name], system.alignment or system.filter
    plant.begin_initialisation(0.0, ENDLESS)
    plant.finish_initialisation()
    (signals,) = (c.outputs for c in system.connections if (c.start, c.end) == (system.plant.name, fed.name))
    source = FmuSource(plant, list(signals.values()), _driver(system, instances))
    if system.alignment is None:
        return source, begun(system.filter, source)
    aligned = AlignmentSource(source, begun(fed, source), system.filter.fmu, Order.jacobi)
    return aligned, begun(system.filter, aligned)


class _Driver:
    """A vehicle that feeds a plant with what it puts out at the beginning of a step, and steps itself."""

    def __init__(self, vehicle: Instance, plant: Instance, connection: Connection) -> None:
        self._vehicle = vehicle
        self._outputs = Port(vehicle, list(connection.outputs.values()))
        self._inputs = Port(plant, list(connection.outputs), self._outputs.signals)

    def tell(self, time: float, step: float) -> None:
        """All components step at once."""
        self._outputs.read()
        self._inputs.write()
        self._vehicle.step(time, step)

    def tell_in(self, loop: Loop) -> None:
        """As `tell`, in a compiled loop."""
        loop.read(self._outputs)
        loop.write(self._inputs)
        loop.step(self._vehicle)


def _driver(system: System, instances: Mapping[str, Instance]) -> _Driver | None:
    """What moves the plant, initialised; None if it moves by itself."""
    if system.vehicle is None:
        return None
    vehicle = instances[system.vehicle.name]
    vehicle.begin_initialisation(0.0, ENDLESS)
    vehicle.finish_initialisation()
    (connection,) = (c for c in system.connections if c.start == system.vehicle.name)
    return _Driver(vehicle, instances[system.plant.name], connection)


def csv(columns: Columns, entries: Sequence[Entry], *, words: bool = False) -> str:
    """Columns as text that reads back to the same bits; elements of an array stand in one column.

    The form is that of the FMI cross-check, which fmusim and FMPy extend to arrays. `words`: Booleans are
    true and false, as fmusim reads them in FMI 3.
    """
    header = [f'"{entry.name}"' if "," in entry.name else entry.name for entry in entries]
    cells = [_cells(entry, columns, words and entry.kind == "Boolean") for entry in entries]
    rows = zip(map(repr, columns["time"].tolist()), *cells, strict=True)
    return "\n".join([",".join(["time", *header]), *map(",".join, rows), ""])


def _cells(entry: Entry, columns: Columns, words: bool) -> Iterator[str]:
    written = _word if words else text
    elements = [[written(e, value) for value in columns[e.name].tolist()] for e in entry.elements]
    return map(" ".join, zip(*elements, strict=True))


def _word(_: Variable, value: Number) -> str:
    return "true" if value else "false"
