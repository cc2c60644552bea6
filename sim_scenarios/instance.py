"""FMU instances through FMPy: made, initialised, stepped, read and written, and heard.

FMPy loads the binary and expands the printf formats of log messages. FMI functions that are called in every
step are called through raw pointers with buffers made beforehand: nothing is allocated.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count, groupby
from pathlib import Path
from typing import Any, Final

import fmpy.fmi2
import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from sim_scenarios.errors import SimulationError
from sim_scenarios.fmus import Fmu, Number, Variable

Call = tuple[Callable[..., int], int, int, int]
"""Function, address and number of the references, address of the values."""

_DISCARD: Final = 2  # fmi2Discard, and everything worse

_BASE: Final = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}
_TYPES: Final = {"Real": np.float64, "Integer": np.int32, "Boolean": np.int32}
_STATUS: Final = ("ok", "warning", "discard", "error", "fatal", "pending")


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
        library, folder = str(fmu.library), Path.cwd()
        self._environment = _logger.register(self.messages)
        try:
            self._slave = fmpy.fmi2.FMU2Slave(
                guid=fmu.guid,
                modelIdentifier=fmu.model.coSimulation.modelIdentifier,
                unzipDirectory=str(fmu.folder),
                instanceName=label,
                libraryPath=library,
            )
            self._slave.instantiate(callbacks=_logger.callbacks(self._environment), loggingOn=True)
        except Exception as error:  # FMPy raises nothing more special
            os.chdir(folder)  # it stays in the folder of a library that does not load
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

    def step(self, time: float, step: float) -> None:
        """Go from time to time + step."""
        if self.do_step(self.component, time, step, 1) >= _DISCARD:
            raise self.step_failure(time)

    def step_failure(self, time: float) -> SimulationError:
        """Error of a step from a time [s] that was refused."""
        return self.failure(f"the step from {time:.6g} s")

    def read(self, names: Sequence[str]) -> list[Number]:
        """Values of scalar variables."""
        port = Port(self, names)
        port.read()
        return [port.signals.value(name) for name in names]

    def state(self) -> bytes:
        """The complete state as bytes, which another instance, in another process, can go on from."""
        state = self._slave.getFMUState()
        try:
            return bytes(self._slave.serializeFMUState(state))
        finally:
            self._slave.freeFMUState(state)

    def restore(self, state: bytes) -> None:
        """Go on from a state that `state` gave."""
        restored = self._slave.deserializeFMUState(state)
        try:
            self._slave.setFMUState(restored)
        finally:
            self._slave.freeFMUState(restored)

    @contextmanager
    def undone(self) -> Iterator[None]:
        """What the instance does and says meanwhile is as if it had not been."""
        said, state = len(self.messages), self._slave.getFMUState()
        try:
            yield
        finally:
            self._slave.setFMUState(state)
            self._slave.freeFMUState(state)
            del self.messages[said:]

    def close(self) -> None:
        """Terminate and free the instance."""
        self._slave.freeInstance()
        _logger.forget(self._environment)

    def failure(self, action: str) -> SimulationError:
        """Error that tells what the FMU said last."""
        said = [m.text for m in self.messages if m.status in ("error", "fatal")]
        reason = re.sub(r"^fmi2\w+: ", "", said[-1]) if said else "it gives no reason"
        return SimulationError(
            f"{self.label} ({self.fmu.name}) failed in {action}: {self.fmu.readable(reason)}"
        )

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
        except FMICallException:
            raise self.failure("initialisation") from None


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

    Attributes
    ----------
    getters, setters : list of Call
        For each base type, in the order of the buffers.
    """

    def __init__(self, instance: Instance, names: Sequence[str], signals: Signals | None = None) -> None:
        variables = [instance.fmu.variables[name] for name in names]
        self.instance = instance
        self._names = list(names)
        self.signals = signals or Signals(variables)
        references: dict[str, list[int]] = {base: [] for base in self.signals.buffers}
        for variable in variables:
            references[_BASE[variable.kind]].append(variable.reference)
        self._references = {base: np.array(r, dtype=np.uint32) for base, r in references.items()}
        self.getters = self._calls("Get")
        self.setters = self._calls("Set")

    def read(self) -> None:
        """Variables into the buffers."""
        component = self.instance.component
        for function, references, size, buffer in self.getters:
            if function(component, references, size, buffer) >= _DISCARD:
                raise self.failure("reading")

    def write(self) -> None:
        """Buffers into the variables."""
        component = self.instance.component
        for function, references, size, buffer in self.setters:
            if function(component, references, size, buffer) >= _DISCARD:
                raise self.failure("setting")

    def read_into(self, addresses: Iterable[int]) -> None:
        """Variables into memory at given addresses, one for each base type in the order of the buffers."""
        component = self.instance.component
        for (function, references, size, _), address in zip(self.getters, addresses, strict=True):
            if function(component, references, size, address) >= _DISCARD:
                raise self.failure("reading")

    def setters_by_sensor(self) -> Iterator[tuple[NDArray[Any], Call]]:
        """Calls that set the variables of one sensor and one base type, and their part of a buffer."""
        bases: dict[str, list[str]] = {base: [] for base in self.signals.buffers}
        for name, (base, _) in self.signals.places.items():
            bases[base].append(name.partition(".")[0])
        for (base, buffer), call in zip(self.signals.buffers.items(), self.setters, strict=True):
            function, references, _, address = call
            begin = 0
            for _, names in groupby(bases[base]):
                size = len(list(names))
                part = buffer[begin : begin + size]
                at = references + begin * self._references[base].itemsize
                yield part, (function, at, size, address + begin * buffer.itemsize)
                begin += size

    def failure(self, action: str) -> SimulationError:
        """Error of an access that was refused, by what was done."""
        return self.instance.failure(f"{action} {', '.join(self._names[:3])} ...")

    def _calls(self, verb: str) -> list[Call]:
        buffers = self.signals.buffers
        return [
            (self.instance.accessor(verb + base), r.ctypes.data, len(r), buffers[base].ctypes.data)
            for base, r in self._references.items()
        ]


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
