"""`truenorth verify`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from sim_scenarios.cli.options import AsJson
from sim_scenarios.cli.terminal import console, print_json, print_verdict, refusing_bad_input


def verify_export(
    path: Annotated[Path, typer.Argument(help="Folder that `truenorth export` wrote, or one FMU of it.")],
    expect: Annotated[
        str | None,
        typer.Option(
            metavar="SHA256",
            help="SHA-256 of the list of checksums, which `truenorth export` printed, as it was told "
            "by another way than the export came.",
        ),
    ] = None,
    signed_by: Annotated[
        Path | None,
        typer.Option(
            metavar="PUBLIC_KEY",
            help="PEM file of the public key that the list of checksums must be signed with (Ed25519).",
        ),
    ] = None,
    no_run: Annotated[
        bool, typer.Option("--no-run", help="Run nothing of it: do not repeat the reference results.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Say whether an export fits its list of checksums, is valid, and still gives its reference results.

    For example:

        truenorth verify truenorth-export/swaying_ship
        truenorth verify partner/fmi3/AlignmentFilter.fmu --no-run

    The list lies in what it protects: who it is from, only `--expect` or `--signed-by` can tell. The FMUs are
    run with your rights, but none whose content does not fit, or whose list is not the expected one. Exit
    code 0 when all holds, 1 when something does not.
    """
    from sim_scenarios.exchange.verification import verify  # slow: FMPy

    with refusing_bad_input():
        checks = verify(path, expect=expect, signed_by=signed_by, run=not no_run)
    holds = all(check.holds for check in checks)
    if as_json:
        print_json({"path": str(path), "holds": holds, "checks": [asdict(check) for check in checks]})
    else:
        page = console()
        for check in checks:
            _print_line(page, f"{'holds' if check.holds else 'FAILS'}  {check.what}")
            for finding in check.findings:
                _print_line(page, f"       {finding}")
        verdict = "All of it holds" if holds else "Not all of it holds"
        print_verdict(f"{verdict}; nothing was run" if no_run else verdict, holds)
    raise typer.Exit(0 if holds else 1)


def _print_line(page: Console, text: str) -> None:
    """One line, whatever names of files are in it."""
    from sim_scenarios.names import printable  # slow: pydantic

    line = printable(text).replace("\n", "\\n").replace("\t", "\\t")
    page.print(line, highlight=False, markup=False, emoji=False)
