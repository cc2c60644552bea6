"""The FMI 3.0 side of a declaration: arrays are one variable, whose reference is that of its first scalar."""

from __future__ import annotations

from declaration import Declaration, Variable
from fmi2 import Fmi2

TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}


class Fmi3:
    """FMI 3.0 spellings for one declaration."""

    def __init__(self, declaration: Declaration) -> None:
        self._declaration = declaration
        self._scalars: dict[str, list[str | None]] = {}
        self._references: dict[str, int] = {}
        fmi2 = Fmi2(declaration)
        for scalar in declaration.scalars:
            self._references.setdefault(scalar.variable.name, scalar.reference)
            self._scalars.setdefault(scalar.variable.name, []).append(fmi2.start(scalar))

    def element(self, variable: Variable) -> str:
        """Name of the XML element."""
        return TYPES.get(variable.type, "Enumeration")

    def reference(self, variable: Variable) -> int:
        """Value reference."""
        return self._references[variable.name]

    @property
    def time(self) -> int:
        """Value reference of the time: it follows the last scalar."""
        return len(self._declaration.scalars)

    def start(self, variable: Variable) -> str | None:
        """Start values of all elements; None for an output."""
        starts = [start for start in self._scalars[variable.name] if start is not None]
        return " ".join(starts) or None

    def unit(self, variable: Variable) -> str | None:
        """Unit of all elements; None when they have different ones, which FMI 3 cannot say."""
        return variable.units[0] if len(set(variable.units)) == 1 else None

    def description(self, variable: Variable) -> str:
        """What it is; the units too, when the elements have different ones."""
        mixed = len(set(variable.units)) > 1
        return f"{variable.description} [{variable.unit_text}]" if mixed else variable.description

    @property
    def dependencies(self) -> str:
        """References of the variables on which every output may depend in initialisation."""
        return " ".join(str(self.reference(variable)) for variable in self._declaration.known_at_start())
