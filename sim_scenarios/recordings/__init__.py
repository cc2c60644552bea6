"""Recordings of real vehicles: what a file says, in this product's units, axes and on one clock."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sim_scenarios.recordings.description import load
    from sim_scenarios.recordings.tables import Recording

__all__ = ["Recording", "load"]

_HOMES = {"Recording": "tables", "load": "description"}


def __getattr__(name: str) -> object:
    """What the package offers, imported when it is first asked for: options are words of its `choices`."""
    if name in _HOMES:
        return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
