"""What `<Component>.toml` may say, and the sentences for what it may not.

`read` returns a `Declaration`; anything wrong raises `DeclarationError`, whose text names the file, the
variable, the key and the rule.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from units import UNITS, Unit

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

Value: TypeAlias = bool | int | float | str
Start: TypeAlias = Value | list[Value] | list[list[Value]]

PLAIN_TYPES = ("Real", "Integer", "Boolean")
TAKEN = (*PLAIN_TYPES, "Parameters", "Inputs", "Outputs", *(unit.quantity for unit in UNITS.values()))
LONGEST_NAME = 63
INT32 = 2**31 - 1

# Words that cannot name a C++ member or enumerator, and the members that every generated struct has.
_WORDS = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl concept
const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default
delete do double dynamic_cast else enum explicit export extern false float for friend goto if inline
int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected
public register reinterpret_cast requires return short signed sizeof static static_assert
static_cast struct switch template this thread_local throw true try typedef typeid typename union
unsigned using virtual void volatile wchar_t while xor xor_eq serialize
"""
RESERVED = frozenset(_WORDS.split())


class DeclarationError(Exception):
    """A declaration that breaks a rule; the text is for the person who wrote the TOML."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Item(_Strict):
    """One value of an enumeration."""

    name: str
    description: str = Field(min_length=1)


class Enumeration(_Strict):
    """A named list of choices; values count from 1."""

    description: str = Field(min_length=1)
    items: list[Item] = Field(min_length=1)

    @model_validator(mode="after")
    def _check(self) -> Enumeration:
        names = [item.name for item in self.items]
        for name in names:
            _check_identifier(name)
        if len(set(names)) != len(names):
            raise ValueError("items: each name may occur once")
        return self

    def value(self, name: str) -> int:
        """Return the number of the item called `name`."""
        return [item.name for item in self.items].index(name) + 1


class Experiment(_Strict):
    """What a tool simulates when nobody says otherwise."""

    stop_time: float = Field(gt=0.0)
    step_size: float = Field(gt=0.0)


Size = Annotated[int, Field(ge=2)]


class Variable(_Strict):
    """One variable, an array counting as one."""

    name: str
    causality: Literal["parameter", "tunable", "input", "output"]
    type: str
    size: Size | Annotated[list[Size], Field(min_length=2, max_length=2)] | None = None
    unit: str | None = None
    display_unit: str | None = None
    start: Start | None = None
    min: int | float | None = None
    above: int | float | None = None
    max: int | float | None = None
    nominal: float | None = Field(default=None, gt=0.0)
    depends: list[str] | None = None
    description: str = Field(min_length=1)

    @model_validator(mode="after")
    def _check(self) -> Variable:
        for part in self.path:
            _check_identifier(part)
        longest = max(len(name) for name in self.scalar_names)
        if longest > LONGEST_NAME:
            raise ValueError(f"name: {longest} characters, at most {LONGEST_NAME} are portable")
        if self.type == "Real":
            if self.unit is None:
                raise ValueError('unit: every Real needs one ("1" when dimensionless)')
            if self.unit not in UNITS:
                raise ValueError(f"unit: '{self.unit}' is unknown; known are {', '.join(UNITS)}")
            display = UNITS[self.unit].display
            if self.display_unit is not None and self.display_unit not in display:
                known = ", ".join(display) or "none"
                raise ValueError(f"display_unit: '{self.display_unit}' is unknown; for {self.unit}: {known}")
        else:
            for key in ("unit", "display_unit", "nominal"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: only a Real may have it")
            if len(self.shape) == 2:
                raise ValueError("size: only a Real may be a matrix")
        if self.type not in ("Real", "Integer"):
            for key in ("min", "above", "max"):
                if getattr(self, key) is not None:
                    raise ValueError(f"{key}: only a Real or an Integer may have it")
        if self.min is not None and self.above is not None:
            raise ValueError("min, above: give one of the two")
        if self.causality == "output":
            if self.start is not None:
                raise ValueError("start: an output is calculated and has none")
        elif self.start is None:
            raise ValueError(f"start: every {self.causality} needs one")
        if self.depends is not None and self.causality != "output":
            raise ValueError("depends: only an output may have it")
        return self

    @property
    def path(self) -> list[str]:
        """The dotted name in its parts."""
        return self.name.split(".")

    @property
    def shape(self) -> tuple[int, ...]:
        """() for a scalar, (n,) for a vector, (rows, columns) for a matrix."""
        if self.size is None:
            return ()
        return (self.size,) if isinstance(self.size, int) else tuple(self.size)

    @property
    def indices(self) -> list[tuple[int, ...]]:
        """Indices of the scalars from 0, the last one running fastest."""
        if len(self.shape) == 2:
            return [(row, column) for row in range(self.shape[0]) for column in range(self.shape[1])]
        return [(row,) for row in range(self.shape[0])] if self.shape else [()]

    @property
    def scalar_names(self) -> list[str]:
        """FMI 2 names of the scalars: `name`, `name[1]`, `name[1,1]`."""
        return [
            f"{self.name}[{','.join(str(i + 1) for i in index)}]" if index else self.name
            for index in self.indices
        ]

    @property
    def starts(self) -> list[Value]:
        """One start value for each scalar, in the order of `indices`."""
        if isinstance(self.start, list):
            return [value for row in self.start for value in (row if isinstance(row, list) else [row])]
        if self.start is None:
            raise DeclarationError(f"{self.name}: an output has no start values")
        return [self.start] * len(self.indices)


@dataclass(frozen=True)
class Scalar:
    """One element of a variable, as FMI 2 knows it."""

    name: str
    variable: Variable
    position: int
    """Among the elements of the variable, from 0."""
    reference: int
    """FMI value reference: the number among all scalars of the component, from 0."""


class Declaration(_Strict):
    """A component: its variables, its enumerations, its default experiment."""

    name: str
    description: str = Field(min_length=1)
    default_experiment: Experiment
    enumeration: dict[str, Enumeration] = {}
    variable: list[Variable] = Field(min_length=1)

    @property
    def snake_name(self) -> str:
        """`AlignmentFilter` -> `alignment_filter`: C++ namespace and file name."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.name).lower()

    def of(self, *causalities: str) -> list[Variable]:
        """Variables of these causalities, in order of declaration."""
        return [variable for variable in self.variable if variable.causality in causalities]

    @property
    def scalars(self) -> list[Scalar]:
        """Every variable's elements, in order of declaration."""
        elements = [(v, i, name) for v in self.variable for i, name in enumerate(v.scalar_names)]
        return [Scalar(name, v, i, reference) for reference, (v, i, name) in enumerate(elements)]

    def units(self) -> dict[str, Unit]:
        """Units in use."""
        used = {variable.unit for variable in self.variable}
        return {name: unit for name, unit in UNITS.items() if name in used}

    def display_units(self, unit: str) -> dict[str, float]:
        """Display units in use for `unit`, with their factors."""
        used = {variable.display_unit for variable in self.variable if variable.unit == unit}
        return {name: factor for name, factor in UNITS[unit].display.items() if name in used}

    def known_at_start(self, output: Variable) -> list[Variable]:
        """Parameters and inputs on which `output` depends in initialisation; by default all parameters."""
        patterns = output.depends
        if patterns is None:
            return self.of("parameter", "tunable")
        return [
            variable
            for variable in self.of("parameter", "tunable", "input")
            if any(fnmatchcase(variable.name, pattern) for pattern in patterns)
        ]


