"""What `<Component>.toml` may say, and the sentences for what one entry may not; `reading` reads it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import groupby
from math import isnan
from typing import Annotated, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator
from units import UNITS, Unit

Value: TypeAlias = bool | int | float | str
Start: TypeAlias = Value | list[Value] | list[list[Value]]

PLAIN_TYPES = ("Real", "Integer", "Boolean")
TAKEN = (
    *PLAIN_TYPES, "Parameters", "Inputs", "Outputs", "Interface", *(unit.quantity for unit in UNITS.values())
)  # fmt: skip
LONGEST_NAME = 63

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
    unit: str | Annotated[list[str], Field(min_length=2)] | None = None
    display_unit: str | None = None
    start: Start | None = None
    min: int | float | None = None
    above: int | float | None = None
    max: int | float | None = None
    nominal: float | None = Field(default=None, gt=0.0)
    at_start: bool = False
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
            if isinstance(self.unit, list) and self.shape != (len(self.unit),):
                raise ValueError("unit: a list must have one unit for each element of a vector")
            for unit in dict.fromkeys(self.units):
                if unit not in UNITS:
                    raise ValueError(f"unit: '{unit}' is unknown; known are {', '.join(UNITS)}")
                display = UNITS[unit].display
                if self.display_unit is not None and self.display_unit not in display:
                    known = ", ".join(display) or "none"
                    raise ValueError(f"display_unit: '{self.display_unit}' is unknown; for {unit}: {known}")
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
        if self.at_start and self.causality != "input":
            raise ValueError("at_start: only an input may have it")
        return self

    @property
    def optional(self) -> bool:
        """Whether it starts as NaN: an input that need not be given, and has no limits."""
        return self.causality == "input" and isinstance(self.start, float) and isnan(self.start)

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
    def units(self) -> list[str]:
        """Unit of each scalar, in the order of `indices`; none unless the type is Real."""
        if self.unit is None:
            return []
        return self.unit if isinstance(self.unit, list) else [self.unit] * len(self.indices)

    @property
    def _limit_of_units(self) -> float | None:
        """Size that a Real which the component reads once and believes may have, by its units."""
        believed = self.causality in ("parameter", "tunable") or (self.at_start and not self.optional)
        return min(UNITS[unit].most for unit in self.units) if self.type == "Real" and believed else None

    @property
    def largest(self) -> int | float | None:
        """The inclusive upper limit: the declared one, or that of the units."""
        return self._limit_of_units if self.max is None else self.max

    @property
    def smallest(self) -> int | float | None:
        """The inclusive lower limit likewise; none when there is an exclusive one."""
        if self.min is not None or self.above is not None:
            return self.min
        return None if self._limit_of_units is None else -self._limit_of_units

    @property
    def unit_text(self) -> str:
        """The unit for people: `m`, or `m (1 to 12), m/s (13 to 24)`."""
        if not isinstance(self.unit, list):
            return self.unit or ""
        runs = [(unit, list(run)) for unit, run in groupby(range(len(self.unit)), self.unit.__getitem__)]
        return ", ".join(f"{unit} ({run[0] + 1} to {run[-1] + 1})" for unit, run in runs)

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


class Fragment(_Strict):
    """Variables and enumerations that several components share."""

    settings: list[str] = []
    """Groups of parameters whose structs, with the enumerations, are there for all components."""
    enumeration: dict[str, Enumeration] = {}
    variable: list[Variable] = Field(min_length=1)

    def of(self, *causalities: str) -> list[Variable]:
        """Variables of these causalities, in order of declaration."""
        return [variable for variable in self.variable if variable.causality in causalities]

    def in_settings(self) -> list[Variable]:
        """The parameters of the groups in `settings`."""
        return [v for v in self.of("parameter", "tunable") if v.path[0] in self.settings]


class Declaration(Fragment):
    """A component: its variables, its enumerations, its default experiment."""

    name: str
    description: str = Field(min_length=1)
    default_experiment: Experiment
    shared: dict[str, Fragment] = {}
    """Files that have settings, by the names of their headers, without what the component overrides."""

    @property
    def snake_name(self) -> str:
        """`AlignmentFilter` -> `alignment_filter`: C++ namespace and file name."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", self.name).lower()

    @property
    def own_enumerations(self) -> dict[str, Enumeration]:
        """Those that do not come from the settings."""
        return {name: e for name, e in self.enumeration.items() if name not in self.shared_enumerations}

    @property
    def shared_enumerations(self) -> list[str]:
        """Those that the settings have."""
        return [name for part in self.shared.values() for name in part.enumeration]

    @property
    def scalars(self) -> list[Scalar]:
        """Every variable's elements, in order of declaration."""
        elements = [(v, i, name) for v in self.variable for i, name in enumerate(v.scalar_names)]
        return [Scalar(name, v, i, reference) for reference, (v, i, name) in enumerate(elements)]

    def units(self) -> dict[str, Unit]:
        """Units in use."""
        used = {unit for variable in self.variable for unit in variable.units}
        return {name: unit for name, unit in UNITS.items() if name in used}

    def known_at_start(self) -> list[Variable]:
        """Parameters and inputs on which outputs depend in initialisation."""
        return [v for v in self.variable if v.causality in ("parameter", "tunable") or v.at_start]


def _check_identifier(name: str) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
        raise ValueError(f"name: '{name}' must be lower-case words joined by underscores")
    if name in RESERVED:
        raise ValueError(f"name: '{name}' is a reserved word in C++")
