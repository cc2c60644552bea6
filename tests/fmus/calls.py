"""FMI 2.0 calls as a C program makes them: every status comes back, nothing is checked on the way."""

from __future__ import annotations

import ctypes
import zipfile
from collections.abc import Iterable, Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

from fmpy import platform as fmi2_platform
from fmpy import read_model_description, sharedLibraryExtension
from fmpy.model_description import ScalarVariable

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
MODEL_EXCHANGE, CO_SIMULATION = range(2)
Number = float | int | bool
STARTS = {"Real": float, "Integer": int, "Boolean": lambda text: int(text in ("1", "true"))}

# The callback is variadic in C; with one format, "%s", one more pointer follows.
Logger = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    """`fmi2CallbackFunctions`."""

    _fields_ = (
        ("logger", Logger),
        ("allocate_memory", c_void_p),
        ("free_memory", c_void_p),
        ("step_finished", c_void_p),
        ("environment", c_void_p),
    )


@dataclass(frozen=True)
class Line:
    """One call of the logger."""

    instance: str | None
    status: int
    category: str | None
    format: str
    text: str


class Journal:
    """What an FMU logged, and the callbacks that write it."""

    def __init__(self) -> None:
        self.lines: list[Line] = []
        # ctypes objects that C refers to must live as long as the instance.
        self.callbacks = Callbacks(Logger(self._write), None, None, None, None)

    def _write(
        self, _environment: int, instance: bytes, status: int, category: bytes, form: bytes, text: bytes
    ) -> None:
        decode = [part if part is None else part.decode() for part in (instance, category)]
        self.lines.append(Line(decode[0], status, decode[1], form.decode(), text.decode()))

    @property
    def last(self) -> str:
        """Text of the last line."""
        return self.lines[-1].text if self.lines else "nothing was logged"


@dataclass(frozen=True)
class Fmu:
    """An unpacked FMU with its library loaded."""

    archive: Path
    folder: Path
    variables: dict[str, ScalarVariable] = field(repr=False)
    guid: str
    library: ctypes.CDLL

    @property
    def name(self) -> str:
        return self.archive.stem

    @classmethod
    def load(cls, archive: Path, folder: Path) -> Fmu:
        """Unpack into `folder` and load."""
        with zipfile.ZipFile(archive) as content:
            content.extractall(folder)
        return cls.loaded(archive, folder)

    @classmethod
    def loaded(cls, archive: Path, folder: Path) -> Fmu:
        """Load what is unpacked already."""
        description = read_model_description(archive)
        binary = folder / "binaries" / fmi2_platform / f"{archive.stem}{sharedLibraryExtension}"
        library = ctypes.CDLL(str(binary))
        library.fmi2Instantiate.restype = c_void_p
        library.fmi2Instantiate.argtypes = (
            c_char_p, c_int, c_char_p, c_char_p, POINTER(Callbacks), c_int, c_int,
        )  # fmt: skip
        library.fmi2FreeInstance.restype = None
        library.fmi2FreeInstance.argtypes = (c_void_p,)
        library.fmi2GetVersion.restype = c_char_p
        library.fmi2GetTypesPlatform.restype = c_char_p
        variables = {variable.name: variable for variable in description.modelVariables}
        return cls(archive, folder, variables, description.guid, library)

    def of(self, causality: str, variability: str | None = None) -> list[ScalarVariable]:
        """Variables with these attributes."""
        return [
            variable
            for variable in self.variables.values()
            if variable.causality == causality and variability in (None, variable.variability)
        ]

    def instantiate(
        self,
        name: bytes | None = b"instance",
        kind: int = CO_SIMULATION,
        guid: bytes | None = None,
        callbacks: Callbacks | None = None,
        logging: bool = False,
    ) -> int | None:
        """Raw `fmi2Instantiate`; the guid defaults to the FMU's."""
        return self.library.fmi2Instantiate(
            name,
            kind,
            self.guid.encode() if guid is None else guid,
            (self.folder / "resources").as_uri().encode(),
            None if callbacks is None else byref(callbacks),
            0,
            int(logging),
        )

    def instance(self, logging: bool = False) -> Instance:
        """A new instance."""
        return Instance(self, logging)


