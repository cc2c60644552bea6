"""`truenorth paper`."""

from __future__ import annotations

from typing import Annotated

import typer

from sim_scenarios.cli.options import AsJson, Output
from sim_scenarios.cli.results import Results, storing
from sim_scenarios.cli.terminal import (
    console,
    print_json,
    print_pairs,
    print_table,
    progress,
    refusing_bad_input,
)
from sim_scenarios.papers import load_paper, page, shipped
from sim_scenarios.papers.reproduction import Reproduced, reproduce
from sim_scenarios.processes import processes

Name = Annotated[
    str, typer.Argument(metavar="NAME", help=f"One of {', '.join(shipped())}.", show_default=False)
]
Runs = Annotated[
    int | None,
    typer.Option("--runs", "-n", min=1, help="Runs of every scenario.", show_default="of the paper"),
]
FirstSeed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the first run; the others count up.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Processes.", show_default="one for each core")]


def reproduce_paper(
    name: Name,
    runs: Runs = None,
    seed: FirstSeed = 1,
    output: Output = None,
    workers: Workers = None,
    as_json: AsJson = False,
) -> None:
    """Reproduce what a paper prints: its figures beside those measured here, and why they differ.

    For example:

        truenorth paper zhou
        truenorth paper zhao -n 20 --output results

    Exit code 0 when all runs are done, whatever they say.
    """
    with refusing_bad_input():
        paper = load_paper(name)
        folder = Results(output).folder(f"paper-{name}")
        count = runs or paper.runs
        with processes(workers) as pool, progress(name) as advance:
            results = reproduce(paper, pool, count, seed, advance)
            sections = [page.section(result) for result in results]
        with storing(folder):
            report = page.write(paper, sections, count, seed, folder)
    tables = [table for section in sections for table in section.tables]
    if as_json:
        print_json(
            {
                "paper": name,
                "runs": count,
                "seed": seed,
                "verdict": paper.verdict,
                "tables": [table.to_json() for table in tables],
                "report": str(report),
            }
        )
        return
    for table in tables:
        _print(table)
    print_pairs({"Runs": f"{count}, seeds {seed} to {seed + count - 1}", "Report": str(report)})
    console().print(paper.verdict, highlight=False, markup=False)


def _print(table: Reproduced) -> None:
    console().print(table.title, style="bold", highlight=False, markup=False)
    print_table(table.cells())
    for difference in table.differences:
        console().print(f"- {difference}", style="italic", highlight=False, markup=False)
    console().print()
