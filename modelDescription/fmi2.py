"""The FMI 2.0 side of a declaration: start values and dependencies as modelDescription.xml spells them."""

from __future__ import annotations

from declaration import Declaration, Scalar


class Fmi2:
    """FMI 2.0 spellings for one declaration."""

    def __init__(self, declaration: Declaration) -> None:
        self._declaration = declaration

    def start(self, scalar: Scalar) -> str | None:
        """Start value; None for an output, which is calculated."""
        variable = scalar.variable
        if variable.start is None:
            return None
        value = variable.starts[scalar.position]
        if variable.type in self._declaration.enumeration:
            return str(self._declaration.enumeration[variable.type].value(str(value)))
        if variable.type == "Boolean":
            return "true" if value else "false"
        if variable.optional:
            return "NaN"
        return repr(float(value)) if variable.type == "Real" else str(value)

    @property
    def dependencies(self) -> str:
        """Indices, from 1, of the scalars on which every output may depend in initialisation."""
        known = {variable.name for variable in self._declaration.known_at_start()}
        return " ".join(str(s.reference + 1) for s in self._declaration.scalars if s.variable.name in known)
