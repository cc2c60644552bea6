"""From a scenario to a data set: its filters run on the same signals, with the bound."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording
from sim_scenarios.connection import connect, record
from sim_scenarios.cosimulation import DisturbedSource, FmuSource, Progress, Recorded, Sink, Source
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmus, Number
from sim_scenarios.instance import Message
from sim_scenarios.provenance import attributes
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.scenario.tables import FILTER
from sim_scenarios.scenario_bound import trajectory, with_bound
from sim_scenarios.stepping import Master, Order

Array = NDArray[np.float64]
Watch = Callable[[Scenario, Source, Sequence[Sink]], Progress]
"""Progress that is given what has been connected before the first step, so that it can look at it."""


def run(
    scenario: str | Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    order: Order | str = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    watch: Watch | None = None,
    fmus: Fmus | None = None,
) -> xr.Dataset:
    """Run a scenario with its filter.

    Parameters
    ----------
    scenario : str or Path
        Name of a shipped scenario, or path of a TOML file, whose `.toml` may be left out.
    seed : int, optional
        Seed of every random stream of the plant.
    set : mapping, optional
        Values by name, in SI units or with a unit: any FMU parameter (`{"imu.gyro.bias": "0.05 deg/h"}`) or
        entry of the scenario (`{"duration": 900}`).
    order : Order or str
        Who steps first, as enumeration or its value: "gauss-seidel", "jacobi".
    progress : callable
        Called with the completed share.
    watch : callable, optional
        Makes the progress in its place, and may look at the filter: `live.looks.watch`.
    fmus : Fmus, optional
        Those that are loaded already, to load them once for many runs.

    Returns
    -------
    xarray.Dataset
        See `recording`; `metrics.judge` gives the verdict on it.
    """
    order = Order(order)
    fmus = fmus or Fmus()
    loaded = load_scenario(scenario, fmus, seed=seed, settings=set)
    runs = run_filters(loaded, fmus, {FILTER: loaded.filter}, order, progress, watch)
    return recording.of_filter(runs, FILTER)


def compare(
    scenario: str | Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002
    progress: Progress = lambda _: None,
    fmus: Fmus | None = None,
) -> xr.Dataset:
    """Run the filters that a scenario compares on the same signals.

    Parameters as for `run`. Select one filter of the result with `.sel(filter="UKF")`.
    """
    fmus = fmus or Fmus()
    loaded = load_scenario(scenario, fmus, seed=seed, settings=set, running=None)
    if not loaded.filters():
        raise InputError(f"{scenario}: compare: names no filter")
    return run_filters(loaded, fmus, loaded.filters(), Order.gauss_seidel, progress)


def run_filters(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    watch: Watch | None = None,
) -> xr.Dataset:
    """Run filters, given by label and parameters, on the signals of a scenario."""
    recorded, messages = simulated(scenario, fmus, filters, order, progress, watch=watch)
    data = dataset(recorded, scenario, fmus, list(filters))
    data.attrs = attributes(scenario, fmus, messages)
    assert recorded.truth is not None
    try:
        return with_bound(data, trajectory(recorded.time, recorded.truth), scenario, fmus)
    except InputError as error:  # a run is worth having without a bound
        data.attrs["bound.leaves_out"] = f"there is none: {error}"
        return data


def dataset(recorded: Recorded, scenario: Scenario, fmus: Fmus, labels: list[str]) -> xr.Dataset:
    """Data set of what a scenario recorded, without the bound; a label for each filter."""
    alignment = None if scenario.alignment is None else fmus[ALIGNMENT_FILTER]
    filters = {label: fmus[scenario.fmu_of(label)] for label in labels}
    return recording.dataset(recorded, filters, fmus.plant, alignment)


def thin(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    only: Sequence[str],
    added: Mapping[str, Array] | None = None,
    master: Master = Master.auto,
) -> xr.Dataset:
    """Data set of a run with some outputs, without bound and attributes; arguments as of `simulated`."""
    recorded, _ = simulated(scenario, fmus, filters, added=added, only=only, master=master)
    return dataset(recorded, scenario, fmus, list(filters))


def simulated(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    added: Mapping[str, Array] | None = None,
    watch: Watch | None = None,
    only: Sequence[str] | None = None,
    master: Master = Master.auto,
) -> tuple[Recorded, list[Message]]:
    """What plant and filters recorded and said in a scenario.

    `added` as of `DisturbedSource`, `only` as of `connect`. What looks at every row has the Python master.
    """
    with ExitStack() as stack:
        source, sinks = connect(scenario, fmus, filters, stack, order, only)
        signals: Source = source
        if added is not None:
            if not isinstance(source, FmuSource):
                raise InputError(f"{scenario.name}: nothing is added to the signals of an alignment")
            signals = DisturbedSource(source, added)
        if watch is not None:
            progress, master = watch(scenario, source, sinks), Master.python
        recorded = record(scenario, fmus, signals, sinks, order, progress, master)
        instances = (source.instance, source.alignment, *(sink.instance for sink in sinks))
        return recorded, [message for instance in instances if instance for message in instance.messages]
