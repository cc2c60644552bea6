"""Reference results of a system: what each component takes and puts out, step by step.

All components step at once from the values at the beginning of the step (Jacobi), as the masters of other
tools do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Order, Table
from sim_scenarios.exchange.system import System
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Port
from sim_scenarios.scenario import Scenario
from sim_scenarios.simulation import connect

Columns = Mapping[str, NDArray[Any]]
OUTPUT_INTERVAL = 1.0
"""Between two rows of the outputs [s]; inputs have a row for each step."""


@dataclass(frozen=True)
class Results:
    """Columns by name, the first being the time; `inputs` is empty for what has none."""

    inputs: Columns
    outputs: Columns


def simulate(scenario: Scenario, fmus: Fmus, system: System) -> dict[str, Results]:
    """Run a system; the results of its components by their names."""
    times = system.step * np.arange(round(system.stop / system.step) + 1)
    every = max(1, round(OUTPUT_INTERVAL / system.step))
    rows = (len(times) - 1) // every + 1
    with ExitStack() as stack:
        source, (sink,) = connect(scenario, fmus, {system.filter.name: scenario.filter}, stack, Order.jacobi)
        instances = (source.instance, *([source.alignment] if source.alignment else []), sink.instance)
        by_name = dict(zip((c.name for c in system.components), instances, strict=True))
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
        shown = {name: {"time": times[::every], **table.columns()} for name, table in outputs.items()}
    return {
        name: Results({"time": times, **inputs[name]} if inputs[name] else {}, shown[name]) for name in shown
    }


def csv(columns: Columns) -> str:
    """Columns as text that reads back to the same bits."""
    header = ",".join(f'"{name}"' if "," in name else name for name in columns)
    rows: Sequence[tuple[object, ...]] = list(
        zip(*(column.tolist() for column in columns.values()), strict=True)
    )
    return "\n".join([header, *(",".join(map(repr, row)) for row in rows), ""])
