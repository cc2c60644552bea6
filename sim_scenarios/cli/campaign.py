"""`truenorth campaign`."""

from __future__ import annotations

import logging
import shlex
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bar

from sim_scenarios.cli import INTERRUPTED
from sim_scenarios.cli.options import AsJson, Output, Settings, SettingsFile, campaigns, settings
from sim_scenarios.cli.results import DEFAULT, Results, storing
from sim_scenarios.cli.terminal import (
    console,
    is_quiet,
    print_json,
    print_pairs,
    print_table,
    refusing_bad_input,
)
from sim_scenarios.stepping import Master

if TYPE_CHECKING:
    from sim_scenarios.studies.campaign import Campaign
    from sim_scenarios.studies.execution import Effort, Progress
    from sim_scenarios.studies.expectations import Row
    from sim_scenarios.studies.statistics import CaseSummary

MOST_FAILURES: Final = 5
"""Reasons of failed runs that are told."""
MANY_PICTURES: Final = 20
"""Of a report, whose drawing takes long enough to be told of."""

OVERWRITE: Final = "--overwrite"

Name = Annotated[
    str,
    typer.Argument(
        metavar="FILE|SCENARIO",
        help="Campaign file (TOML), shipped campaign, or scenario (`truenorth list`).",
        show_default=False,
        autocompletion=campaigns,
    ),
]
Runs = Annotated[
    int | None,
    typer.Option("--runs", "-n", help="Runs of every case; their seeds count up.", show_default="100"),
]
FirstSeed = Annotated[int | None, typer.Option("--seed", help="Seed of the first run.", show_default="1")]
Labels = Annotated[
    list[str] | None,
    typer.Option("--filter", metavar="LABEL", help="Filter to run. Repeatable.", show_default="all"),
]
NamedCases = Annotated[
    list[str] | None,
    typer.Option("--case", metavar="LABEL", help="Case of the file to run. Repeatable.", show_default="all"),
]
Grid = Annotated[
    list[str] | None,
    typer.Option(
        "--grid",
        metavar="NAME=[VALUES]",
        help="Values of a parameter; every combination is a case. Repeatable.",
        show_default=False,
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Processes of this machine.", show_default="one for each core"),
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Dask scheduler to use instead, such as tls://host:8786.", show_default=False),
]
Insecure = Annotated[
    bool, typer.Option("--insecure", help="Take a scheduler of another machine without TLS, too.")
]
Stepping = Annotated[
    Master, typer.Option(help="Who steps plant and filters: compiled code, or Python. Same results.")
]
Overwrite = Annotated[
    bool, typer.Option(OVERWRITE, help="Discard the results of another campaign in the folder.")
]


def run_campaign(
    name: Name,
    runs: Runs = None,
    seed: FirstSeed = None,
    filters: Labels = None,
    named: NamedCases = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    grid: Grid = None,
    output: Output = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    insecure: Insecure = False,
    master: Stepping = Master.auto,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> None:
    """Run many seeds of scenarios and filters, and say what they are worth together.

    What is done is stored at once. The same command resumes a campaign that was stopped, and only writes
    the report of one that is complete. Run k has the seed of the first run + k; `truenorth compare` with
    that seed shows the run alone, where the filters are those of the scenario.

    For example:

        truenorth campaign swaying_ship -n 100
        truenorth campaign zigzag -n 50 --filter EKF --filter UKF --grid "gnss.rate=[1, 5, 10]"
        truenorth campaign filters_by_scenario
        truenorth campaign faults --case "IMU silence" -n 2
        truenorth campaign my_campaign.toml --scheduler tls://192.168.0.7:8786 --output /shared/results

    Exit code 0 when every run came to its end, 1 when one stopped with an error or a figure is not what the
    file expects, 130 when interrupted.
    """
    from sim_scenarios.studies import table  # slow: Dask, Zarr
    from sim_scenarios.studies.campaign import Campaign
    from sim_scenarios.studies.plan import load_plan

    with refusing_bad_input():
        plan = load_plan(
            name,
            runs=runs,
            seed=seed,
            filters=tuple(filters) if filters else None,
            cases=tuple(named) if named else None,
            set=settings(set_, set_from),
            grid=settings(grid, option="--grid"),
        )
        folder = output or DEFAULT / f"campaign-{plan.name}"
        Results(folder)
        campaign = Campaign.of(plan, folder, master)
        with storing(folder, "; what is done is kept, and the same command resumes"):
            effort = run_or_say_how_to_go_on(
                campaign, workers=workers, scheduler=scheduler, insecure=insecure, overwrite=overwrite
            )
            cases, measured, files = written(campaign)
    expected = [row.to_json() for row in measured]
    if as_json:
        figures = {case.label: table.for_machines(case) for case in cases}
        about = {"campaign": plan.name, "runs": plan.runs, "seed": plan.seed}
        print_json({**about, "cases": figures, **({"expected": expected} if expected else {}), **files})
    else:
        _print(cases, measured, effort, files)
    stopped = any(one.stopped for case in cases for one in case.filters.values())
    raise typer.Exit(int(stopped or any(row.missed for row in measured)))


def written(campaign: Campaign) -> tuple[list[CaseSummary], list[Row], dict[str, str]]:
    """What a campaign says, what is expected of it, and the files of its report."""
    from sim_scenarios.studies import page, store
    from sim_scenarios.studies.statistics import summarise

    data, plan, measured = store.open_results(campaign.folder), campaign.plan, campaign.measured()
    cases = list(summarise(data, plan))

    def report(done: int, total: int) -> None:
        if total >= MANY_PICTURES and 10 * done // total > 10 * (done - 1) // total:
            print(f"{plan.name}: {done} of {total} pictures", file=sys.stderr, flush=True)

    return cases, measured, page.write(data, cases, campaign.folder, plan.expect, measured, report)


def run_or_say_how_to_go_on(campaign: Campaign, **how: Any) -> Effort:
    """Run what is missing of a campaign; an interruption says how to go on.

    Dask logs a traceback for every connection that is torn; the sentences of this command say it all.
    """
    logging.disable(logging.ERROR)
    try:
        with _progress(campaign.plan.name) as report:
            return campaign.run(**how, report=report)
    except KeyboardInterrupt:
        command = shlex.join(["truenorth", *(word for word in sys.argv[1:] if word != OVERWRITE)])
        typer.echo(
            f"truenorth: stopped; what is done is kept in {campaign.folder}, and the same command resumes:\n"
            f"  {command}",
            err=True,
        )
        raise typer.Exit(INTERRUPTED) from None


def _print(cases: list[CaseSummary], measured: list[Row], effort: Effort, files: dict[str, str]) -> None:
    from sim_scenarios.studies import table

    for case in cases:
        console().print(case.label, style="bold", highlight=False, markup=False)
        print_table(table.figures(case))
        print_table(table.certainty(case))
        if rows := table.own_figures(case):
            print_table(rows)
        console().print()
    if measured:
        print_table(table.expectations(measured))
    for chunk in effort.damaged[:MOST_FAILURES]:
        typer.echo(f"{chunk} was lost or damaged; its runs have been done again", err=True)
    for failure in effort.failures[:MOST_FAILURES]:
        typer.echo(f"a run failed: {failure}", err=True)
    print_pairs({**_effort(effort), "Report": files["report"], "Data": files["data"]})


def _effort(effort: Effort) -> dict[str, str]:
    if effort.runs == 0:
        return {"Runs": "all were there already"}
    return {
        "Runs": f"{effort.runs} in {effort.wall:.1f} s on {effort.workers} workers",
        "Not in runs": f"{100 * effort.overhead:.1f} % of the workers' time",
    }


@contextmanager
def _progress(title: str) -> Iterator[Callable[[Progress], None]]:
    """Progress on standard error: a bar on a terminal, else a line for each tenth."""
    if is_quiet():
        yield lambda _: None
        return
    standard_error = Console(stderr=True)
    if not standard_error.is_terminal:
        yield _tenths(title)
        return
    title_column, said_column = (
        TextColumn(f"{{task.{what}}}", markup=False) for what in ("description", "fields[said]")
    )
    columns = (title_column, BarColumn(), said_column)
    with Bar(*columns, console=standard_error, transient=True) as bar:
        task = bar.add_task(title, total=1.0, said="starting")
        yield lambda p: bar.update(task, total=p.total, completed=p.done, said=_said(p))


def _tenths(title: str) -> Callable[[Progress], None]:
    reported = -1

    def report(progress: Progress) -> None:
        nonlocal reported
        if (tenth := 10 * progress.done // progress.total) > reported:
            reported = tenth
            print(f"{title}: {_said(progress)}", file=sys.stderr, flush=True)

    return report


def _said(progress: Progress) -> str:
    said = f"{progress.done} of {progress.total} runs, {progress.failed} failed"
    if progress.rate > 0:
        said += f", {progress.rate:.2f} a second, {progress.left:.0f} s left"
    return said
