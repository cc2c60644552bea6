"""Runs of scenarios, by the container where it can do them and by the Python master where not.

What both record is the same to the last bit; the container takes a third of the time and records a choice of
outputs only, since it carries each of them in every step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack

import xarray as xr

from sim_scenarios import connection, ports, simulation
from sim_scenarios.container import Container, obstacle
from sim_scenarios.cosimulation import Recorded
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu, Fmus, Number
from sim_scenarios.recording import FIX_OUTPUTS
from sim_scenarios.scenario import Scenario
from sim_scenarios.stepping import Master
from sim_scenarios.timeline import instants

Filters = Mapping[str, Mapping[str, Number]]


class Runner:
    """Runs scenarios with FMUs and containers that are made once.

    Parameters
    ----------
    outputs : sequence of str
        Outputs of a filter, arrays by their base name, that a container records, at every recorded instant or
        at fixes (`recording.FIX_OUTPUTS`), where the filter has them. The Python master records all.
    master : Master
    fmus : Fmus, optional
        Those that are loaded already.
    """

    def __init__(
        self,
        outputs: Sequence[str],
        master: Master = Master.auto,
        fmus: Fmus | None = None,
    ) -> None:
        self.fmus = fmus or Fmus()
        self._recorded = tuple(
            [name for name in outputs if (name in FIX_OUTPUTS) is at_fixes] for at_fixes in (False, True)
        )
        self._master = master
        self._containers: dict[tuple[tuple[str, ...], float], Container] = {}

    def uses_container(self, scenario: Scenario) -> bool:
        """Whether the container does a scenario; refuses what was asked for and cannot be."""
        if self._master is Master.python:
            return False
        reason = why_no_container(scenario, self.fmus)
        if reason is not None and self._master is Master.container:
            raise InputError(f"{scenario.name} cannot run in a container: {reason}")
        return reason is None

    def simulated(self, scenario: Scenario, filters: Filters, container: bool) -> xr.Dataset:
        """Data set of one run of a scenario, by the container or by the Python master, without attributes."""
        if container:
            recorded = self._record(scenario, filters)
        else:
            recorded, _ = simulation.simulated(scenario, self.fmus, filters)
        return simulation.dataset(recorded, scenario, self.fmus, list(filters))

    def _record(self, scenario: Scenario, filters: Filters) -> Recorded:
        with ExitStack() as stack:
            plant = connection.start_plant(scenario, self.fmus, stack)
            truth = dict(zip(connection.TRUTH, plant.read(connection.TRUTH), strict=True))
        start = connection.initial_values(scenario, self.fmus.plant, truth)
        names = tuple(map(scenario.fmu_of, filters))
        return self._container(scenario, names).record(
            scenario.plant,
            [
                connection.filter_values(self.fmus[name], start, values)
                for name, values in zip(names, filters.values(), strict=True)
            ],
            instants(scenario.duration, scenario.communication_step, connection.stride(scenario)),
        )

    def _container(self, scenario: Scenario, names: tuple[str, ...]) -> Container:
        key = names, scenario.communication_step
        if key not in self._containers:
            standard, filters = self.fmus[scenario.standard], [self.fmus[name] for name in names]
            self._containers[key] = Container(
                self.fmus.plant,
                filters,
                scenario.communication_step,
                *(
                    [_scalars(fmu, outputs, set(ports.recorded(fmu, standard))) for fmu in filters]
                    for outputs in self._recorded
                ),
            )
        return self._containers[key]


def why_no_container(scenario: Scenario, fmus: Fmus) -> str | None:
    """Why a container cannot do a scenario; None if it can."""
    if scenario.vehicle() is not None:
        return "the container does not tell the plant how a vehicle moves (trajectory, waypoints)"
    if scenario.alignment is not None:
        return "the container does not pass an alignment on to navigation"
    rate = float(connection.parameter(scenario, fmus.plant, "gnss.rate"))
    return obstacle(scenario.recording_period, rate)


def _scalars(fmu: Fmu, names: Sequence[str], recorded: set[str]) -> list[str]:
    return [scalar for name in names for scalar in fmu.arrays.get(name, []) if scalar in recorded]
