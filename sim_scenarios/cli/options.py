"""Arguments and options that several subcommands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios import catalogue, toml
from sim_scenarios.errors import InputError


def scenarios(incomplete: str) -> list[tuple[str, str]]:
    """Names and descriptions of the scenarios that begin so, for the completion of a shell."""
    return [(name, text) for name, text in catalogue.scenarios().items() if name.startswith(incomplete)]


def campaigns(incomplete: str) -> list[tuple[str, str]]:
    """Names and descriptions of campaigns and scenarios that begin so."""
    shipped = [(name, text) for name, text in catalogue.campaigns().items() if name.startswith(incomplete)]
    return [*shipped, *scenarios(incomplete)]


def papers(incomplete: str) -> list[tuple[str, str]]:
    """Names and citations of papers that begin so."""
    return [(name, text) for name, text in catalogue.papers().items() if name.startswith(incomplete)]


def written(name: str) -> Path:
    """The path of what a command writes; an empty one, of a variable that was not set, is no folder."""
    if not name:
        raise typer.BadParameter("is empty; `.` is the folder that you are in")
    return Path(name)


Scenario = Annotated[
    str,
    typer.Argument(
        help="Name of a shipped scenario (`truenorth list`), or of a TOML file, with `.toml` or without.",
        show_default=False,
        autocompletion=scenarios,
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        parser=written,
        metavar="PATH",
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
SettingsFile = Annotated[
    list[Path] | None,
    typer.Option(
        "--set-from",
        metavar="FILE",
        help="Take settings from a TOML file, such as one of `truenorth derive`; --set goes before it. "
        "Repeatable.",
        show_default=False,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, and nothing else there.")
]


def settings(
    given: list[str] | None, files: list[Path] | None = None, option: str = "--set"
) -> dict[str, object]:
    """Settings of files, and settings NAME=VALUE of an option in front of them.

    A value is read as in a scenario file, a bare text needs no quotes; tables of a file give dotted names.
    """
    values: dict[str, object] = {}
    for path in files or []:
        values |= dict(toml.dotted(toml.read(path)))
    for setting in given or []:
        name, equals, text = setting.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{option} {setting}: write NAME=VALUE")
        values.pop(name.strip(), None)  # the last setting counts, also of an array and its elements
        values[name.strip()] = toml.value(text)
    return values


def axes(given: list[str] | None) -> dict[str, list[object]]:
    """Axes NAME=VALUE,VALUE...; a value is read as in a scenario file, a bare text needs no quotes."""
    found: dict[str, list[object]] = {}
    for axis in given or []:
        name, _, text = (part.strip() for part in axis.partition("="))
        values = [toml.value(value) for value in text.split(",") if value.strip()]
        if not name or not values:
            raise InputError(f"--axis {axis}: write NAME=VALUE,VALUE...")
        if name in found:
            raise InputError(f"--axis {axis}: {name} has been given before")
        labels = {str(value) for value in values}
        if len(labels) < len(values) or any(value in values[:i] for i, value in enumerate(values)):
            raise InputError(f"--axis {axis}: give each value once")
        found[name] = values
    return found
