"""The loop of a co-simulation as compiled code (`fmu_src/runner`): the results of the Python master, sooner.

Python loads, initialises and frees the FMUs, and writes down what is done in a step: a list of operations
with the addresses of functions, variables and memory. The library carries it out, step after step, and
returns now and then, so that a run can be followed and interrupted. An operation that an FMU refuses is told
by its place in the list; the sentence is that of the Python master.

The library lies beside the FMUs of this package, in `fmus/runner/<platform>`, of a checkout in
`build/fmus/runner/<platform>`. Where there is none for this machine, the Python master steps.
"""

from __future__ import annotations

import ctypes
import platform
from collections.abc import Callable
from enum import IntEnum
from functools import cache
from typing import Any, Final, Protocol

import fmpy
import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import own_folders
from sim_scenarios.instance import Call, Instance, Port
from sim_scenarios.stepping import Master

Array = NDArray[np.float64]
NextRows = Callable[[int, Array], NDArray[Any]]
"""Rows for n steps or more, by the number of the first step and the communication points, shape (n + 1,)."""

GIVEN: Final = 1000
"""Steps for which rows are made at once."""
AT_ONCE: Final = 50
"""Steps from one return to Python to the next: few, since an FMU of somebody else's may be slow."""
_DOUBLE: Final = 8  # bytes
_FUNCTION: Final = "truenorth_run_2"


class _Kind(IntEnum):
    step = 0
    access = 1
    renew = 2
    gather = 3
    add = 4
    look = 5


class When(IntEnum):
    """In which steps an operation is carried out."""

    always = 0
    at_row = 1
    at_fix = 2


class Rows(Protocol):
    """Values of a port over time."""

    port: Port
    arrays: dict[str, NDArray[Any]]
    rows: int


