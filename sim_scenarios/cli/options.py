"""Arguments and options that several subcommands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios import toml
from sim_scenarios.errors import InputError

Scenario = Annotated[
    str,
    typer.Argument(
        help="Name of a shipped scenario (`truenorth list`), or path of a TOML file.", show_default=False
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Folder of the report; what is there is replaced. Without it, a new folder.",
        show_default="truenorth-results/...",
    ),
]
Seed = Annotated[
    int | None, typer.Option(help="Seed of every random stream.", show_default="of the scenario")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Set a parameter of an FMU or an entry of the scenario; SI units, or with a unit. Repeatable.",
        show_default=False,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, and nothing else there.")
]


def settings(given: list[str] | None) -> dict[str, object]:
    """Settings NAME=VALUE; a value is read as in a scenario file, a bare text needs no quotes."""
    values: dict[str, object] = {}
    for setting in given or []:
        name, equals, text = setting.partition("=")
        if not equals or not name.strip():
            raise InputError(f"--set {setting}: write NAME=VALUE")
        values[name.strip()] = toml.value(text)
    return values
