"""The papers that the filters come from: what each prints, and where its conditions are found here.

A paper is a TOML file. Its experiments name a scenario, and tables of what the paper prints for some of the
filters that the scenario compares ::

    citation = "..."
    verdict = "What of the paper holds, in a sentence"
    runs = 50

    [[experiment]]
    scenario = "swaying_ship_printed"
    set = { "gnss.rate" = 10.0 }         # as --set of `truenorth run`; may be left out
    also = ["EKF"]                       # filters that are drawn, of which the paper says nothing
    picture = "heading"                  # the figure whose root mean square over runs is drawn over time

    [[experiment.table]]
    title = "Fig. 3, 300 to 600 s"
    window = [300.0, 600.0]              # s; the scenario's own, if left out
    differences = { heading = "Why what is measured differs, in a sentence" }

    [experiment.table.printed]           # filter, or ratio of two: figures of `ensemble.FIGURES`
    "UKF" = { heading = 16.9 }
    "robust UKF / UKF" = { heading = 0.25, settling = "sooner" }

A paper that says no number is quoted in a word.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import AfterValidator, Field, ValidationError

from sim_scenarios import toml
from sim_scenarios.ensemble import FIGURES
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.scenario import Table

SHIPPED: Final = Path(__file__).parent

OVER: Final = " / "
"""Between the two filters of a ratio."""


def _figure(name: str) -> str:
    if name in FIGURES:
        return name
    hint = did_you_mean(name, list(FIGURES)) or f"; there are {', '.join(FIGURES)}"
    raise ValueError(f"there is no figure '{name}'{hint}")


FigureName = Annotated[str, AfterValidator(_figure)]


class Printed(Table):
    """A table or a picture of a paper."""

    title: str
    window: tuple[float, float] | None = None
    printed: dict[str, dict[FigureName, float | str]]
    differences: dict[FigureName, str] = Field(default={})


class Experiment(Table):
    """A scenario, and what the paper prints of it."""

    scenario: str
    set: dict[str, Any] = Field(default={})
    also: tuple[str, ...] = ()
    picture: FigureName
    table: tuple[Printed, ...]

    def labels(self) -> list[str]:
        """Filters that run."""
        named = [name for table in self.table for what in table.printed for name in what.split(OVER)]
        return list(dict.fromkeys([*named, *self.also]))


class Paper(Table):
    """A paper."""

    name: str
    citation: str
    verdict: str
    runs: Annotated[int, Field(ge=1)]
    experiment: tuple[Experiment, ...]


def shipped() -> dict[str, Path]:
    """Papers that come with the package, by name."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def load_paper(name: str) -> Paper:
    """Paper of a name."""
    papers = shipped()
    if name not in papers:
        hint = did_you_mean(name, list(papers)) or f"; there are {', '.join(papers)}"
        raise InputError(f"there is no paper '{name}'{hint}")
    content = toml.read(papers[name])
    try:
        return Paper.model_validate({"name": name, **content})
    except ValidationError as error:
        sentences = [f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors()]
        raise InputError(f"{papers[name]}: {'; '.join(sentences)}") from None
