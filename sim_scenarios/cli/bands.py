"""`truenorth bands`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from sim_scenarios import catalogue
from sim_scenarios.cli.campaign import Insecure, Scheduler, Workers, run_or_say_how_to_go_on, written
from sim_scenarios.cli.options import AsJson, Output
from sim_scenarios.cli.results import DEFAULT, Results, storing
from sim_scenarios.cli.terminal import print_json, refusing_bad_input
from sim_scenarios.errors import InputError

if TYPE_CHECKING:
    from sim_scenarios.studies.expectations import Row


def bands(incomplete: str) -> list[str]:
    """Scenarios with bands that begin so."""
    return [name for name in catalogue.files(catalogue.BANDS) if name.startswith(incomplete)]


Names = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="SCENARIO...", help="Scenarios to check.", show_default="all with bands", autocompletion=bands
    ),
]
Only = Annotated[list[str] | None, typer.Option("--only", metavar="SCENARIO", help="The same.", hidden=True)]
Runs = Annotated[
    int | None,
    typer.Option("--runs", "-n", min=1, help="Runs of each.", show_default="those that its bands are for"),
]


def check_bands(
    names: Names = None,
    only: Only = None,
    runs: Runs = None,
    output: Output = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    insecure: Insecure = False,
    as_json: AsJson = False,
) -> None:
    """Check the bands that the filters must keep, over many runs.

    What is done is kept, and the same command goes on where it was stopped; what FMUs, package or scenario
    have changed is measured anew. The table is Markdown, and every scenario has a page with its curves.

    For example:

        truenorth bands
        truenorth bands zigzag turn -n 10

    Exit code 0 when every band is kept, 1 when one is missed.
    """
    from sim_scenarios import markdown
    from sim_scenarios.studies import execution, table  # slow: Dask, Zarr
    from sim_scenarios.studies.campaign import Campaign
    from sim_scenarios.studies.plan import load_plan

    with refusing_bad_input():
        files = catalogue.files(catalogue.BANDS)
        chosen = [*(only or []), *(names or [])] or [*files]
        if unknown := [name for name in chosen if name not in files]:
            raise InputError(f"there are no bands of '{unknown[0]}'; there are those of {', '.join(files)}")
        folder = output or DEFAULT / "bands"
        Results(folder)
        found: list[Row] = []
        with storing(folder), execution.workers(workers, scheduler, insecure) as working:
            for name in chosen:
                plan = load_plan(files[name], runs=runs)
                labels = (label for expectations in plan.expect for label in expectations.filters())
                plan = plan.model_copy(update={"filters": tuple(dict.fromkeys(labels))})
                campaign = Campaign.of(plan, folder / name)
                run_or_say_how_to_go_on(campaign, overwrite=True, working=working)
                _, measured, _ = written(campaign)
                found += measured
                if not as_json:
                    lines = markdown.table(table.expectations(measured, digits=4)).splitlines()
                    print("\n".join(lines if name == chosen[0] else lines[2:]), flush=True)
    if as_json:
        print_json({"rows": [row.to_json() for row in found], "report": str(folder)})
    raise typer.Exit(int(any(row.missed for row in found)))
