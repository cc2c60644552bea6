"""A case of a campaign: a scenario with settings, and what is drawn for each of its runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sim_scenarios.fmus import Number
from sim_scenarios.scenario import Scenario
from sim_scenarios.scenario.tables import FILTER
from sim_scenarios.studies.draws import Draw


@dataclass(frozen=True)
class Case:
    """A scenario with a named case and one combination of the grid, checked against the FMUs.

    Attributes
    ----------
    label : str
        Unique in its campaign: the scenario, the name of the case, and what the grid sets.
    source : str
        Name or path of the scenario.
    settings : dict of str to object
        Values by name that differ from the scenario file, as for `sim_scenarios.run`.
    scenario : Scenario
        With the filters of the campaign as those that it compares.
    draws : tuple of Draw
        What differs from run to run.
    unfaulted : str or None
        Label of the same case without the faults of its plant; None of a case that has none.
    """

    label: str
    source: str
    settings: dict[str, Any]
    scenario: Scenario
    draws: tuple[Draw, ...] = ()
    unfaulted: str | None = None

    def filters(self) -> dict[str, dict[str, Number]]:
        """Parameters of each filter, by label."""
        return filters_of(self.scenario)

    def with_seed(self, seed: int) -> Scenario:
        """The scenario of one run: its seed, and what is drawn for it."""
        drawn: dict[str, dict[str, Number]] = {"plant": {"seed": seed}, "filter": {}, "alignment": {}}
        for one in self.draws:
            drawn[one.part] |= one.drawn(seed)
        of_filter = drawn["filter"]
        update: dict[str, Any] = {"plant": {**self.scenario.plant, **drawn["plant"]}}
        if of_filter:
            compare = {label: {**values, **of_filter} for label, values in self.scenario.compare.items()}
            update |= {"filter": {**self.scenario.filter, **of_filter}, "compare": compare}
        if self.scenario.alignment is not None:
            update["alignment"] = {**self.scenario.alignment, **drawn["alignment"]}
        return self.scenario.model_copy(update=update)

    def drawn(self, seed: int) -> dict[str, Number]:
        """What is drawn for one run, in SI units under the names that `--set` takes."""
        return {one.label(scalar): value for one in self.draws for scalar, value in one.drawn(seed).items()}


def filters_of(scenario: Scenario) -> dict[str, dict[str, Number]]:
    """Parameters of each filter of a scenario, by label."""
    return scenario.filters() or {FILTER: dict(scenario.filter)}


def filter_labels(made: Sequence[Case]) -> list[str]:
    """Labels of all filters, in the order in which the cases name them."""
    return list(dict.fromkeys(label for case in made for label in case.filters()))