class Signals:
    """A fixed list of scalars that is read or written in one call a type."""

    def __init__(self, variables: Iterable[ScalarVariable]) -> None:
        self.names: list[str] = []
        self.groups: list[tuple[str, ctypes.Array[c_uint], ctypes.Array[c_double] | ctypes.Array[c_int]]] = []
        ordered = list(variables)
        for base, types in (
            ("Real", ("Real",)),
            ("Integer", ("Integer", "Enumeration")),
            ("Boolean", ("Boolean",)),
        ):
            members = [variable for variable in ordered if variable.type in types]
            if members:
                self.names += [variable.name for variable in members]
                references = (c_uint * len(members))(*(variable.valueReference for variable in members))
                values = ((c_double if base == "Real" else c_int) * len(members))()
                for i, variable in enumerate(members):
                    values[i] = STARTS[base](variable.start or "0")
                self.groups.append((base, references, values))

    def read(self, instance: Instance) -> int:
        """Get all; the worst status."""
        return max(
            (instance.call(f"fmi2Get{base}", r, c_size_t(len(r)), v) for base, r, v in self.groups),
            default=OK,
        )

    def write(self, instance: Instance) -> int:
        """Set all; the worst status."""
        return max(
            (instance.call(f"fmi2Set{base}", r, c_size_t(len(r)), v) for base, r, v in self.groups),
            default=OK,
        )

    @property
    def values(self) -> dict[str, Number]:
        """Values by name."""
        numbers = [number for _, _, values in self.groups for number in values]
        return dict(zip(self.names, numbers, strict=True))

    def assign(self, values: dict[str, Number]) -> None:
        """Take over the values whose names are here."""
        names = iter(self.names)
        for _, _, buffer in self.groups:
            for i, name in zip(range(len(buffer)), names, strict=False):
                buffer[i] = values.get(name, buffer[i])

    @property
    def bytes(self) -> bytes:
        """The exact bits of all values."""
        return b"".join(bytes(values) for _, _, values in self.groups)


class Instance:
    """One instance and its log."""

    def __init__(self, fmu: Fmu, logging: bool, kind: int = CO_SIMULATION) -> None:
        self.fmu = fmu
        self.journal = Journal()
        self.handle = fmu.instantiate(kind=kind, callbacks=self.journal.callbacks, logging=logging)
        assert self.handle, self.journal.last
        self.outputs = Signals(fmu.of("output"))
        self.inputs = Signals(fmu.of("input"))

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.free()

    def free(self) -> None:
        self.fmu.library.fmi2FreeInstance(self.handle)
        self.handle = None

    def call(self, function: str, *arguments: object) -> int:
        """Status of any function that takes the component first."""
        return int(self.fmu.library[function](c_void_p(self.handle), *arguments))

    # -------------------------------------------------------------- life

    def set_up(self, start: float = 0.0, stop: float | None = None) -> int:
        return self.call(
            "fmi2SetupExperiment",
            0,
            c_double(0.0),
            c_double(start),
            int(stop is not None),
            c_double(stop or 0.0),
        )

    def enter(self) -> int:
        return self.call("fmi2EnterInitializationMode")

    def exit(self) -> int:
        return self.call("fmi2ExitInitializationMode")

    def start(self, start: float = 0.0, stop: float | None = None, **parameters: Number) -> Instance:
        """From instantiated to stepping."""
        for name, value in parameters.items():
            assert self.set(name, value) == OK, self.journal.last
        for status in (self.set_up(start, stop), self.enter(), self.exit()):
            assert status == OK, self.journal.last
        return self

    def step(self, time: float, size: float) -> int:
        return self.call("fmi2DoStep", c_double(time), c_double(size), 1)

    def reset(self) -> int:
        return self.call("fmi2Reset")

    def terminate(self) -> int:
        return self.call("fmi2Terminate")

    # -------------------------------------------------------------- variables

    def set(self, name: str, value: Number) -> int:
        signals = Signals([self.fmu.variables[name]])
        signals.assign({name: value})
        return signals.write(self)

    def get(self, name: str) -> Number:
        signals = Signals([self.fmu.variables[name]])
        assert signals.read(self) == OK, self.journal.last
        return signals.values[name]

    def read(self) -> dict[str, Number]:
        """All outputs."""
        assert self.outputs.read(self) == OK, self.journal.last
        return self.outputs.values

    # -------------------------------------------------------------- stored states

    def save(self) -> c_void_p:
        state = c_void_p()
        assert self.call("fmi2GetFMUstate", byref(state)) == OK, self.journal.last
        return state

    def restore(self, state: c_void_p) -> int:
        return self.call("fmi2SetFMUstate", state)

    def serialise(self) -> bytes:
        """The present state as bytes."""
        state, size = self.save(), c_size_t()
        assert self.call("fmi2SerializedFMUstateSize", state, byref(size)) == OK, self.journal.last
        buffer = (ctypes.c_char * size.value)()
        assert self.call("fmi2SerializeFMUstate", state, buffer, size) == OK, self.journal.last
        assert self.call("fmi2FreeFMUstate", byref(state)) == OK, self.journal.last
        return bytes(buffer)

    def deserialise(self, content: bytes) -> tuple[int, c_void_p]:
        """Status, and the state made from bytes."""
        state = c_void_p()
        return self.call("fmi2DeSerializeFMUstate", content, c_size_t(len(content)), byref(state)), state


def run(
    instance: Instance, signals: Sequence[dict[str, Number]], first: int, last: int, size: float
) -> list[bytes]:
    """Steps `first` to `last` with the inputs fed from `signals`; the bits of all outputs after each."""
    outputs = []
    for index in range(first, last):
        instance.inputs.assign(signals[index])
        assert instance.inputs.write(instance) == OK, instance.journal.last
        assert instance.step(index * size, size) == OK, instance.journal.last
        assert instance.outputs.read(instance) == OK, instance.journal.last
        outputs.append(instance.outputs.bytes)
    return outputs
