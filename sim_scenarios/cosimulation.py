"""Co-simulation master: one source of signals, any number of filters that consume them.

The source (the TruthPlant FMU, or a recording) and every filter advance by the same communication steps;
outputs of the source are connected to the inputs of equal name. Two orders are offered (FMI 2.0.4, 4.2.1):

Gauss-Seidel
    source steps to t + h, filters receive its outputs at t + h, filters step to t + h.
Jacobi
    filters receive the source's outputs at t, then all step to t + h: the same result, one step late.

A source may itself be two FMUs: a plant, and an alignment that is handed over to navigation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, Final, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sim_scenarios import compiled
from sim_scenarios.compiled import Loop, When
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import OPTIONAL, START, Fmu, Variable
from sim_scenarios.instance import Instance, Port, Signals
from sim_scenarios.stepping import Master, Order

Array = NDArray[np.float64]
Columns = dict[str, NDArray[Any]]
Progress = Callable[[float], None]
"""Called with the completed share, 0 to 1."""


def part_of(progress: Progress, done: int, parts: int) -> Progress:
    """Progress of one of several equal parts, after those that are done."""
    return lambda share: progress((done + share) / parts)


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

    def columns(self) -> Columns:
        """Recorded values, shape (rows,), of each variable by name."""
        full = {base: array.T[:, : self.rows].copy() for base, array in self.arrays.items()}
        return {name: full[base][i] for name, (base, i) in self.port.signals.places.items()}


class Source(Protocol):
    """Where the signals come from."""

    signals: Signals
    """The current ones."""

    @property
    def instance(self) -> Instance | None:
        """The FMU behind the signals, if there is one: what it knows besides can be recorded."""

    @property
    def alignment(self) -> Instance | None:
        """The alignment that is handed over with the signals, if there is one."""

    def advance(self, time: float, step: float) -> None:
        """Go from time to time + step and renew the signals."""


@runtime_checkable
class InLoop(Protocol):
    """A source that a compiled loop can step, too; Python steps any other."""

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""


class Drives(Protocol):
    """What feeds inputs of a source."""

    def tell(self, time: float, step: float) -> None:
        """Set the inputs for a step from a time [s]."""

    def tell_in(self, loop: Loop) -> None:
        """As `tell`, in a compiled loop."""


class FmuSource:
    """Signals from the outputs of an initialised FMU, which something may drive."""

    alignment = None

    def __init__(self, instance: Instance, names: Sequence[str], driver: Drives | None = None) -> None:
        self.instance = instance
        self._driver = driver
        self.port = Port(instance, names)
        self.signals = self.port.signals
        self.port.read()

    def advance(self, time: float, step: float) -> None:
        """Step the FMU and read its outputs."""
        if self._driver is not None:
            self._driver.tell(time, step)
        self.instance.step(time, step)
        self.port.read()

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""
        if self._driver is not None:
            self._driver.tell_in(loop)
        loop.step(self.instance)
        loop.read(self.port)


class DisturbedSource:
    """Signals of an FMU with something added to some of them at every step.

    Parameters
    ----------
    source : FmuSource
        Whose signals they are.
    added : mapping of str to ndarray, shape (n,)
        What is added after each step, by scalar name; begins anew after n steps.
    """

    alignment = None

    def __init__(self, source: FmuSource, added: Mapping[str, Array]) -> None:
        self.instance, self.signals = source.instance, source.signals
        self._source = source
        places = {name: source.signals.places[name] for name in added}
        self._added = [(source.signals.buffers[base], i, added[name]) for name, (base, i) in places.items()]
        self._next = 0

    def advance(self, time: float, step: float) -> None:
        """Step the FMU, read its outputs and add."""
        self._source.advance(time, step)
        for buffer, i, values in self._added:
            buffer[i] += values[self._next % len(values)]
        self._next += 1

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""
        self._source.advance_in(loop)
        for buffer, i, values in self._added:
            loop.add_rows(buffer, np.array([i]), partial(_repeated, values))


def _repeated(values: Array, begin: int, times: Array) -> Array:
    repeated: Array = values.take(np.arange(begin, begin + len(times) - 1), mode="wrap")
    return repeated


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
    alignment = None

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

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""
        for buffer, rows in self._rows:
            loop.gather_rows(buffer, partial(_onwards, rows[self._next :]))


def _onwards(rows: NDArray[Any], begin: int, _: Array) -> NDArray[Any]:
    return rows[begin:]


class Sink:
    """A filter that consumes signals: those that it has inputs for.

    Parameters
    ----------
    instance : Instance
    source : Source
    outputs : sequence of str, optional
        Those that are recorded, without which all are.
    """

    def __init__(self, instance: Instance, source: Source, outputs: Sequence[str] | None = None) -> None:
        self.instance = instance
        self.outputs = instance.fmu.outputs() if outputs is None else list(outputs)
        signals, inputs = source.signals, set(instance.fmu.inputs())
        names = [name for name in signals.names if name in inputs]
        if names == signals.names:
            self.port, self._gathered = Port(instance, names, signals), []
            return
        self.port = Port(instance, names)
        rows: dict[str, list[int]] = {base: [] for base in self.port.signals.buffers}
        for base, row in (signals.places[name] for name in names):
            rows[base].append(row)
        self._gathered = [
            (buffer, signals.buffers[base], np.array(rows[base]))
            for base, buffer in self.port.signals.buffers.items()
        ]

    @classmethod
    def initialised(
        cls,
        instance: Instance,
        source: Source,
        start: float,
        stop: float,
        outputs: Sequence[str] | None = None,
    ) -> Sink:
        """A new filter, initialised with the current signals, that will run from start to stop [s]."""
        instance.begin_initialisation(start, stop)
        sink = cls(instance, source, outputs)
        sink.receive()
        instance.finish_initialisation()
        return sink

    def receive(self) -> None:
        """Take the current signals."""
        for buffer, signals, rows in self._gathered:
            buffer[:] = signals[rows]
        self.port.write()

    def receive_in(self, loop: Loop) -> None:
        """As `receive`, in a compiled loop."""
        for gathered in self._gathered:
            loop.gather(*gathered)
        loop.write(self.port)

    def advance(self, time: float, step: float) -> None:
        """Step the filter."""
        self.instance.step(time, step)

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""
        loop.step(self.instance)


class AlignmentSource:
    """Signals of a plant or a recording, and what an alignment that consumes them hands over to navigation.

    Parameters
    ----------
    source : FmuSource or RecordedSource
        With the signals that the alignment consumes; those of a recording are all that navigation gets.
    alignment : Sink
        AlignmentFilter that consumes them, initialised.
    navigation : Fmu
        NavigationFilter whose inputs are fed.
    order : Order
        Of the steps of source and alignment.
    """

    def __init__(
        self, source: FmuSource | RecordedSource, alignment: Sink, navigation: Fmu, order: Order
    ) -> None:
        self.instance, self.alignment = source.instance, alignment.instance
        self._source, self._sink, self._late = source, alignment, order is Order.jacobi
        handed = handed_over(self.alignment.fmu, navigation)
        outputs = Port(self.alignment, list(handed.values()))
        if self.instance is None:
            self._ports, sensed = [outputs], source.signals
        else:
            port = Port(self.instance, connected(self.instance.fmu.outputs(), navigation))
            self._ports, sensed = [port, outputs], port.signals
        self._parts = sensed, outputs.signals
        self.signals = Signals([navigation.variables[name] for name in (*sensed.names, *handed)])
        self._renew()

    def advance(self, time: float, step: float) -> None:
        """Step source and alignment and read their outputs."""
        if self._late:
            self._sink.receive()
        self._source.advance(time, step)
        if not self._late:
            self._sink.receive()
        self._sink.advance(time, step)
        self._renew()

    def advance_in(self, loop: Loop) -> None:
        """As `advance`, in a compiled loop."""
        if self._late:
            self._sink.receive_in(loop)
        self._source.advance_in(loop)
        if not self._late:
            self._sink.receive_in(loop)
        self._sink.advance_in(loop)
        for port in self._ports:
            loop.read(port)
        for base, buffer in self.signals.buffers.items():
            parts = [signals.buffers[base] for signals in self._parts if base in signals.buffers]
            ends = np.cumsum([len(part) for part in parts])
            for part, place in zip(parts, np.split(buffer, ends[:-1]), strict=True):
                loop.gather(place, part, np.arange(len(part)))

    def _renew(self) -> None:
        """What is sensed and, behind it, the outputs of the alignment, into the signals."""
        for port in self._ports:
            port.read()
        for base, buffer in self.signals.buffers.items():
            parts = [signals.buffers[base] for signals in self._parts if base in signals.buffers]
            np.concatenate(parts, out=buffer)


@dataclass(frozen=True)
class Recorded:
    """What a simulation recorded.

    Attributes
    ----------
    time : ndarray
        Master times of the signals that the filters had consumed at each periodic row [s].
    fix_time : ndarray
        Times of validity of the fixes that the filters received [s].
    truth : dict of str to ndarray, or None
        Outputs of the source's FMU at `time`, by name.
    filters, fixes : list of dict of str to ndarray
        Outputs of each filter by name, periodically and after each fix.
    alignment : dict of str to ndarray, or None
        Outputs of the alignment that is handed over, periodically as those of the filters.
    corrections : list of Corrections
        What the fixes corrected in each filter, where that is recorded.
    """

    time: Array
    fix_time: Array
    truth: Columns | None
    filters: list[Columns]
    fixes: list[Columns]
    alignment: Columns | None = None
    corrections: Sequence[Corrections] = ()


@dataclass(frozen=True)
class Corrections:
    """Outputs of a filter by name, after the steps that brought a fix and as they were without the fix.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Master times [s].
    without, after : dict of str to ndarray, shape (n,)
    """

    time: Array
    without: Columns
    after: Columns


FIX_SIGNALS: Final = ("gnss.sample", "gnss.time")
"""Signals that tell of a new fix, which the master needs whether a filter takes them or not."""


def connected(source: Iterable[str], sink: Fmu) -> list[str]:
    """Inputs of a filter that take signals. The source must have them, but for what need not be there."""
    available = set(source)
    signals = [
        name
        for name in sink.inputs()
        if not sink.variables[name].settable and (name in available or not name.startswith(OPTIONAL))
    ]
    if missing := [name for name in signals if name not in available]:
        raise InputError(f"nothing is connected to the inputs {', '.join(missing)} of {sink.name}")
    return signals


def handed_over(alignment: Fmu, navigation: Fmu) -> dict[str, str]:
    """Output of an alignment that goes into each input from which navigation sets out, by that input."""
    outputs = set(alignment.outputs())
    handed = {}
    for name in (name for name in navigation.inputs() if name.startswith(START)):
        what = name.removeprefix(START)
        candidates = ("converged",) if what == "valid" else (f"nav.{what}", what)
        found = [output for output in candidates if output in outputs]
        if not found:
            raise InputError(f"{alignment.name} has no output to hand over to {name} of {navigation.name}")
        handed[name] = found[0]
    return handed


def simulate(
    source: Source,
    sinks: Sequence[Sink],
    times: Array,
    *,
    record_every: int,
    source_outputs: Sequence[str] = (),
    fix_outputs: Sequence[str] = (),
    alignment_outputs: Sequence[str] = (),
    correction_outputs: Sequence[str] = (),
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    master: Master = Master.auto,
) -> Recorded:
    """Step source and filters through all times, recording on the way.

    Parameters
    ----------
    source : Source
        Plant or recording, initialised.
    sinks : sequence of Sink
        Filters, initialised.
    times : ndarray, shape (n + 1,)
        Communication points [s].
    record_every : int
        Steps between periodic rows.
    source_outputs : sequence of str
        Outputs of the source's FMU to record.
    fix_outputs : sequence of str
        Outputs of the filters, of each as far as it has them, that are recorded at each fix rather than
        periodically.
    alignment_outputs : sequence of str
        Outputs of the source's alignment to record.
    correction_outputs : sequence of str
        Outputs of the filters that are recorded after each fix, and as they would be without it; Python
        steps.
    order : Order
        Who steps first.
    progress : callable
        Called now and then, by the Python master at each periodic row.
    master : Master
        Who steps; the results are the same.

    Returns
    -------
    Recorded

    Raises
    ------
    InputError
        The compiled loop was asked for and is not there.
    SimulationError
        An FMU refused to go on.
    """
    steps = len(times) - 1
    rows = steps // record_every + 1
    of_fixes = set(fix_outputs)
    tables = _Tables(
        truth=Table(Port(source.instance, source_outputs), rows) if source.instance else None,
        filters=[
            Table(Port(sink.instance, [n for n in sink.outputs if n not in of_fixes]), rows) for sink in sinks
        ],
        alignment=Table(Port(source.alignment, alignment_outputs), rows) if source.alignment else None,
        fixes=[
            Table(Port(sink.instance, [n for n in fix_outputs if n in sink.outputs]), steps) for sink in sinks
        ],
    )
    for table in tables.periodic:
        table.append()
    late = order is Order.jacobi
    corrections: Sequence[Corrections] = ()
    if compiled.steps(master) and isinstance(source, InLoop) and not correction_outputs:
        fix_time = _compiled_steps(
            source, source.advance_in, sinks, times, record_every, tables, late, progress
        )
    else:
        fix_time, corrections = _python_steps(
            source, sinks, times, record_every, tables, correction_outputs, late, progress
        )
    consumed = times[record_every - late :: record_every]
    return Recorded(
        np.concatenate((times[:1], consumed))[:rows],
        fix_time,
        tables.truth.columns() if tables.truth else None,
        [table.columns() for table in tables.filters],
        [table.columns() for table in tables.fixes],
        tables.alignment.columns() if tables.alignment else None,
        corrections,
    )


@dataclass(frozen=True)
class _Tables:
    """What is recorded: truth and outputs periodically, outputs at fixes."""

    truth: Table | None
    filters: list[Table]
    alignment: Table | None
    fixes: list[Table]

    @property
    def after_step(self) -> list[Table]:
        """Periodic ones of what steps last."""
        return [*self.filters, *([self.alignment] if self.alignment else [])]

    @property
    def periodic(self) -> list[Table]:
        """All of them."""
        return [*([self.truth] if self.truth else []), *self.after_step]


def _compiled_steps(
    source: Source,
    advance: Callable[[Loop], None],
    sinks: Sequence[Sink],
    times: Array,
    record_every: int,
    tables: _Tables,
    late: bool,
    progress: Progress,
) -> Array:
    """Times of the fixes; what is done in a step, as `_python_steps` does it."""
    (base, counter), (_, fix_time) = (source.signals.places[name] for name in FIX_SIGNALS)
    fixes_at = np.empty(len(times) - 1)
    loop = Loop()
    if not late:
        advance(loop)
    loop.look(source.signals.buffers[base], counter)
    for sink in sinks:
        sink.receive_in(loop)
    loop.note(fixes_at, source.signals.buffers["Real"], fix_time)
    if tables.truth:
        loop.append(tables.truth, When.at_row)
    if late:
        advance(loop)
    for sink in sinks:
        sink.advance_in(loop)
    for table in tables.fixes:
        loop.append(table, When.at_fix)
    for table in tables.after_step:
        loop.append(table, When.at_row)
    return np.array(fixes_at[: loop.run(times, record_every, progress)])


def _python_steps(
    source: Source,
    sinks: Sequence[Sink],
    times: Array,
    record_every: int,
    tables: _Tables,
    correction_outputs: Sequence[str],
    late: bool,
    progress: Progress,
) -> tuple[Array, list[Corrections]]:
    """Times of the fixes, and what they corrected."""
    steps = len(times) - 1
    without, after = (
        [Table(Port(sink.instance, correction_outputs), steps) for sink in sinks if correction_outputs]
        for _ in range(2)
    )
    fixes_at, corrected_at = [], []
    (base, counter), (_, fix_time) = (source.signals.places[name] for name in FIX_SIGNALS)
    integers, reals = source.signals.buffers[base], source.signals.buffers["Real"]
    fix_count = integers[counter]
    for step_number, (time, end) in enumerate(pairwise(times.tolist()), 1):
        step = end - time
        if not late:
            source.advance(time, step)
        is_fix = integers[counter] != fix_count
        if is_fix and correction_outputs:
            fix_count, integers[counter] = integers[counter], fix_count
            for sink, table in zip(sinks, without, strict=True):
                sink.receive()
                with sink.instance.undone():
                    sink.advance(time, step)
                    table.append()
            integers[counter] = fix_count
            corrected_at.append(end)
        for sink in sinks:
            sink.receive()
        is_row = step_number % record_every == 0
        if is_fix:
            fix_count = integers[counter]
            fixes_at.append(float(reals[fix_time]))
        if is_row and tables.truth:
            tables.truth.append()
        if late:
            source.advance(time, step)
        for sink in sinks:
            sink.advance(time, step)
        if is_fix:
            for table in (*tables.fixes, *after):
                table.append()
        if is_row:
            for table in tables.after_step:
                table.append()
            progress((step_number // record_every + 1) / (steps // record_every + 1))
    corrected = [
        Corrections(np.array(corrected_at), before.columns(), behind.columns())
        for before, behind in zip(without, after, strict=True)
    ]
    return np.array(fixes_at), corrected
