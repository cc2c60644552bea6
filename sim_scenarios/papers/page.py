"""The report of a reproduced paper: PNG pictures and one HTML page that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from sim_scenarios.folders import filled
from sim_scenarios.html import render
from sim_scenarios.papers import Paper
from sim_scenarios.papers.reproduction import Reproduced, Result
from sim_scenarios.plots.ensemble import over_time
from sim_scenarios.plots.style import png


@dataclass(frozen=True)
class Section:
    """An experiment on the page."""

    scenario: str
    description: str
    notes: str
    tables: Sequence[Reproduced]
    picture: bytes


def section(result: Result) -> Section:
    """What the page shows of an experiment."""
    experiment, runs = result.experiment, result.ensemble
    windows = [table.window or runs.window for table in experiment.table]
    title = f"{experiment.scenario}: root mean square over {runs.count} runs"
    picture = png(over_time(runs, experiment.picture, windows, title))
    attributes = runs.attributes
    return Section(
        experiment.scenario, attributes["description"], attributes["notes"], result.tables, picture
    )


def write(paper: Paper, sections: Sequence[Section], runs: int, seed: int, folder: Path) -> Path:
    """Write the page and its pictures; the path of the page."""
    page = render("paper.html", paper=paper, sections=sections, runs=runs, seed=seed)
    with filled(folder) as draft:
        for section in sections:
            (draft / f"{section.scenario}.png").write_bytes(section.picture)
        (draft / "report.html").write_text(page, encoding="utf-8")
    return folder / "report.html"
