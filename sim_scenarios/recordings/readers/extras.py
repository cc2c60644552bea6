"""Packages that some formats need and the product does without."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from sim_scenarios.errors import InputError


def needed(module: str, package: str, task: str) -> Any:
    """Module of an optional package that a task needs.

    Raises
    ------
    InputError
        If it is not installed; the sentence says how to get it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(f"{task} needs the package {package}: pip install truenorth[recordings]") from None
