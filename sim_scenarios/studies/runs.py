"""The runs of a campaign, on a worker: FMUs are unpacked once, and every run depends on its seed alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import faults, provenance, recording, scenario_bound, simulation
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmus, Number
from sim_scenarios.metrics import hand_over
from sim_scenarios.scenario import Scenario
from sim_scenarios.stepping import Master
from sim_scenarios.studies.case import Case, filters_of
from sim_scenarios.studies.quantities import NOTHING, Asked, kept, outputs
from sim_scenarios.studies.store import State

Array = NDArray[np.float64]
Filters = Mapping[str, Mapping[str, Number]]


@dataclass(frozen=True)
class Outcome:
    """What became of one run: state and kept values of each filter by label, and why one failed."""

    state: dict[str, State]
    kept: dict[str, dict[str, Array]]
    failure: str = ""


class Bench:
    """All that runs share.

    Parameters
    ----------
    period : float
        Between the times of the kept series [s].
    master : Master
    fmus : Fmus, optional
        Those that are loaded already.
    asked : Asked
        What is kept of a run besides.
    """

    def __init__(
        self,
        period: float,
        master: Master = Master.auto,
        fmus: Fmus | None = None,
        asked: Asked = NOTHING,
    ) -> None:
        self.fmus = fmus or Fmus()
        self._period, self._asked, self._master = period, asked, master
        self._outputs = outputs(asked)

    def run(self, case: Case, seed: int, attributes: Mapping[str, Any]) -> Outcome:
        """One run of a case with all its filters; a filter that fails does not touch the others."""
        scenario = case.with_seed(seed)
        filters = filters_of(scenario)
        try:
            data = self._simulated(scenario, filters)
        except SimulationError:
            return self._one_by_one(scenario, filters, attributes)
        return self._outcome(data, attributes)

    def _simulated(self, scenario: Scenario, filters: Filters) -> xr.Dataset:
        """Data set with what is kept of a run, without attributes."""
        return simulation.thin(scenario, self.fmus, filters, self._outputs, master=self._master)

    def _outcome(self, data: xr.Dataset, attributes: Mapping[str, Any]) -> Outcome:
        """What became of each filter; one that has no start by the evaluation has failed, without figures."""
        data.attrs.update(attributes)
        state, values, failures = {}, {}, []
        for label in map(str, data["filter"].values):
            one = recording.of_filter(data, label)
            handed = hand_over.of_run(one)
            if handed is None or handed.in_time:
                state[label], values[label] = State.finished, kept(one, self._period, self._asked)
            else:
                state[label] = State.failed
                failures.append(f"{label}: {handed.failure()}")
        return Outcome(state, values, "; ".join(failures))

    def _one_by_one(self, scenario: Scenario, filters: Filters, attributes: Mapping[str, Any]) -> Outcome:
        state: dict[str, State] = {}
        values_kept: dict[str, dict[str, Array]] = {}
        failures: list[str] = []
        for label, values in filters.items():
            try:
                data = self._simulated(scenario, {label: values})
            except SimulationError as error:  # noqa: PERF203
                state[label] = State.failed
                failures.append(str(error))
            else:
                one = self._outcome(data, attributes)
                state |= one.state
                values_kept |= one.kept
                failures += [one.failure] if one.failure else []
        return Outcome(state, values_kept, "; ".join(failures))


def arranged(
    outcomes: Sequence[Outcome], filters: Sequence[str], shapes: Mapping[str, tuple[int, ...]]
) -> tuple[dict[str, Array], NDArray[np.int8]]:
    """Values and states of runs as they are stored, with the shape (filters, runs, ...) of each variable."""
    shape = len(filters), len(outcomes)
    values = {name: np.full((*shape, *rest), np.nan) for name, rest in shapes.items()}
    state = np.full(shape, State.absent, dtype=np.int8)
    for r, outcome in enumerate(outcomes):
        for f, label in enumerate(filters):
            state[f, r] = outcome.state.get(label, State.absent)
            for name, value in outcome.kept.get(label, {}).items():
                at: tuple[int | slice, ...] = (f, r, *map(slice, value.shape))
                values[name][at] = value
    return values, state


def bound(case: Case, fmus: Fmus) -> xr.Dataset:
    """Cramer-Rao bound of a case with the attributes of its runs; without a bound where there is none.

    The true motion is the same for all seeds, and so is the bound, unless more of the plant than its faults
    is drawn.
    """
    unknown = xr.Dataset(attrs=provenance.attributes(case.scenario, fmus))
    if any(one.part == "plant" and not faults.concerns(one.name) for one in case.draws):
        return unknown
    try:
        return scenario_bound.bound_of(case.scenario, fmus)
    except InputError:
        return unknown
