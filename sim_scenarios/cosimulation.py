"""Co-simulation master: one source of signals, any number of filters that consume them.

The source (the TruthPlant FMU, or a recording) and every filter advance by the same communication steps;
outputs of the source are connected to the inputs of equal name. Two orders are offered (FMI 2.0.4, 4.2.1):

Gauss-Seidel
    source steps to t + h, filters receive its outputs at t + h, filters step to t + h.
Jacobi
    filters receive the source's outputs at t, then all step to t + h: the same result, one step late.

Within a step nothing is allocated: FMI functions are called through raw pointers with buffers made
beforehand.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import count, pairwise
from typing import Any, Final, Protocol

import fmpy.fmi2
import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmu, Number, Variable

Array = NDArray[np.float64]
Progress = Callable[[float], None]
"""Called with the completed share, 0 to 1."""

DISCARD: Final = 2  # fmi2Discard, and everything worse

_BASE: Final = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}
_TYPES: Final = {"Real": np.float64, "Integer": np.int32, "Boolean": np.int32}
_STATUS: Final = ("ok", "warning", "discard", "error", "fatal", "pending")


class Order(str, Enum):
    """Who steps first."""

    gauss_seidel = "gauss-seidel"
    jacobi = "jacobi"


@dataclass(frozen=True)
class Message:
    """What an FMU said."""

    instance: str
    status: str
    category: str
    text: str

    def __str__(self) -> str:
        """The text, with who said it."""
        return f"{self.instance}: {self.text}"


class Instance:
    """A living FMU instance.

    Parameters
    ----------
    fmu : Fmu
    label : str
        Name of the instance in messages.
    values : mapping of str to number
        Parameters by scalar name, in the FMU's units.
    """

    def __init__(self, fmu: Fmu, label: str, values: Mapping[str, Number]) -> None:
        self.fmu = fmu
        self.label = label
        self.messages: list[Message] = []
        self._environment = _logger.register(self.messages)
        try:
            self._slave = fmpy.fmi2.FMU2Slave(
                guid=fmu.guid,
                modelIdentifier=fmu.model.coSimulation.modelIdentifier,
                unzipDirectory=str(fmu.folder),
                instanceName=label,
            )
            self._slave.instantiate(callbacks=_logger.callbacks(self._environment), loggingOn=True)
        except Exception as error:  # FMPy raises nothing more special
            _logger.forget(self._environment)
            raise SimulationError(f"{fmu.path} cannot be instantiated: {error}") from error
        self.component = ctypes.c_void_p(self._slave.component)
        self.do_step = self._raw("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self.set_values(values)

    def set_values(self, values: Mapping[str, Number]) -> None:
        """Set scalar variables by name."""
        if values:
            port = Port(self, list(values))
            port.signals.assign(list(values.values()))
            port.write()

    def begin_initialisation(self, start: float, stop: float) -> None:
        """Set up the experiment and enter the initialisation mode: parameters are checked, outputs valid."""
        self._call(lambda: self._slave.setupExperiment(startTime=start, stopTime=stop))
        self._call(self._slave.enterInitializationMode)

    def finish_initialisation(self) -> None:
        """Leave the initialisation mode."""
        self._call(self._slave.exitInitializationMode)

    def read(self, names: Sequence[str]) -> list[Number]:
        """Values of scalar variables."""
        port = Port(self, names)
        port.read()
        return [port.signals.value(name) for name in names]

    def close(self) -> None:
        """Terminate and free the instance."""
        self._slave.freeInstance()
        _logger.forget(self._environment)

    def failure(self, action: str) -> SimulationError:
        """Error that tells what the FMU said last."""
        said = [m.text for m in self.messages if m.status in ("error", "fatal")]
        reason = said[-1] if said else "it gives no reason"
        return SimulationError(f"{self.label} ({self.fmu.name}) failed in {action}: {reason}")

    def accessor(self, access: str) -> Callable[..., int]:
        """Raw function such as fmi2GetReal(component, references, count, values)."""
        return self._raw(f"fmi2{access}", ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)

    def _raw(self, name: str, *types: Any) -> Callable[..., int]:
        function = self._slave.dll[name]
        function.argtypes = (ctypes.c_void_p, *types)
        function.restype = ctypes.c_int
        raw: Callable[..., int] = function
        return raw

    def _call(self, action: Callable[[], object]) -> None:
        try:
            action()
        except FMICallException as error:
            raise self.failure(error.function) from None


class Signals:
    """Current values of scalar variables, those of one base type side by side in one array.

    Attributes
    ----------
    names : list of str
    places : dict of str to (str, int)
        Base type and index in its buffer, by name.
    buffers : dict of str to ndarray
        One array for each base type (Real, Integer, Boolean).
    """

    def __init__(self, variables: Sequence[Variable]) -> None:
        self.names = [v.name for v in variables]
        self.places: dict[str, tuple[str, int]] = {}
        sizes: dict[str, int] = {}
        for variable in variables:
            base = _BASE[variable.kind]
            self.places[variable.name] = (base, sizes.get(base, 0))
            sizes[base] = sizes.get(base, 0) + 1
        self.buffers = {base: np.zeros(size, _TYPES[base]) for base, size in sizes.items()}

    def assign(self, values: Sequence[Number]) -> None:
        """Set all values, in the order of the names."""
        for name, value in zip(self.names, values, strict=True):
            base, index = self.places[name]
            self.buffers[base][index] = value

    def value(self, name: str) -> Number:
        """One value."""
        base, index = self.places[name]
        number: Number = self.buffers[base][index].item()
        return number


class Port:
    """Variables of an instance that are read or written together, through buffers made once.

    A port that is given the signals of another writes what the other has read.
    """

    def __init__(self, instance: Instance, names: Sequence[str], signals: Signals | None = None) -> None:
        variables = [instance.fmu.variables[name] for name in names]
        self.instance = instance
        self.signals = signals or Signals(variables)
        references: dict[str, list[int]] = {base: [] for base in self.signals.buffers}
        for variable in variables:
            references[_BASE[variable.kind]].append(variable.reference)
        self._references = {base: np.array(r, dtype=np.uint32) for base, r in references.items()}
        self._getters = self._calls("Get")
        self._setters = self._calls("Set")

    def read(self) -> None:
        """Variables into the buffers."""
        component = self.instance.component
        for function, references, size, buffer in self._getters:
            if function(component, references, size, buffer) >= DISCARD:
                raise self._failure("reading")

    def write(self) -> None:
        """Buffers into the variables."""
        component = self.instance.component
        for function, references, size, buffer in self._setters:
            if function(component, references, size, buffer) >= DISCARD:
                raise self._failure("setting")

    def read_into(self, addresses: Iterable[int]) -> None:
        """Variables into memory at given addresses, one for each base type in the order of the buffers."""
        component = self.instance.component
        for (function, references, size, _), address in zip(self._getters, addresses, strict=True):
            if function(component, references, size, address) >= DISCARD:
                raise self._failure("reading")

    def _calls(self, verb: str) -> list[tuple[Callable[..., int], int, int, int]]:
        buffers = self.signals.buffers
        return [
            (self.instance.accessor(verb + base), r.ctypes.data, len(r), buffers[base].ctypes.data)
            for base, r in self._references.items()
        ]

    def _failure(self, action: str) -> SimulationError:
        return self.instance.failure(f"{action} {', '.join(self.signals.names[:3])} ...")


class Table:
    """Values of a port over time, written row by row into arrays made beforehand."""

    def __init__(self, port: Port, rows: int) -> None:
        self.port = port
        self.rows = 0
        self.arrays = {base: np.empty((rows, len(b)), b.dtype) for base, b in port.signals.buffers.items()}
        self._addresses = [array.ctypes.data for array in self.arrays.values()]
        self._strides = [array.strides[0] for array in self.arrays.values()]

    def append(self) -> None:
        """Read the port into the next row."""
        self.port.read_into(self._addresses)
        self._addresses = [a + stride for a, stride in zip(self._addresses, self._strides, strict=True)]
        self.rows += 1

    def columns(self) -> dict[str, NDArray[Any]]:
        """Recorded values of each variable, shape (rows,)."""
        places = self.port.signals.places
        return {name: self.arrays[base][: self.rows, i].copy() for name, (base, i) in places.items()}


class Source(Protocol):
    """Where the signals come from."""

    signals: Signals
    """The current ones."""

    @property
    def instance(self) -> Instance | None:
        """The FMU behind the signals, if there is one: what it knows besides can be recorded."""

    def advance(self, time: float, step: float) -> None:
        """Go from time to time + step and renew the signals."""


class FmuSource:
    """Signals from the outputs of an initialised FMU."""

    def __init__(self, instance: Instance, names: Sequence[str]) -> None:
        self.instance = instance
        self.port = Port(instance, names)
        self.signals = self.port.signals
        self.port.read()

    def advance(self, time: float, step: float) -> None:
        """Step the FMU and read its outputs."""
        instance = self.instance
        if instance.do_step(instance.component, time, step, 1) >= DISCARD:
            raise instance.failure(f"the step from {time:.6g} s")
        self.port.read()


class RecordedSource:
    """Signals from arrays.

    Parameters
    ----------
    variables : sequence of Variable
        The inputs that consume the signals.
    columns : mapping of str to ndarray, shape (n + 1,)
        Values at the start and after each of n steps, by scalar name.
    """

    instance = None

    def __init__(self, variables: Sequence[Variable], columns: Mapping[str, NDArray[Any]]) -> None:
        self.signals = Signals(variables)
        rows = {
            base: np.column_stack([columns[n] for n, (b, _) in self.signals.places.items() if b == base])
            for base in self.signals.buffers
        }
        self._rows = [
            (buffer, rows[base].astype(buffer.dtype)) for base, buffer in self.signals.buffers.items()
        ]
        self._next = 0
        self.advance(0.0, 0.0)

    def advance(self, time: float, step: float) -> None:  # noqa: ARG002  (a recording has its own clock)
        """Next row of every array."""
        for buffer, rows in self._rows:
            buffer[:] = rows[self._next]
        self._next += 1


class Sink:
    """A filter that consumes signals."""

    def __init__(self, instance: Instance, source: Source) -> None:
        self.instance = instance
        self.port = Port(instance, source.signals.names, source.signals)

    def receive(self) -> None:
        """Take the current signals."""
        self.port.write()

    def advance(self, time: float, step: float) -> None:
        """Step the filter."""
        instance = self.instance
        if instance.do_step(instance.component, time, step, 1) >= DISCARD:
            raise instance.failure(f"the step from {time:.6g} s")


@dataclass(frozen=True)
class Recorded:
    """What a simulation recorded.

    Attributes
    ----------
    time : ndarray
        Master times of the signals that the filters had consumed at each periodic row [s].
    fix_time : ndarray
        Times of validity of the fixes that the filters received [s].
    truth : Table or None
        Outputs of the source's FMU at `time`.
    filters, fixes : list of Table
        Outputs of each filter, periodically and after each fix.
    """

    time: Array
    fix_time: Array
    truth: Table | None
    filters: list[Table]
    fixes: list[Table]


def connected(source: Iterable[str], sink: Fmu) -> list[str]:
    """Inputs of a filter, each of which the source must have."""
    available = set(source)
    if missing := [name for name in sink.inputs() if name not in available]:
        raise InputError(f"nothing is connected to the inputs {', '.join(missing)} of {sink.name}")
    return sink.inputs()


def simulate(
    source: Source,
    sinks: Sequence[Sink],
    times: Array,
    *,
    record_every: int,
    source_outputs: Sequence[str] = (),
    fix_outputs: Sequence[str] = (),
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
) -> Recorded:
    """Step source and filters through all times, recording on the way.

    Parameters
    ----------
    source : Source
        Plant or recording, initialised.
    sinks : sequence of Sink
        Filters, all instances of one FMU, initialised.
    times : ndarray, shape (n + 1,)
        Communication points [s].
    record_every : int
        Steps between periodic rows.
    source_outputs : sequence of str
        Outputs of the source's FMU to record.
    fix_outputs : sequence of str
        Outputs of the filters that are recorded at each fix rather than periodically.
    order : Order
        Who steps first.
    progress : callable
        Called at each periodic row.

    Returns
    -------
    Recorded
    """
    steps = len(times) - 1
    rows = steps // record_every + 1
    periodic = [name for name in sinks[0].instance.fmu.outputs() if name not in set(fix_outputs)]
    truth = Table(Port(source.instance, source_outputs), rows) if source.instance else None
    filters = [Table(Port(sink.instance, periodic), rows) for sink in sinks]
    fixes = [Table(Port(sink.instance, fix_outputs), steps) for sink in sinks]
    recorded_at, fixes_at = [float(times[0])], []
    for table in (*([truth] if truth else []), *filters):
        table.append()

    (base, counter), (_, fix_time) = source.signals.places["gnss.sample"], source.signals.places["gnss.time"]
    integers, reals = source.signals.buffers[base], source.signals.buffers["Real"]
    fix_count = integers[counter]
    clock = times.tolist()
    late = order is Order.jacobi
    until_row = record_every
    for time, end in pairwise(clock):
        step = end - time
        if not late:
            source.advance(time, step)
        for sink in sinks:
            sink.receive()
        until_row -= 1
        is_fix = integers[counter] != fix_count
        if is_fix:
            fix_count = integers[counter]
            fixes_at.append(float(reals[fix_time]))
        if until_row == 0:
            recorded_at.append(time if late else end)
            if truth:
                truth.append()
        if late:
            source.advance(time, step)
        for sink in sinks:
            sink.advance(time, step)
        if is_fix:
            for table in fixes:
                table.append()
        if until_row == 0:
            until_row = record_every
            for table in filters:
                table.append()
            progress(len(recorded_at) / rows)
    return Recorded(np.array(recorded_at), np.array(fixes_at), truth, filters, fixes)


class _Logger:
    """The one logger of a process: FMPy's proxy, which expands printf formats, calls a single function.

    Messages find their instance's list through the component environment, a number handed to the FMU.
    """

    def __init__(self) -> None:
        self._lists: dict[int | None, list[Message]] = {}
        self._numbers = count(1)
        self._function = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._log)

    def register(self, messages: list[Message]) -> int:
        number = next(self._numbers)
        self._lists[number] = messages
        return number

    def forget(self, number: int) -> None:
        self._lists.pop(number, None)

    def callbacks(self, number: int) -> Any:
        struct = fmpy.fmi2.fmi2CallbackFunctions()
        struct.logger = self._function
        struct.allocateMemory = fmpy.fmi2.defaultCallbacks.allocateMemory
        struct.freeMemory = fmpy.fmi2.defaultCallbacks.freeMemory
        struct.componentEnvironment = number
        fmpy.fmi2.addLoggerProxy(ctypes.byref(struct))
        return struct

    def _log(
        self, environment: int | None, instance: bytes, status: int, category: bytes, text: bytes
    ) -> None:
        if environment in self._lists:
            self._lists[environment].append(
                Message(
                    instance=instance.decode("utf-8", "replace"),
                    status=_STATUS[status],
                    category=(category or b"").decode("utf-8", "replace"),
                    text=text.decode("utf-8", "replace"),
                )
            )
        else:  # an instance that other code made through FMPy
            fmpy.fmi2.printLogMessage(environment, instance, status, category, text)


_logger = _Logger()
