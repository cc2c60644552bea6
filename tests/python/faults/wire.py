"""Faults put on the wire between a source of signals and filters, whatever the source."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import connection, simulation
from sim_scenarios.cosimulation import FmuSource, RecordedSource, Sink
from sim_scenarios.fmus import Fmu, Fmus, Number
from sim_scenarios.instance import Instance, Message, Signals
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Order

Array = NDArray[np.float64]
AXES = ("[1]", "[2]", "[3]")
STATUS = {
    name: number
    for number, name in enumerate(
        (
            "waiting",
            "aligning",
            "converged",
            "coasting",
            "faulted",
            "coarse",
            "inconsistent",
            "silent",
            "suspect",
            "recovering",
        ),
        start=1,
    )
}


class Wire:
    """The current signals by name: `wire["imu.time"] += 1.0`."""

    def __init__(self, signals: Signals) -> None:
        self._signals = signals

    def __getitem__(self, name: str) -> float:
        base, index = self._signals.places[name]
        return float(self._signals.buffers[base][index])

    def __setitem__(self, name: str, value: float) -> None:
        base, index = self._signals.places[name]
        self._signals.buffers[base][index] = value

    def vector(self, name: str) -> Array:
        return np.array([self[name + axis] for axis in AXES])

    def put(self, name: str, values: Array) -> None:
        for axis, value in zip(AXES, values, strict=True):
            self[name + axis] = value

    def imu(self) -> dict[str, float]:
        return {name: self[name] for name in self._signals.names if name.startswith("imu.")}

    def gnss(self) -> dict[str, float]:
        return {name: self[name] for name in self._signals.names if name.startswith("gnss.")}

    def restore(self, values: Mapping[str, float]) -> None:
        for name, value in values.items():
            self[name] = value


Fault = Callable[[float, Wire], None]
"""Changes the signals of a communication point; called at each, with its time."""


class Disturbed:
    """A source whose signals pass a fault on their way."""

    alignment = None

    def __init__(self, source: FmuSource | RecordedSource, fault: Fault) -> None:
        self.instance = source.instance
        self.signals = source.signals
        self._source, self._fault, self._wire = source, fault, Wire(source.signals)

    def advance(self, time: float, step: float) -> None:
        self._source.advance(time, step)
        self._fault(time + step, self._wire)


def run(
    scenario: str,
    fmus: Fmus,
    fault: Fault,
    *,
    seed: int = 2,
    settings: Mapping[str, Any] | None = None,
    order: Order = Order.gauss_seidel,
) -> xr.Dataset:
    """A scenario with a fault; messages of the filter are the attribute `messages`."""
    loaded = load_scenario(scenario, fmus, seed=seed, settings=dict(settings or {}))
    with ExitStack() as stack:
        source, sinks = connection.connect(loaded, fmus, {"filter": dict(loaded.filter)}, stack, order)
        assert isinstance(source, FmuSource)
        disturbed = Disturbed(source, fault)
        recorded = connection.record(loaded, fmus, disturbed, sinks, order)
        data = simulation.dataset(recorded, loaded, fmus, ["filter"])
        data.attrs["messages"] = [message.text for message in sinks[0].instance.messages]
    return data.squeeze("filter") if "filter" in data.dims else data


class Fed:
    """A filter that is fed with columns by hand, one row a step; outputs are read after each step."""

    def __init__(self, fmu: Fmu, columns: Mapping[str, NDArray[Any]], values: Mapping[str, Number]) -> None:
        inputs = [v for name, v in fmu.variables.items() if v.causality == "input" and name in columns]
        self.source = RecordedSource(inputs, columns)
        self.fmu, self.values = fmu, values

    def run(
        self, clock: Array, outputs: list[str], fault: Fault = lambda _, __: None, every: int = 1
    ) -> tuple[dict[str, Array], list[Message]]:
        """Outputs over the communication points `clock`, shape (n / every + 1,), and what the filter said."""
        from sim_scenarios.cosimulation import Table
        from sim_scenarios.instance import Port

        instance = Instance(self.fmu, "filter", self.values)
        try:
            instance.begin_initialisation(float(clock[0]), float(clock[-1]))
            source = Disturbed(self.source, fault)
            sink = Sink(instance, source)
            sink.receive()
            instance.finish_initialisation()
            table = Table(Port(instance, outputs), (len(clock) - 1) // every + 1)
            table.append()
            for row, (time, end) in enumerate(zip(clock[:-1].tolist(), clock[1:].tolist(), strict=True), 1):
                source.advance(time, end - time)
                sink.receive()
                sink.advance(time, end - time)
                if row % every == 0:
                    table.append()
            return table.columns(), list(instance.messages)
        finally:
            instance.close()
