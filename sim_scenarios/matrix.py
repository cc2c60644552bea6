"""Filters x models x disturbances: filters in several scenarios, each beside the nominal EKF.

The nominal EKF of a scenario is its filter with the linearised predictor and the standard corrector, as the
scenario has everything else. It runs on the same signals; the ratio of two filters scatters less than their
errors do.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, Final

import xarray as xr

from sim_scenarios import recording
from sim_scenarios.cosimulation import Progress, part_of
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import Verdict, judge
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.simulation import run_filters

NOMINAL: Final = "nominal EKF"
_NOMINAL_SETTINGS: Final[Mapping[str, object]] = {"predictor": "linearised", "corrector": "standard"}


def combinations(axes: Mapping[str, Sequence[object]]) -> dict[str, dict[str, object]]:
    """Filters with every combination of values: parameters by label."""
    return {
        ", ".join(map(str, values)): dict(zip(axes, values, strict=True))
        for values in product(*axes.values())
    }


@dataclass(frozen=True)
class Matrix:
    """Filters in scenarios.

    Attributes
    ----------
    verdicts : dict
        By scenario and label; each scenario has `NOMINAL`.
    """

    verdicts: dict[str, dict[str, Verdict]]

    def labels(self) -> list[str]:
        """Every filter, in the order in which the scenarios bring them."""
        return list(dict.fromkeys(label for row in self.verdicts.values() for label in row))

    def ratio(self, scenario: str, label: str) -> float:
        """RMSE over that of the nominal EKF."""
        verdicts = self.verdicts[scenario]
        return verdicts[label].rmse.value / verdicts[NOMINAL].rmse.value

    def table(self) -> list[list[str]]:
        """Rows, the heading first: RMSE and ratio of each filter in each scenario."""
        headings = [
            (f"{scenario}\n{verdicts[NOMINAL].rmse.title}", "/ EKF")
            for scenario, verdicts in self.verdicts.items()
        ]
        rows = [[label, *self._cells(label)] for label in self.labels()]
        return [["Filter", *(cell for pair in headings for cell in pair)], *rows]

    def _cells(self, label: str) -> Iterator[str]:
        for scenario, verdicts in self.verdicts.items():
            if label in verdicts:
                yield f"{verdicts[label].rmse.value:.3g}{'' if verdicts[label].ok else ' !'}"
                yield f"{self.ratio(scenario, label):.2f}"
            else:
                yield from ("", "")


def matrix(
    scenarios: Sequence[str | Path],
    axes: Mapping[str, Sequence[object]],
    *,
    seed: int | None = None,
    settings: Mapping[str, object] | None = None,
    progress: Progress = lambda _: None,
) -> Iterator[xr.Dataset]:
    """Run filters in scenarios, with the nominal EKF first in each.

    Parameters
    ----------
    scenarios : sequence of str or Path
        As for `sim_scenarios.run`.
    axes : mapping
        Values of filter parameters, every combination of which is a filter; without any, the filters are
        those that each scenario compares.
    seed, settings, progress
        As for `sim_scenarios.compare`.

    Yields
    ------
    xarray.Dataset
        Of each scenario, as of `sim_scenarios.compare`.

    Raises
    ------
    InputError
        A scenario cannot be run, or two have the same name; nothing has been run then.
    """
    fmus = Fmus()
    chosen = {NOMINAL: _NOMINAL_SETTINGS}
    if axes:
        chosen |= combinations(axes)

    def loaded(scenario: str | Path) -> Scenario:
        how: dict[str, Any] = {"seed": seed, "settings": settings, "running": None}
        with_nominal = load_scenario(scenario, fmus, compare=chosen, **how)
        if axes:
            return with_nominal
        own = load_scenario(scenario, fmus, **how)
        filters = {"compare": {**with_nominal.compare, **own.compare}, "rivals": own.rivals}
        return with_nominal.model_copy(update=filters)

    all_of_them = [loaded(scenario) for scenario in scenarios]  # what is refused is so before the first run
    names = [one.name for one in all_of_them]
    if twice := [str(given) for given, name in zip(scenarios, names, strict=True) if names.count(name) > 1]:
        raise InputError(f"{', '.join(twice)}: each scenario must have a name of its own")
    for done, one in enumerate(all_of_them):
        yield run_filters(one, fmus, one.filters(), progress=part_of(progress, done, len(scenarios)))


def judged(runs: xr.Dataset) -> dict[str, Verdict]:
    """Verdict on each filter of a scenario."""
    return {str(label): judge(recording.of_filter(runs, str(label))) for label in runs["filter"].values}
