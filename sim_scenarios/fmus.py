"""The FMUs: where they are, which variables they declare, and values in the units that people write.

Units, their display units and their factors are those of the FMU's own modelDescription.xml (FMI 2.0.4,
2.2.2: display value = factor * value + offset).
"""

from __future__ import annotations

import difflib
import hashlib
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import fmpy
from fmpy.model_description import ModelDescription, ModelVariable

from sim_scenarios import toml
from sim_scenarios.catalogue import is_own_fmu
from sim_scenarios.errors import InputError
from sim_scenarios.folders import filling_temporary, temporary

PLANT: Final = "TruthPlant"
PLAYBACK: Final = "Playback"
ALIGNMENT_FILTER: Final = "AlignmentFilter"
NAVIGATION_FILTER: Final = "NavigationFilter"
SIGNALS: Final = ("imu.", "gnss.", "body_velocity.", "heading_aid.", "height_aid.")
"""Beginnings of the names of inputs that a source of signals feeds; other inputs are set like parameters."""
OPTIONAL: Final = ("gnss.fix_", "gnss.channel.", "body_velocity.", "heading_aid.", "height_aid.")
"""Beginnings of the names of those that a source may lack: as they start, they say that there is nothing."""

START: Final = "initial."
"""Beginning of the names of that from which a filter sets out."""

_INTEGERS: Final = (-(2**31), 2**31 - 1)  # fmi2Integer
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_RULE: Final = re.compile(
    rf"(?P<name>[\w.]+(?:\[[\d,]+\])?) = (?P<value>{_NUMBER}): "
    rf"(?P<rule>must be (?:at least|at most|greater than|less than)) (?P<limit>{_NUMBER})"
)

_LONGEST: Final = 80
"""Characters of a wrong value that are shown."""

Number = float | int | bool


@dataclass(frozen=True)
class Unit:
    """A unit of the FMU and the display units of the same quantity: name -> (factor, offset)."""

    name: str
    display: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def to_si(self, given: object) -> float:
        """Value in the FMU's unit of a number in that unit, or of a text such as "10 deg"."""
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            return _finite(given, given)
        number, unit = _split_quantity(given)
        if unit in ("", self.name):
            return _finite(number, given)
        if unit not in self.display:
            raise InputError(f"'{_shown(given)}' is not in a unit of {self._alternatives()}")
        factor, offset = self.display[unit]
        return _finite((number - offset) / factor, given)

    def _alternatives(self) -> str:
        return f"this quantity: {', '.join([self.name, *self.display])}"


@dataclass(frozen=True)
class Variable:
    """A scalar variable of an FMU."""

    name: str
    reference: int
    kind: str  # Real | Integer | Boolean | Enumeration
    causality: str
    description: str
    unit: Unit
    display_unit: str
    items: Mapping[str, int]  # of an enumeration
    start: str | None
    min: str | None
    max: str | None
    tunable: bool
    """Whether it may be set between steps."""

    @property
    def settable(self) -> bool:
        """Whether a user may set it: a parameter, or an input that is not fed with signals."""
        return self.causality == "parameter" or (
            self.causality == "input" and not self.name.startswith(SIGNALS)
        )

    def parse(self, given: object) -> Number:
        """Value for the FMU of what a user wrote: number, quantity, true or false, name of an item."""
        if self.kind == "Real":
            return self.unit.to_si(given)
        if self.kind == "Boolean":
            return self._parse_boolean(given)
        if self.kind == "Enumeration":
            return self._parse_item(given)
        return self._parse_integer(given)

    def _parse_integer(self, given: object) -> int:
        if not isinstance(given, int) or isinstance(given, bool):
            raise InputError(f"'{_shown(given)}' is not a whole number")
        low, high = (
            type_limit if declared is None else int(declared)
            for declared, type_limit in zip((self.min, self.max), _INTEGERS, strict=True)
        )
        if not low <= given <= high:
            raise InputError(f"{_shown(given)} is not a whole number from {low} to {high}")
        return given

    def _parse_boolean(self, given: object) -> bool:
        if isinstance(given, bool):
            return given
        raise InputError(f"'{_shown(given)}' is neither true nor false")

    def _parse_item(self, given: object) -> int:
        if isinstance(given, int) and given in self.items.values():
            return given
        if given in self.items:
            return self.items[str(given)]
        raise InputError(
            f"'{_shown(given)}' is none of {', '.join(self.items)}{did_you_mean(str(given), self.items)}"
        )

    def display(self, value: Number) -> str:
        """Value as a person reads it: in the display unit, or the item's name."""
        if self.kind == "Boolean":
            return str(bool(value)).lower()
        if self.kind == "Enumeration":
            return next((name for name, item in self.items.items() if item == value), str(value))
        if self.kind == "Integer":
            return str(value)
        factor, offset = self.unit.display.get(self.display_unit, (1.0, 0.0))
        unit = self.display_unit or self.unit.name
        return f"{factor * value + offset:.6g}" + ("" if unit == "1" else f" {unit}")


