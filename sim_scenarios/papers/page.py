"""The report of a reproduced paper: PNG pictures and one HTML page that needs nothing else."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sim_scenarios import markdown
from sim_scenarios.connection import parameter
from sim_scenarios.fmus import Fmus
from sim_scenarios.folders import filled
from sim_scenarios.html import render
from sim_scenarios.papers import Paper, Picture
from sim_scenarios.papers.claims import Swept, Timed
from sim_scenarios.papers.pictures import converged, drawn
from sim_scenarios.papers.reproduction import Result
from sim_scenarios.plots.style import png
from sim_scenarios.scenario import Scenario
from sim_scenarios.studies.ensemble import Ensemble

Array = NDArray[np.float64]

TABLES = "measured.md"
"""All tables of a report, for a page of the documentation."""
CAPTIONS = {
    "run": "Errors of the first run over time",
    "value": "The first run over time, and what is true",
    "rms": "Root mean square error over the runs",
    "distribution": "Share of the runs whose root mean square error is no larger",
}


@dataclass(frozen=True)
class Drawn:
    """A picture.

    Attributes
    ----------
    picture : Picture
    file : str
        Its name in the folder of the report.
    content : bytes
        PNG.
    caption : str
    """

    picture: Picture
    file: str
    content: bytes
    caption: str


class Tabled(Protocol):
    """What is a table on the page, on the terminal and for machines."""

    @property
    def title(self) -> str:
        """What it is of."""

    @property
    def differences(self) -> Sequence[str]:
        """Why what is measured differs from what is printed, in sentences."""

    def cells(self) -> list[list[str]]:
        """The table with its heading."""

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""


@dataclass(frozen=True)
class Section:
    """An experiment on the page; a sweep has its picture with it, and a name of its file."""

    title: str
    notes: str
    tables: Sequence[Tabled]
    picture: bytes | None = None
    file: str = ""


def section(result: Result, timed: Timed | None = None) -> Section:
    """What the page keeps of an experiment besides its pictures."""
    attributes = result.ensemble.attributes
    tables: list[Tabled] = [*result.tables, *([timed] if timed else [])]
    return Section(attributes["description"], attributes["notes"], tables)


def section_of_sweep(swept: Swept) -> Section:
    """A sweep on the page, with its picture."""
    picture = png(converged(swept.sweep.axis, swept.sweep.values, swept.shares()))
    return Section(swept.title, "", [swept], picture, f"{_slug(swept.sweep.name)}.png")


def draw(paper: Paper, result: Result) -> list[Drawn]:
    """The pictures of an experiment."""
    pictures = []
    for figure in paper.figure:
        for n, picture in enumerate(figure.picture):
            if picture.experiment != result.experiment.name:
                continue
            runs = result.ensemble
            labels = picture.filters or result.experiment.labels()
            image = png(
                drawn(
                    runs,
                    picture.kind,
                    picture.panels,
                    labels,
                    picture.window,
                    _told(runs, result.scenario),
                )
            )
            letter = chr(ord("a") + n) if len(figure.picture) > 1 else ""
            file = f"{_slug(figure.number or figure.shows)}{letter}.png"
            caption = f"{CAPTIONS[picture.kind]}; scenario {result.experiment.scenario}."
            pictures.append(Drawn(picture, file, image, caption))
    return pictures


def write(
    paper: Paper,
    sections: Sequence[Section],
    pictures: Sequence[Drawn],
    left_out: Sequence[str],
    seeds: Sequence[int],
    folder: Path,
) -> Path:
    """Write the page, its pictures, and its tables as Markdown (`TABLES`); the path of the page."""
    page = render(
        "paper.html",
        paper=paper,
        sections=sections,
        figures=[(figure, [d for d in pictures if d.picture in figure.picture]) for figure in paper.figure],
        left_out=left_out,
        seeds=seeds,
    )
    with filled(folder, anew=True) as draft:
        for one in pictures:
            (draft / one.file).write_bytes(one.content)
        for section in sections:
            if section.picture:
                (draft / section.file).write_bytes(section.picture)
        (draft / TABLES).write_text(_tables(paper, sections, left_out, seeds), encoding="utf-8")
        (draft / "report.html").write_text(page, encoding="utf-8")
    return folder / "report.html"


def _tables(paper: Paper, sections: Sequence[Section], left_out: Sequence[str], seeds: Sequence[int]) -> str:
    """All tables as Markdown, for a page of the documentation."""
    command = f"truenorth paper {paper.name} -n {len(seeds)} --seed {seeds[0]}"
    lines = [
        f"**Measured** {datetime.now(timezone.utc):%Y-%m-%d} with `{command}`. Intervals are of 95 %.",
        *left_out,
    ]
    for table in (table for section in sections for table in section.tables):
        lines += ["", table.title, "", markdown.table(table.cells()).rstrip("\n")]
    return "\n".join(lines) + "\n"


def _slug(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")[:60]


def _told(runs: Ensemble, scenario: Scenario) -> Callable[[str], Array | None]:
    """What is true of a panel: the velocity, or the sigma of the fixes over time."""
    time = runs.first["time"].values
    axes: Mapping[str, int] = {"east": 1, "north": 2, "height": 3}

    def told(panel: str) -> Array | None:
        kind, _, what = panel.partition("_")
        if kind == "value":
            return runs.first["truth.velocity"].values[:, axes[what.removeprefix("velocity_")] - 1]
        if kind != "sigma":
            return None
        quantity, _, axis = what.rpartition("_")
        name = f"gnss.{quantity or 'position'}_sigma[{axes[axis]}]"
        plant = Fmus().plant
        return float(parameter(scenario, plant, name)) * noise_scale(
            time, lambda entry: float(parameter(scenario, plant, f"gnss.noise_scale.{entry}"))
        )

    return told


def noise_scale(time: Array, entry: Callable[[str], float]) -> Array:
    """Factor on the noise of the fixes: a step and a sine, each in its window (Jing 2023, eq. 21)."""

    def within(window: str) -> NDArray[np.bool_]:
        return (time >= entry(f"{window}.begin")) & (time < entry(f"{window}.end"))

    step = np.where(within("step"), entry("step.factor"), 1.0)
    phase = 2 * np.pi * (time - entry("sine.begin")) / entry("sine.period")
    return np.asarray(step * np.where(within("sine"), 1 + entry("sine.amplitude") * np.sin(phase), 1.0))