class _Operation(ctypes.Structure):
    _fields_ = (
        ("kind", ctypes.c_int32),
        ("when", ctypes.c_int32),
        ("step", ctypes.c_void_p),
        ("access", ctypes.c_void_p),
        ("component", ctypes.c_void_p),
        ("references", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
        ("values", ctypes.c_void_p),
        ("signals", ctypes.c_void_p),
        ("last", ctypes.c_void_p),
        ("size", ctypes.c_size_t),
        ("values_stride", ctypes.c_size_t),
        ("signals_stride", ctypes.c_size_t),
    )


class _Loop(ctypes.Structure):
    _fields_ = (
        ("operations", ctypes.POINTER(_Operation)),
        ("count", ctypes.c_size_t),
        ("times", ctypes.c_void_p),
        ("done", ctypes.c_size_t),
        ("steps_per_row", ctypes.c_size_t),
        ("fixes", ctypes.c_size_t),
        ("fix_count", ctypes.c_int32),
    )


@cache
def _library() -> Any:
    """The library's function; None if there is none, or that of another version of this package."""
    for folder in own_folders():
        path = folder / "runner" / fmpy.platform_tuple / f"truenorth_runner{fmpy.sharedLibraryExtension}"
        if path.is_file():
            try:
                function = ctypes.CDLL(str(path))[_FUNCTION]
            except (OSError, AttributeError):
                return None
            function.restype = ctypes.c_ssize_t
            function.argtypes = (ctypes.POINTER(_Loop), ctypes.c_size_t)
            return function
    return None


def steps(master: Master) -> bool:
    """Whether the compiled loop steps, rather than Python.

    Raises
    ------
    InputError
        It was asked for and is not there.
    """
    there = master is not Master.python and _library() is not None
    if master is Master.compiled and not there:
        raise InputError(
            f"master = compiled: there is no compiled loop for {platform.system()} on {platform.machine()}; "
            "run `make fmus` to build it"
        )
    return there


class Loop:
    """What is done in a step, in the order in which it is added."""

    def __init__(self) -> None:
        self._operations: list[_Operation] = []
        self._failures: list[Callable[[float], SimulationError]] = []
        self._tables: list[tuple[Rows, When]] = []
        self._rows: list[tuple[int, str, NextRows, Any]] = []
        self._memory: list[NDArray[Any]] = []  # which operations refer to

    def step(self, instance: Instance) -> None:
        """Step an FMU."""
        address = _address(instance.do_step)
        self._add(_Kind.step, instance.step_failure, step=address, component=instance.component)

    def read(self, port: Port) -> None:
        """Variables into the buffers of a port."""
        for call in port.getters:
            self._access(port, "reading", call)

    def write(self, port: Port) -> None:
        """Buffers of a port into its variables, as far as they have changed: those of a sensor together."""
        for part, call in port.setters_by_sensor():
            last = np.empty_like(part)
            self._memory.append(last)
            self._access(port, "setting", call, _Kind.renew, last=last.ctypes.data, size=part.itemsize)

    def write_rows(self, port: Port, rows: NextRows) -> None:
        """A row for each step into the variables of a port, all of them Real."""
        (call,) = port.setters
        self._rows.append((len(self._operations), "values", rows, np.float64))
        self._access(port, "setting", call, values_stride=_DOUBLE * len(port.signals.names))

    def gather(self, values: NDArray[Any], signals: NDArray[Any], places: NDArray[np.integer[Any]]) -> None:
        """As `values[:] = signals[places]`."""
        self._gather(values, signals, places)

    def gather_rows(self, values: NDArray[Any], rows: NextRows) -> None:
        """As `values[:] = row`, with a row for each step."""
        self._rows.append((len(self._operations), "signals", rows, values.dtype))
        self._gather(values, values, np.arange(len(values)), signals_stride=values.nbytes)

    def add_rows(self, values: Array, places: NDArray[np.integer[Any]], rows: NextRows) -> None:
        """As `values[places] += row`, with a row for each step."""
        if values.dtype != np.float64:
            raise TypeError(f"nothing can be added to signals of type {values.dtype}")
        self._rows.append((len(self._operations), "signals", rows, np.float64))
        self._gather(values, values, places, kind=_Kind.add, signals_stride=_DOUBLE * len(places))

    def note(self, values: NDArray[Any], signals: NDArray[Any], place: int) -> None:
        """A signal into the next value of an array, at each fix."""
        self._gather(values, signals, np.array([place]), when=When.at_fix, values_stride=values.itemsize)

    def append(self, table: Rows, when: When) -> None:
        """The variables of a table into its next row."""
        self._tables.append((table, when))
        for (function, references, count, _), array in zip(
            table.port.getters, table.arrays.values(), strict=True
        ):
            stride = array.strides[0]
            first = array.ctypes.data + table.rows * stride
            self._access(
                table.port, "reading", (function, references, count, first), when=when, values_stride=stride
            )

    def look(self, signals: NDArray[Any], counter: int) -> None:
        """See whether a fix came, for what follows."""
        self._counter = signals[counter : counter + 1]
        self._add(_Kind.look, None, signals=self._counter.ctypes.data)

    def run(self, times: Array, steps_per_row: int, progress: Callable[[float], None]) -> int:
        """Go through all steps.

        Parameters
        ----------
        times : ndarray, shape (n + 1,)
            Communication points [s].
        steps_per_row : int
            Steps from one periodic row to the next.
        progress : callable
            Called with the completed share, now and then.

        Returns
        -------
        int
            Number of fixes that came.

        Raises
        ------
        SimulationError
            An FMU refused to go on.
        """
        function, operations = _library(), (_Operation * len(self._operations))(*self._operations)
        times = np.ascontiguousarray(times, np.float64)
        fix_count = int(self._counter[0])
        loop = _Loop(operations, len(operations), times.ctypes.data, 0, steps_per_row, 0, fix_count)
        end = len(times) - 1
        for begin in range(0, end, GIVEN):
            until = min(begin + GIVEN, end)
            held = [  # alive as long as operations refer to them
                self._given(
                    operations[place], part, rows(begin, times[begin : until + 1]), dtype, until - begin
                )
                for place, part, rows, dtype in self._rows
            ]
            for slice_end in range(begin + AT_ONCE, until + AT_ONCE, AT_ONCE):
                refused = function(loop, min(slice_end, until))
                if refused >= 0:
                    raise self._failures[refused](float(times[loop.done]))
                progress(loop.done / end)
            del held
        for table, when in self._tables:
            table.rows += loop.fixes if when is When.at_fix else end // steps_per_row
        return int(loop.fixes)

    @staticmethod
    def _given(operation: _Operation, part: str, rows: NDArray[Any], dtype: Any, count: int) -> NDArray[Any]:
        """Rows of the next steps as the library reads them, to which the operation refers from now on."""
        if len(rows) < count:
            raise IndexError(f"there are {len(rows)} rows for {count} steps")
        given = np.ascontiguousarray(rows[:count], dtype)
        setattr(operation, part, given.ctypes.data)
        return given

    def _access(
        self, port: Port, action: str, call: Call, kind: _Kind = _Kind.access, **entries: Any
    ) -> None:
        function, references, count, values = call
        self._add(
            kind,
            lambda _time: port.failure(action),
            access=_address(function),
            component=port.instance.component,
            references=references,
            count=count,
            values=values,
            **entries,
        )

    def _gather(
        self,
        values: NDArray[Any],
        signals: NDArray[Any],
        places: NDArray[np.integer[Any]],
        kind: _Kind = _Kind.gather,
        **entries: Any,
    ) -> None:
        places = places.astype(np.uint32)
        self._memory += [values, signals, places]
        self._add(
            kind,
            None,
            references=places.ctypes.data,
            count=len(places),
            values=values.ctypes.data,
            signals=signals.ctypes.data,
            size=signals.itemsize,
            **entries,
        )

    def _add(self, kind: _Kind, failure: Any, **entries: Any) -> None:
        self._operations.append(_Operation(kind=kind, **entries))
        self._failures.append(failure)


def _address(function: Any) -> int | None:
    return ctypes.cast(function, ctypes.c_void_p).value