class Fmu:
    """An FMU on disk: its variables, and its content unpacked for as long as this object lives.

    Attributes
    ----------
    name : str
        Model name, as in the FMU's modelDescription.xml.
    path : Path
        The .fmu file.
    variables : dict of str to Variable
        By scalar name (`imu.gyro.bias[1]`).
    arrays : dict of str to list of str
        Scalar names by the name without indices (`imu.gyro.bias`); a scalar is an array of one.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.model: ModelDescription = fmpy.read_model_description(str(path), validate=False)
        except Exception as error:  # whatever zip, XML and FMPy raise
            raise InputError(f"{path} is not an FMU: {error}") from error
        self.name = str(self.model.modelName)
        units = _units(self.model)
        self.variables = {v.name: _variable(v, units) for v in self.model.modelVariables}
        self.units = units
        self.arrays: dict[str, list[str]] = {}
        for name in self.variables:
            self.arrays.setdefault(name.partition("[")[0], []).append(name)
        self._unpacked: TemporaryDirectory[str] | None = None

    @property
    def folder(self) -> Path:
        """Folder with the unpacked FMU, the source code excepted."""
        if self._unpacked is None:
            with filling_temporary():
                unpacked = TemporaryDirectory(prefix=f"{self.name}-", dir=temporary())
                fmpy.extract(str(self.path), unzipdir=unpacked.name, include=_needed_to_run)
            self._unpacked = unpacked
        return Path(self._unpacked.name)

    @property
    def library(self) -> Path:
        """The unpacked binary for this machine.

        Its folder has the name that FMPy gives the platform in FMI 2, `linux64` on any processor, or, where
        FMI 2 has no name (Linux on aarch64), that of FMI 3.
        """
        name = f"{self.model.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}"
        platforms: tuple[str, str] = (fmpy.platform_tuple, fmpy.platform)
        candidates: list[Path] = [self.folder / "binaries" / platform / name for platform in platforms]
        for path in candidates:
            if path.is_file():
                return path
        there = sorted(path.name for path in (self.folder / "binaries").glob("*"))
        raise InputError(f"{self.path} has no binary for {platforms[0]}; it has {', '.join(there) or 'none'}")

    @property
    def guid(self) -> str:
        """Hash of the FMU's description and sources."""
        return str(self.model.guid)

    @property
    def version(self) -> str:
        """What tells it from another FMU of that name."""
        return self.guid

    def outputs(self) -> list[str]:
        """Names of the scalar outputs, in order."""
        return [name for name, v in self.variables.items() if v.causality == "output"]

    def inputs(self) -> list[str]:
        """Names of the scalar inputs, in order."""
        return [name for name, v in self.variables.items() if v.causality == "input"]

    def start(self, name: str) -> Number:
        """Start value of a scalar variable."""
        variable = self.variables[name]
        if variable.start is None:
            raise KeyError(f"{name} of {self.name} has no start value")
        if variable.kind == "Boolean":
            return variable.start in ("true", "1")
        return float(variable.start) if variable.kind == "Real" else int(variable.start)

    def has_parameter(self, name: str) -> bool:
        """Whether a name is that of a parameter: a scalar, an element (`a[1]`) or an array as a whole."""
        scalar = name if name in self.variables else self.arrays.get(name, [""])[0]
        return scalar in self.variables and self.variables[scalar].settable

    def assignments(self, name: str, given: object) -> dict[str, Number]:
        """Scalar values that a user's value for a parameter stands for.

        A list sets the elements of an array, one value sets them all.
        """
        if not self.has_parameter(name):
            raise InputError(self._not_a_parameter(name))
        scalars = [name] if name in self.variables else self.arrays[name]
        values = list(_flatten(given)) if isinstance(given, list | tuple) else [given] * len(scalars)
        if len(values) != len(scalars):
            raise InputError(f"{name} has {len(scalars)} elements, {len(values)} are given")
        try:
            return {s: self.variables[s].parse(value) for s, value in zip(scalars, values, strict=True)}
        except InputError as error:
            raise InputError(f"{name}: {error}") from None

    def _not_a_parameter(self, name: str) -> str:
        scalar = name if name in self.variables else self.arrays.get(name, [""])[0]
        if scalar in self.variables:
            return f"{name} is an {self.variables[scalar].causality} of {self.name}, not a parameter"
        if name.partition("[")[0] in self.arrays:
            size = len(self.arrays[name.partition("[")[0]])
            return f"{self.name} has no element {name}; the indices run from 1 to {size}"
        return f"{self.name} has no parameter '{name}'{did_you_mean(name, self.parameter_names())}"

    def readable(self, text: str) -> str:
        """What the FMU says of a value, with the value and its limit in the unit that people read."""

        def rewritten(match: re.Match[str]) -> str:
            variable = self.variables.get(match["name"])
            if variable is None or variable.kind != "Real":
                return match[0]
            value, limit = (variable.display(float(match[key])) for key in ("value", "limit"))
            return f"{match['name']} = {value}: {match['rule']} {limit}"

        return _RULE.sub(rewritten, text)

    def parameter_names(self) -> list[str]:
        """Names of the parameters, arrays without indices."""
        return [name for name in self.arrays if self.has_parameter(name)]


