"""The papers that the filters come from: what each prints, and where its conditions are found here.

A paper is a TOML file. Its figures say what is drawn for each figure and table that the paper numbers, or why
nothing is; its experiments name a scenario, and tables of what the paper prints for some of the filters that
the scenario compares ::

    citation = "..."
    verdict = "What of the paper holds, in a sentence"
    runs = 50

    [[experiment]]
    name = "printed"                     # by which figures refer to it
    scenario = "swaying_ship_printed"
    set = { "gnss.rate" = 10.0 }         # as --set of `truenorth run`; may be left out
    residuals = "parked.csv.gz"          # a recording (see `recordings`) whose residuals join the noise
    also = ["EKF"]                       # filters that run, of which the paper says nothing
    cost = 2.5                           # seconds of one core a run, as measured
    time = { "UKF / EKF" = "larger" }    # what the paper says of the time of a step

    [[experiment.expect]]                # see `expectations`
    title = "Fig. 3, 300 to 600 s"
    window = [300.0, 600.0]              # s; the scenario's own, if left out
    why = { heading = "Why what is measured differs, in a sentence" }

    [experiment.expect.figures]
    "UKF" = { heading = 16.9 }
    "robust UKF / UKF" = { heading = 0.25, settling = "sooner" }

    [[figure]]
    number = "Fig. 3"
    shows = "What the paper's figure shows"
    here = "What is drawn instead, or why nothing is"

    [[figure.picture]]                   # any number of them
    experiment = "printed"
    kind = "run"                         # of `papers.pictures`
    panels = ["heading"]                 # of `papers.pictures.PANELS`
    filters = ["UKF"]                    # all, if left out
    window = [300.0, 600.0]              # s; the whole run, if left out

    [[sweep]]                            # how far a filter gets: the same with one thing changed
    name = "range"
    title = "..."
    scenario = "static_large_misalignment"
    entry = "initial_error.misalignment"
    values = [10.0, 20.0]                # of what stands in braces below
    value = ["10 deg", "20 deg", "{} deg"]
    axis = "heading error at the start [deg]"
    filters = ["EKF", "UKF"]
    runs = 10
    cost = 0.3

A paper that says no number is quoted in a word. A figure without a number is ours: the paper has none such.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, StringConstraints, ValidationError, model_validator

from sim_scenarios import toml
from sim_scenarios.catalogue import PAPERS, files
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.papers.pictures import PANELS
from sim_scenarios.scenario.tables import Table
from sim_scenarios.studies.expectations import Expectations, known_name
from sim_scenarios.timeline import Window

Cost = Annotated[float, Field(gt=0)]
"""Seconds of one core a run."""
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


PanelName = Annotated[str, AfterValidator(lambda name: known_name("panel", name, list(PANELS)))]


class Experiment(Table):
    """A scenario, and what the paper prints of it."""

    name: Text
    scenario: str
    set: dict[str, Any] = Field(default={})
    residuals: str | None = None
    also: tuple[str, ...] = ()
    cost: Cost
    expect: tuple[Expectations, ...] = ()
    time: dict[str, str] = Field(default={})

    def labels(self) -> list[str]:
        """Filters that run."""
        named = [name for expectations in self.expect for name in expectations.filters()]
        return list(dict.fromkeys([*named, *self.also]))


class Sweep(Table):
    """Filters of a scenario from start to start, to see from where they still converge."""

    name: Text
    title: Text
    scenario: str
    set: dict[str, Any] = Field(default={})
    entry: Text
    values: Annotated[tuple[float, ...], Field(min_length=2)]
    value: tuple[str, ...]
    axis: Text
    filters: Annotated[tuple[str, ...], Field(min_length=1)]
    runs: Annotated[int, Field(ge=1)]
    cost: Cost

    def experiments(self) -> list[Experiment]:
        """One for each value."""
        return [
            Experiment(
                name=f"{self.name} {value:g}",
                scenario=self.scenario,
                set={**self.set, self.entry: [part.format(f"{value:g}") for part in self.value]},
                also=self.filters,
                cost=self.cost,
            )
            for value in self.values
        ]


class Picture(Table):
    """Curves of an experiment."""

    experiment: Text
    kind: Literal["run", "rms", "value", "distribution"]
    panels: Annotated[tuple[PanelName, ...], Field(min_length=1)]
    filters: tuple[str, ...] = ()
    window: Window | None = None


class PaperFigure(Table):
    """A figure or table of a paper, and what stands here in its place; ours, if it has no number."""

    number: Text | None = None
    shows: Text
    here: Text
    picture: tuple[Picture, ...] = ()

    @property
    def title(self) -> str:
        """Its number, or that it is ours."""
        return self.number or "Ours"


class Paper(Table):
    """A paper."""

    name: str
    citation: Text
    verdict: Text
    runs: Annotated[int, Field(ge=1)]
    figure: tuple[PaperFigure, ...]
    experiment: tuple[Experiment, ...]
    sweep: tuple[Sweep, ...] = ()

    @model_validator(mode="after")
    def _pictures_are_of_experiments(self) -> Paper:
        labels = {experiment.name: experiment.labels() for experiment in self.experiment}
        if len(labels) < len(self.experiment):
            raise ValueError("two experiments have one name")
        for picture in self.pictures():
            if picture.experiment not in labels:
                raise ValueError(f"there is no experiment '{picture.experiment}'")
            for label in picture.filters:
                known_name("filter", label, labels[picture.experiment])
        return self

    def pictures(self) -> list[Picture]:
        """All of them."""
        return [picture for figure in self.figure for picture in figure.picture]

    def listing(self) -> list[list[str]]:
        """What the paper numbers and what stands here in its place, the heading first."""
        return [
            ["", "In the paper", "Here"],
            *([figure.title, figure.shows, figure.here] for figure in self.figure),
        ]


def load_paper(name: str) -> Paper:
    """Paper of a name."""
    papers = files(PAPERS)
    if name not in papers:
        hint = did_you_mean(name, list(papers)) or f"; there are {', '.join(papers)}"
        raise InputError(f"there is no paper '{name}'{hint}")
    content = toml.read(papers[name])
    try:
        return Paper.model_validate({"name": name, **content})
    except ValidationError as error:
        sentences = [f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors()]
        raise InputError(f"{papers[name]}: {'; '.join(sentences)}") from None