def read(path: Path) -> Declaration:
    """Read and check a declaration."""
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise DeclarationError(f"{path.name}: {error}") from error
    try:
        declaration = Declaration.model_validate(content)
    except ValidationError as error:
        raise DeclarationError("\n".join(_sentences(path.name, content, error))) from error
    if declaration.name != path.stem:
        raise DeclarationError(f"{path.name}: name = '{declaration.name}': must be that of the file")
    for problem in _problems(declaration):
        raise DeclarationError(f"{path.name}: {problem}")
    return declaration


def _check_identifier(name: str) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        raise ValueError(f"name: '{name}' must be lower-case words joined by underscores")
    if name in RESERVED:
        raise ValueError(f"name: '{name}' is a reserved word in C++")


def _sentences(file: str, content: dict[str, object], error: ValidationError) -> Iterator[str]:
    """Pydantic's complaints, with the variable's name for its number."""
    for problem in error.errors():
        where = list(problem["loc"])
        subject = ""
        variables = content.get("variable")
        if where[:1] == ["variable"] and len(where) > 1 and isinstance(variables, list):
            entry = variables[int(where[1])]
            subject = f"variable '{entry.get('name', f'number {int(where[1]) + 1}')}': "
            where = where[2:]
        # Beyond the key, the place is pydantic's name for one arm of a union.
        key = f"{where[0]}: " if len(where) > 0 and subject else "".join(f"{part}: " for part in where)
        yield f"{file}: {subject}{key}{problem['msg'].removeprefix('Value error, ')}"


