"""The C++ side of a declaration: types, literals and the nesting of dotted names into structs."""

from __future__ import annotations

from dataclasses import dataclass, field

from declaration import Declaration, Fragment, Value, Variable


@dataclass(frozen=True)
class Member:
    """A data member: a variable, or a nested struct with members of its own (`variable` is None)."""

    name: str
    variable: Variable | None = None
    members: list[Member] = field(default_factory=list)
    shared: bool = False
    """A struct of the settings, in which the variables of `members` start from other values than there."""

    @property
    def type_name(self) -> str:
        """CamelCase name of the nested struct."""
        return camel(self.name)


def camel(name: str) -> str:
    """`lever_arm` -> `LeverArm`."""
    return "".join(word.capitalize() for word in name.split("_"))


def parameters(declaration: Declaration) -> list[Member]:
    """Members of the component's parameters; groups of the settings are structs that exist."""
    settings = {v.name: v for part in declaration.shared.values() for v in part.in_settings()}
    members = nest(declaration.of("parameter", "tunable"))
    groups = {v.path[0] for v in settings.values()}

    def starts_otherwise(member: Member) -> bool:
        variable = member.variable
        return variable is not None and variable.start != settings[variable.name].start

    return [
        Member(m.name, members=[*filter(starts_otherwise, m.members)], shared=True) if m.name in groups else m
        for m in members
    ]


def nest(variables: list[Variable]) -> list[Member]:
    """Dotted names as nested members, in order of first mention."""
    top: list[Member] = []
    for variable in variables:
        members = top
        for part in variable.path[:-1]:
            group = next((m for m in members if m.name == part), None)
            if group is None:
                group = Member(part)
                members.append(group)
            members = group.members
        members.append(Member(variable.path[-1], variable))
    return top


class Cpp:
    """C++ spellings for the variables of a component, or of settings."""

    def __init__(self, declaration: Fragment) -> None:
        self._declaration = declaration

    def scalar_type(self, variable: Variable) -> str:
        """Type of one element."""
        return {"Real": "double", "Integer": "int", "Boolean": "bool"}.get(variable.type, variable.type)

    def type(self, variable: Variable) -> str:
        """Type of the member."""
        scalar, shape = self.scalar_type(variable), variable.shape
        if not shape:
            return scalar
        if variable.type != "Real":
            return f"std::array<{scalar}, {shape[0]}>"
        if shape == (3,):
            return "Eigen::Vector3d"
        if len(shape) == 1:
            return f"Eigen::Matrix<double, {shape[0]}, 1>"
        return f"Eigen::Matrix<double, {shape[0]}, {shape[1]}, Eigen::RowMajor>"

    def literal(self, variable: Variable, value: Value) -> str:
        """Write a start value; doubles so that they read back to the same bits."""
        if variable.type == "Real":
            return "std::numeric_limits<double>::quiet_NaN()" if variable.optional else repr(float(value))
        if variable.type == "Boolean":
            return "true" if value else "false"
        return str(value) if variable.type == "Integer" else f"{variable.type}::{value}"

    def initialiser(self, variable: Variable) -> str:
        """Default member initialiser; outputs start from zero, enumerations from their first item."""
        if variable.start is None:
            first = self._declaration.enumeration.get(variable.type)
            zero: Value = first.items[0].name if first else 0
            values = [self.literal(variable, zero)] * len(variable.indices)
        else:
            values = [self.literal(variable, value) for value in variable.starts]
        shape = variable.shape
        if not shape:
            return f" = {values[0]}"
        if variable.type == "Real" and len(set(values)) == 1:
            return f" = {self.type(variable)}::Constant({values[0]})"
        if len(shape) == 2:
            rows = [values[row * shape[1] : (row + 1) * shape[1]] for row in range(shape[0])]
            return "{" + ", ".join("{" + ", ".join(row) + "}" for row in rows) + "}"
        return "{" + ", ".join(values) + "}"

    def group(self, variable: Variable) -> str:
        """Name the component's member that holds the variable."""
        return {"input": "inputs", "output": "outputs"}.get(variable.causality, "parameters")

    def elements(self, variable: Variable) -> list[str]:
        """How each scalar is reached from the struct: `imu.time`, `imu.delta_angle(0)`, `flags[0]`."""
        if variable.type != "Real":
            return [f"{variable.name}[{index[0]}]" if index else variable.name for index in variable.indices]
        return [
            f"{variable.name}({', '.join(map(str, index))})" if index else variable.name
            for index in variable.indices
        ]

    def limit(self, variable: Variable, value: float) -> str:
        """Write a limit as a literal of the variable's type."""
        return repr(float(value)) if variable.type == "Real" else str(int(value))