class OwnFmu(Fmu):
    """A filter of somebody else's: named by its file, and known by the content of that.

    Raises
    ------
    InputError
        There is no such file, it is not an FMU for co-simulation of FMI 2.0, or it has no binary for this
        machine.
    """

    def __init__(self, path: Path) -> None:
        if not toml.exists(path):
            raise InputError(f"there is no FMU {path}")
        super().__init__(path)
        self.name = path.name
        if self.model.fmiVersion != "2.0" or self.model.coSimulation is None:
            kind = "" if self.model.coSimulation else ", without co-simulation"
            raise InputError(
                f"{path} is an FMU of FMI {self.model.fmiVersion}{kind}: must be one of FMI 2.0 for "
                "co-simulation"
            )
        _ = self.library  # which refuses a file for other machines

    @cached_property
    def version(self) -> str:
        """SHA-256 of the file: whoever makes it may forget to change its GUID."""
        return f"sha256:{hashlib.sha256(self.path.read_bytes()).hexdigest()}"


class Fmus(dict[str, Fmu]):
    """FMUs by name, those of somebody else's by the path of their file."""

    def __missing__(self, name: str) -> Fmu:
        """Load an FMU from where it is installed, or from its path, when it is first asked for."""
        self[name] = OwnFmu(Path(name)) if is_own_fmu(name) else load(name)
        return self[name]

    @property
    def plant(self) -> Fmu:
        """The FMU that makes the signals."""
        return self[PLANT]

    @property
    def filter(self) -> Fmu:
        """The filter FMU of scenarios that name no other."""
        return self[ALIGNMENT_FILTER]


