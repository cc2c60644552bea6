"""Ports: the inputs and outputs that belong to one sensor, as terminals (FMI 3.0, 2.9; allowed in FMI 2.0.4).

A tool connects two terminals of the same kind member by member, by the members' names.
"""

from __future__ import annotations

from dataclasses import dataclass

from declaration import Declaration

PORTS = {
    "imu": "Increments of an inertial measurement unit",
    "gnss": "Fixes of a GNSS receiver",
    "body_velocity": "Velocities in body axes",
    "heading_aid": "Headings",
    "height_aid": "Heights",
}
"""Groups of inputs and outputs that are a port, and what the port carries."""


@dataclass(frozen=True)
class Member:
    """A variable of a port."""

    name: str
    """Within the port; the same in every component."""
    variable: str


@dataclass(frozen=True)
class Terminal:
    """A port of a component."""

    name: str
    description: str
    members: list[Member]


def terminals(declaration: Declaration, *, arrays: bool) -> list[Terminal]:
    """Ports of a component, with arrays as single variables (FMI 3) or as their scalars (FMI 2)."""
    found = []
    for port, description in PORTS.items():
        variables = [v for v in declaration.of("input", "output") if v.path[0] == port]
        names = [name for v in variables for name in ([v.name] if arrays else v.scalar_names)]
        if names:
            members = [Member(name.removeprefix(f"{port}."), name) for name in names]
            found.append(Terminal(port, description, members))
    return found
