"""`truenorth paper`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from sim_scenarios import catalogue
from sim_scenarios.cli.campaign import Insecure, Scheduler, Workers
from sim_scenarios.cli.options import AsJson, Output, papers
from sim_scenarios.cli.results import DEFAULT, Results, storing
from sim_scenarios.cli.terminal import (
    console,
    print_json,
    print_names,
    print_pairs,
    print_table,
    progress,
    refusing_bad_input,
    say,
)
from sim_scenarios.folders import reserved

if TYPE_CHECKING:
    from sim_scenarios.papers import Paper, page
    from sim_scenarios.papers.claims import Point, Timed
    from sim_scenarios.papers.reproduction import Plan, Plans

Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help=f"One of {', '.join(catalogue.papers())}.",
        show_default=False,
        autocompletion=papers,
    ),
]
List = Annotated[
    bool,
    typer.Option("--list", help="List what the paper numbers and what is drawn for it, without running it."),
]
Runs = Annotated[
    int | None,
    typer.Option("--runs", "-n", min=1, help="Runs of every scenario.", show_default="of the paper"),
]
FirstSeed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the first run; the others count up.")]

KEPT: Final = "runs that are done are kept, and the same command goes on with the rest"


def reproduce_paper(
    name: Name,
    listing: List = False,
    runs: Runs = None,
    seed: FirstSeed = 1,
    output: Output = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    insecure: Insecure = False,
    as_json: AsJson = False,
) -> None:
    """Reproduce what a paper prints: its figures beside those measured here, and why they differ.

    Finished runs are kept in the output folder: the same command goes on where it was stopped, and does only
    what is new when `-n` grows.

    For example:

        truenorth paper zhou --list
        truenorth paper zhou
        truenorth paper zhao -n 20 --output results

    Exit code 0 when all runs are done, whatever they say.
    """
    from sim_scenarios.papers import load_paper  # slow: xarray, scipy

    with refusing_bad_input():
        paper = load_paper(name)
    if listing:
        _list(paper, as_json)
        return
    from sim_scenarios.papers import page
    from sim_scenarios.papers.claims import Swept, points
    from sim_scenarios.papers.reproduction import plans, result_of, run_plans
    from sim_scenarios.studies import execution  # slow: Dask

    with refusing_bad_input():
        folder = output or DEFAULT / f"paper-{name}"
        Results(folder)
        seeds = range(seed, seed + (runs or paper.runs))
        with (
            storing(folder, f"; {KEPT}"),
            reserved(folder, "paper"),
            _saying_what_is_kept(folder),
            execution.workers(workers, scheduler, insecure) as working,
        ):
            planned = plans(paper, seeds, folder)
            _announce(name, planned, folder, working.count)
            sections: list[page.Section] = []
            pictures: list[page.Drawn] = []
            swept: dict[str, list[Point]] = {sweep.name: [] for sweep, _ in planned.sweeps}
            with progress(name) as advance:
                for plan, measured in run_plans(planned.all, working, advance):
                    if plan in planned.experiments:
                        result = result_of(plan, measured)
                        sections.append(page.section(result, _timed(plan)))
                        pictures += page.draw(paper, result)
                        continue
                    sweep, value = planned.swept_by(plan)
                    swept[sweep.name] += points(sweep, value, measured)
            sections += [page.section_of_sweep(Swept(s, swept[s.name])) for s, _ in planned.sweeps]
            report = page.write(paper, sections, pictures, planned.left_out, seeds, folder)
    tables = [table for section in sections for table in section.tables]
    if as_json:
        print_json(
            {
                "paper": name,
                "runs": len(seeds),
                "seed": seed,
                "verdict": paper.verdict,
                "tables": [table.to_json() for table in tables],
                "left_out": planned.left_out,
                "pictures": [str(folder / drawn.file) for drawn in pictures],
                "report": str(report),
            }
        )
        return
    for table in tables:
        _print(table)
    print_pairs(
        {
            "Runs": f"{len(seeds)}, seeds {seeds[0]} to {seeds[-1]}",
            "Pictures": f"{len(pictures)}, in {folder}",
            "Report": str(report),
            "Tables": str(folder / page.TABLES),
        }
    )
    for sentence in (*planned.left_out, paper.verdict):
        console().print(sentence, highlight=False, markup=False)


@contextmanager
def _saying_what_is_kept(folder: Path) -> Iterator[None]:
    """Say how to go on after an interruption."""
    try:
        yield
    except KeyboardInterrupt:
        say(f"truenorth: stopped; in {folder} {KEPT}")
        raise


def _announce(name: str, planned: Plans, folder: Path, workers: int) -> None:
    """Say how much there is to do, and how long it will take."""
    wanted = sum(len(plan.seeds) for plan in planned.all)
    missing, cost = sum(plan.missing for plan in planned.all), sum(plan.cost for plan in planned.all)
    time = f", {_duration(cost / workers)} or so" if missing else ""
    say(f"{name}: {missing} of {wanted} runs to do{time}; they are kept in {folder}")


def _timed(plan: Plan) -> Timed | None:
    """How long the steps of an experiment's filters take, if the paper says something of it."""
    if not plan.experiment.time:
        return None
    from sim_scenarios.benchmark import filter_steps  # slow: readers of recordings
    from sim_scenarios.fmus import Fmus
    from sim_scenarios.papers.claims import Timed

    return Timed(plan.experiment, filter_steps(plan.scenario, Fmus()))


def _list(paper: Paper, as_json: bool) -> None:
    if as_json:
        keys = ("number", "in_the_paper", "here")
        rows = [dict(zip(keys, row, strict=True)) for row in paper.listing()[1:]]
        print_json({"paper": paper.name, "citation": paper.citation, "figures": rows})
        return
    console().print(paper.citation, highlight=False, markup=False)
    print_names(paper.listing())


def _duration(seconds: float) -> str:
    """A time that is not known to the second."""
    if seconds < 55:
        return f"{10 * max(1, math.ceil(seconds / 10))} s"
    return f"{math.ceil(seconds / 60)} min"


def _print(table: page.Tabled) -> None:
    console().print(table.title, style="bold", highlight=False, markup=False)
    print_table(table.cells())
    for difference in table.differences:
        console().print(f"- {difference}", style="italic", highlight=False, markup=False)
    console().print()
