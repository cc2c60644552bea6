"""Where the time of a run goes: python -m sim_scenarios.benchmark.

The wall time of a run of `swaying_ship` (600 s at 100 Hz, two FMUs) is measured undisturbed; the shares come
from runs in which every step, every get and every set is timed as well. Then how much faster than time itself
a recording is replayed: an hour at 200 Hz with a fix a second.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from sim_scenarios import connection, simulation
from sim_scenarios.cosimulation import FmuSource
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.tables import ImuTable, Recording
from sim_scenarios.recordings.zero_velocity import ZeroVelocity
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.stepping import Master

Call = Callable[..., Any]


class Clock:
    """Time spent in parts of a run [s].

    Parameters
    ----------
    now : callable
        The clock that is read.
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self.spent: defaultdict[str, float] = defaultdict(float)
        self._now = now

    def timed(self, part: str, function: Call) -> Call:
        """The function, with its time added to a part."""
        spent, now = self.spent, self._now

        def call(*arguments: Any) -> Any:
            start = now()
            result = function(*arguments)
            spent[part] += now() - start
            return result

        return call


def wall_time(scenario: str, fmus: Fmus, repetitions: int) -> float:
    """Median wall time of a whole run [s]."""

    def once() -> float:
        start = time.perf_counter()
        simulation.run(scenario, fmus=fmus)
        return time.perf_counter() - start

    return median(once() for _ in range(repetitions))


def shares(name: str, fmus: Fmus) -> dict[str, float]:
    """Seconds that each part of a run takes while all are timed."""
    clock = Clock()
    scenario = load_scenario(name, fmus)
    with ExitStack() as stack:
        source, (sink,) = connection.connect(scenario, fmus, {"filter": scenario.filter}, stack)
        if not isinstance(source, FmuSource):
            raise InputError(f"{name}: only a scenario of two FMUs is timed")
        source.instance.step = clock.timed("plant step", source.instance.step)  # type: ignore[method-assign]
        sink.instance.step = clock.timed("filter step", sink.instance.step)  # type: ignore[method-assign]
        source.port.read = clock.timed("get and set", source.port.read)  # type: ignore[method-assign]
        sink.port.write = clock.timed("get and set", sink.port.write)  # type: ignore[method-assign]
        record = partial(connection.record, master=Master.python)
        clock.timed("all", record)(scenario, fmus, source, [sink])
    parts = dict(clock.spent)
    parts["loop and recording"] = 2 * parts.pop("all") - sum(clock.spent.values())
    return parts


def filter_steps(scenario: Scenario, fmus: Fmus, repetitions: int = 3) -> dict[str, float]:
    """Seconds of a core that a step of each filter of a comparison takes, the median of some runs.

    Fixes are in it as often as they come. What else the machine does meanwhile is not.
    """
    steps = round(scenario.duration / scenario.communication_step)
    found = defaultdict(list)
    for _ in range(repetitions):
        clock = Clock(time.thread_time)
        filters = scenario.filters()
        with ExitStack() as stack:
            source, sinks = connection.connect(scenario, fmus, filters, stack)
            for label, sink in zip(filters, sinks, strict=True):
                sink.instance.step = clock.timed(label, sink.instance.step)  # type: ignore[method-assign]
            connection.record(scenario, fmus, source, sinks, master=Master.python)
        for label, seconds in clock.spent.items():
            found[label].append(seconds / steps)
    return {label: median(times) for label, times in found.items()}


def replay_speed(fmus: Fmus, seconds: float = 3600.0, rate: float = 200.0) -> dict[str, float]:
    """How many times faster than it was recorded each filter replays a vehicle that stands, by filter."""
    count = round(seconds * rate)
    noise = np.random.default_rng(1).standard_normal((2, count, 3))
    time_of_sample = np.arange(1, count + 1) / rate
    level = ImuTable(time_of_sample, 1e-6 * noise[0], np.array([0.0, 0.0, 9.8]) / rate + 1e-4 * noise[1])
    aiding = ZeroVelocity((45.0, 10.0, 0.0))
    speeds = {}
    for task in (Filter.alignment, Filter.navigation):
        start = time.perf_counter()
        replay(Recording("at rest", level), Start(0.0), filter=task, zero_velocity=aiding, fmus=fmus)
        speeds[task.value] = seconds / (time.perf_counter() - start)
    return speeds


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m sim_scenarios.benchmark", description=__doc__)
    parser.add_argument("--scenario", default="swaying_ship", help="what to run (default swaying_ship)")
    parser.add_argument(
        "--repetitions", type=int, default=5, help="runs, of which the median counts (default 5)"
    )
    arguments = parser.parse_args()
    fmus = Fmus()
    scenario = load_scenario(arguments.scenario, fmus)
    steps = round(scenario.duration / scenario.communication_step)
    wall = wall_time(arguments.scenario, fmus, arguments.repetitions)
    print(
        f"{arguments.scenario}: {scenario.duration:g} s in {steps} steps of 2 FMUs: {wall:.2f} s, "
        f"{1e6 * wall / steps:.1f} us a step"
    )
    parts = shares(arguments.scenario, fmus)
    for part, spent in parts.items():
        print(
            f"  {part:<20} {100 * spent / sum(parts.values()):5.1f} %   {1e6 * spent / steps:5.2f} us a step"
        )
    for task, speed in replay_speed(fmus).items():
        print(f"replay of an hour at 200 Hz, {task}: {speed:.0f} times as fast as real time")


if __name__ == "__main__":
    main()
