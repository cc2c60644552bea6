"""`truenorth verify`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios.cli.options import AsJson
from sim_scenarios.cli.terminal import console, print_json, print_verdict, refusing_bad_input


def verify_export(
    path: Annotated[Path, typer.Argument(help="Folder that `truenorth export` wrote, or one FMU of it.")],
    as_json: AsJson = False,
) -> None:
    """Say whether an export is what was written, valid, and still gives its reference results.

    For example:

        truenorth verify truenorth-export/swaying_ship
        truenorth verify partner/fmi3/AlignmentFilter.fmu

    Nothing is run whose content has changed. Exit code 0 when all holds, 1 when something does not.
    """
    from sim_scenarios.exchange.verification import verify  # slow: FMPy

    with refusing_bad_input():
        checks = verify(path)
    holds = all(check.holds for check in checks)
    if as_json:
        print_json({"path": str(path), "holds": holds, "checks": [asdict(check) for check in checks]})
    else:
        page = console()
        for check in checks:
            page.print(f"{'holds' if check.holds else 'FAILS'}  {check.what}", highlight=False, markup=False)
            for finding in check.findings:
                page.print(f"       {finding}", highlight=False, markup=False)
        print_verdict("All of it holds" if holds else "Not all of it holds", holds)
    raise typer.Exit(0 if holds else 1)
