"""Subcommands that are imported when they are called: `truenorth --help` needs none of what they need."""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

COMMANDS: Final = {
    "list": "listing:list_what_there_is",
    "parameters": "parameters:list_parameters",
    "run": "run:run_scenario",
    "compare": "compare:compare_filters",
    "campaign": "campaign:run_campaign",
    "paper": "paper:reproduce_paper",
    "bands": "bands:check_bands",
    "bound": "bound:show_bound",
    "import": "import_recording:import_recording",
    "replay": "replay:replay_recording",
    "derive": "derive:derive_noise",
    "export": "export:export_system",
    "verify": "verify:verify_export",
}
"""Function of every subcommand and its module in this package. The order is that of the help."""

APPEARANCE: Final[dict[str, Any]] = {
    "no_args_is_help": True,
    "rich_markup_mode": "markdown",
    "context_settings": {"help_option_names": ["-h", "--help"]},
    "pretty_exceptions_enable": False,
}
"""What `truenorth` and its subcommands have in common."""


class Command(TyperCommand):
    """A subcommand."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Its arguments and options; to complete a word, what stands before it need not be understood."""
        parameters = _with_defaults(super().get_params(ctx))
        if ctx.resilient_parsing:
            for one in parameters:  # of a text, typer makes a text by way of pydantic, in 0.1 s
                one.process_value = lambda _, value: value
        return parameters


class Commands(TyperGroup):
    """The group of `COMMANDS`: each an outline until it is called, with its summary where that is shown."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        for name in COMMANDS:
            self.add_command(TyperCommand(name))

    def get_params(self, ctx: Any) -> list[Any]:
        """Options in front of a subcommand."""
        return _with_defaults(super().get_params(ctx))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The outline of a subcommand, with its summary."""
        outline = super().get_command(ctx, cmd_name)
        if outline is not None:
            outline.short_help = _summary(COMMANDS[cmd_name])
        return outline

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """The subcommand itself, with the arguments that are left to it."""
        name, outline, rest = super().resolve_command(ctx, args)
        return name, outline and command(str(outline.name)), rest


def command(name: str) -> Any:
    """The subcommand of a name, with its options."""
    module, function = COMMANDS[name].split(":")
    one = typer.Typer(add_completion=False, **{**APPEARANCE, "no_args_is_help": False})
    one.command(name, cls=Command)(getattr(import_module(f"{__package__}.{module}"), function))
    return get_command(one)


def _with_defaults(parameters: list[Any]) -> list[Any]:
    """Parameters with a default for every flag: of None, typer makes False by way of pydantic, in 0.1 s."""
    for one in parameters:
        if getattr(one, "is_flag", False):
            one.default = bool(one.default)
    return parameters


def _summary(function: str) -> str:
    """First sentence of the docstring of a subcommand, read without importing it."""
    module, name = function.split(":")
    tree = ast.parse((Path(__file__).parent / f"{module}.py").read_text(encoding="utf-8"))
    found = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name)
    return (ast.get_docstring(found) or "").partition("\n")[0]