def load(name: str) -> Fmu:
    """FMU of a name, from the first folder that has it."""
    return Fmu(find(name))


def find(name: str) -> Path:
    """Path of an FMU: in $TRUENORTH_FMUS, else in the package's own folder or build/fmus of the checkout."""
    candidates = [folder / f"{name}.fmu" for folder in search_path()]
    for candidate in candidates:
        if candidate.is_file():
            return candidate
    places = ", ".join(str(candidate.parent) for candidate in candidates)
    raise InputError(
        f"{name}.fmu is not in {places}; run `make fmus` to build it, or set TRUENORTH_FMUS to its folder"
    )


def search_path() -> list[Path]:
    """Folders in which FMUs are looked for, in this order."""
    named = os.environ.get("TRUENORTH_FMUS")
    return [Path(named)] if named else own_folders()


def own_folders() -> list[Path]:
    """Folders in which what comes with this package is looked for, in this order."""
    package = Path(__file__).resolve().parent
    return [package / "fmus", package.parent / "build" / "fmus"]


def did_you_mean(name: str, known: Mapping[str, object] | list[str]) -> str:
    """Hint at the known name that is closest to a wrong one; empty when none is close."""
    close = difflib.get_close_matches(name[:_LONGEST], list(known), n=1, cutoff=0.6)
    return f"; did you mean '{close[0]}'?" if close else ""


def no_such_parameter(name: str, parts: Mapping[str, Fmu], besides: Iterable[str] = ()) -> InputError:
    """What to raise for a setting that none of the parts has; `besides` are names that would do, too."""
    asked = " and ".join(dict.fromkeys(fmu.name for fmu in parts.values()))
    known = [*(parameter for fmu in parts.values() for parameter in fmu.parameter_names()), *besides]
    return InputError(
        f"the setting {name}: no FMU has such a parameter (of {asked}){did_you_mean(name, known)}"
    )


def _needed_to_run(member: str) -> bool:
    """Whether a member of an FMU is not its source code."""
    return not member.startswith("sources/")


def _shown(given: object) -> str:
    """The beginning of a wrong value."""
    try:
        text = str(given)
    except ValueError:  # an integer with thousands of digits
        return "a number of thousands of digits"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _finite(number: float, given: object) -> float:
    """A number as the FMU takes it, if it can."""
    try:
        value = float(number)
    except OverflowError:  # of an integer
        value = math.inf
    if not math.isfinite(value):
        raise InputError(f"'{_shown(given)}' is not a finite number")
    return value


def _split_quantity(given: object) -> tuple[float, str]:
    match = re.fullmatch(rf"\s*({_NUMBER})\s*(\S*)\s*", str(given))
    if not isinstance(given, str) or match is None:
        raise InputError(f"'{_shown(given)}' is neither a number nor a number with a unit")
    return float(match[1]), match[2]


def _flatten(values: Iterable[Any]) -> Iterator[Any]:
    for value in values:
        if isinstance(value, list | tuple):
            yield from _flatten(value)
        else:
            yield value


def _units(model: ModelDescription) -> dict[str, Unit]:
    return {
        str(unit.name): Unit(
            str(unit.name), {str(d.name): (float(d.factor), float(d.offset)) for d in unit.displayUnits}
        )
        for unit in model.unitDefinitions
    }


def _variable(variable: ModelVariable, units: Mapping[str, Unit]) -> Variable:
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared else None) or "1"
    return Variable(
        name=str(variable.name),
        reference=int(variable.valueReference),
        kind=str(variable.type),
        causality=str(variable.causality),
        description=variable.description or "",
        unit=units.get(unit, Unit(unit)),
        display_unit=variable.displayUnit or (declared.displayUnit if declared else None) or "",
        items={str(item.name): int(str(item.value)) for item in declared.items} if declared else {},
        start=variable.start,
        min=variable.min,
        max=variable.max,
        tunable=variable.variability == "tunable",
    )
