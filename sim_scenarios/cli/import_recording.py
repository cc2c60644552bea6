"""`truenorth import`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios.cli.options import written
from sim_scenarios.cli.terminal import print_names, print_pairs, refusing_bad_input, say
from sim_scenarios.errors import InputError
from sim_scenarios.folders import filled


def import_recording(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE", help="What was recorded together.", show_default=False)
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", parser=written, metavar="TOML", help="The description that is written."
        ),
    ] = Path("recording.toml"),
    force: Annotated[bool, typer.Option("--force", help="Replace the description if there is one.")] = False,
) -> None:
    r"""Draft the description of a recording by looking at its files.

    It says which file holds what, in which columns, units and axes, on which clock; each guess says why it
    was made. Fill in the mounting and the lever arms, and mend what is wrong.

    For example:

        truenorth import imu.csv.gz gnss.pos.gz
        truenorth import gyro.csv acc.csv gnss.csv
        truenorth import flight.ulg -o flight/recording.toml
    """
    with refusing_bad_input():
        from sim_scenarios.recordings import checks, description, drafting

        if output.exists() and not force:
            raise InputError(f"{output}: exists; replace it with --force, or write another with -o")
        text, guesses = drafting.draft(files, output.parent)
        with filled(output.parent) as draft:
            (draft / output.name).write_text(text, encoding="utf-8")
        print_names([["Guess", "Why"], *(guess.split(": ", 1) for guess in guesses)])
        try:
            doubts = checks.doubts(description.load(output))
        except InputError as error:
            doubts = [str(error)]
        for doubt in doubts:
            say(f"truenorth: {doubt}")
        print_pairs({"Description": str(output)})