def _problems(declaration: Declaration) -> Iterator[str]:
    """Rules that concern more than one variable."""
    names = {variable.name for variable in declaration.variable}
    if len(names) != len(declaration.variable):
        declared = [variable.name for variable in declaration.variable]
        yield from (f"variable '{name}': declared twice" for name in declared if declared.count(name) > 1)
    for name in declaration.enumeration:
        if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
            yield f"enumeration '{name}': must be CamelCase"
        if name in TAKEN:
            yield f"enumeration '{name}': the name is taken; so are {', '.join(TAKEN)}"
    for variable in declaration.variable:
        where = f"variable '{variable.name}'"
        for depth in range(1, len(variable.path)):
            prefix = ".".join(variable.path[:depth])
            if prefix in names:
                yield f"{where}: '{prefix}' is a variable and cannot be a group of variables too"
            group = "".join(word.capitalize() for word in variable.path[depth - 1].split("_"))
            if group in declaration.enumeration:
                yield f"{where}: the group '{prefix}' and the enumeration '{group}' would have one C++ name"
        if variable.type not in (*PLAIN_TYPES, *declaration.enumeration):
            known = ", ".join((*PLAIN_TYPES, *declaration.enumeration))
            yield f"{where}: type: '{variable.type}' is unknown; known are {known}"
        elif variable.start is not None:
            yield from (f"{where}: start: {text}" for text in _start_problems(variable, declaration))
        for pattern in variable.depends or []:
            if not any(fnmatchcase(v.name, pattern) for v in declaration.of("parameter", "tunable", "input")):
                yield f"{where}: depends: '{pattern}' matches no parameter or input"


def _start_problems(variable: Variable, declaration: Declaration) -> Iterator[str]:
    """Start values of the wrong number, the wrong type or out of range."""
    start, shape = variable.start, variable.shape
    if isinstance(start, list):
        rows = tuple(len(row) for row in start if isinstance(row, list))
        fits = (len(shape) == 1 and not rows and len(start) == shape[0]) or (
            len(shape) == 2 and len(start) == shape[0] and rows == (shape[1],) * shape[0]
        )
        if not fits:
            yield f"the list must have the size {list(shape) if shape else 'of a scalar'}"
            return
    for value in variable.starts:
        if variable.type in declaration.enumeration:
            items = [item.name for item in declaration.enumeration[variable.type].items]
            if value not in items:
                yield f"'{value}' is not an item of {variable.type}; items are {', '.join(items)}"
        elif variable.type == "Boolean":
            if not isinstance(value, bool):
                yield f"'{value}' must be true or false"
        elif isinstance(value, (bool, str)) or (variable.type == "Integer" and not isinstance(value, int)):
            yield f"'{value}' must be a number, of type {variable.type}"
        elif not math.isfinite(value):
            yield f"{value} must be a finite number"
        elif variable.type == "Integer" and abs(value) > INT32:
            yield f"{value} must fit into 32 bits"
        elif variable.min is not None and value < variable.min:
            yield f"{value} must be at least {variable.min}"
        elif variable.above is not None and value <= variable.above:
            yield f"{value} must be greater than {variable.above}"
        elif variable.max is not None and value > variable.max:
            yield f"{value} must be at most {variable.max}"
