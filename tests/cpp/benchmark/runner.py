"""The compiled loop beside one that is written by hand: CPU seconds of a minute of `swaying_ship`.

    python tests/cpp/benchmark/runner.py build/native/tests/cpp/fmi/libplain_loop.so

Both step the same FMUs, made and initialised alike (60 s at 100 Hz; the plant, and one filter or all six that
the scenario compares), in turns that are short, so that what else the machine does meets them alike. The loop
by hand (plain_loop.cpp) does nothing else; the other records what a run (all outputs ten times a second, and
those of fixes) or a campaign does, and makes arrays of it.
"""

from __future__ import annotations

import argparse
import ctypes
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from statistics import median

from sim_scenarios import connection
from sim_scenarios.benchmark import Clock
from sim_scenarios.compiled import Loop
from sim_scenarios.cosimulation import FmuSource, Sink
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Instance, Port
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.stepping import Master
from sim_scenarios.studies.quantities import outputs

TURNS = 31
SHORT = {"duration": 60.0, "evaluation.start": 30.0, "evaluation.stop": 60.0}
BY_HAND = "by hand"
ADDRESSES = ctypes.c_void_p * 6
Stepping = Callable[[FmuSource, list[Sink]], None]


def part(instance: Instance, calls: list[tuple[Callable[..., int], int, int, int]]) -> list[int | None]:
    """Struct of plain_loop.cpp: component, functions, references of the Real and of the Integer signals."""
    (real, reals, _, _), (integer, integers, _, _) = calls
    functions = [ctypes.cast(one, ctypes.c_void_p).value for one in (instance.do_step, real, integer)]
    return [instance.component.value, *functions, reals, integers]


def by_hand(library: ctypes.CDLL, scenario: Scenario) -> Stepping:
    """The loop of plain_loop.cpp."""
    steps = round(scenario.duration / scenario.communication_step)
    length = ctypes.c_double(scenario.communication_step), ctypes.c_size_t(steps)

    def stepped(source: FmuSource, sinks: list[Sink]) -> None:
        names = source.signals.names
        counts = [ctypes.c_size_t(len(buffer)) for buffer in source.signals.buffers.values()]
        filters = (ADDRESSES * len(sinks))(
            *(ADDRESSES(*part(sink.instance, Port(sink.instance, names).setters)) for sink in sinks)
        )
        plant = ADDRESSES(*part(source.instance, source.port.getters))
        assert library.plain_loop(plant, filters, ctypes.c_size_t(len(sinks)), *counts, *length) == 0

    return stepped


def spent(scenario: Scenario, fmus: Fmus, count: int, only: tuple[str, ...] | None, step: Stepping) -> float:
    """CPU seconds of the steps of a run with the first filters."""
    filters = dict(list(scenario.filters().items())[: max(count, 1)])  # a scenario has one at least
    with ExitStack() as stack:
        source, sinks = connection.connect(scenario, fmus, filters, stack, only=only)
        assert isinstance(source, FmuSource)
        start = time.process_time()
        step(source, sinks[:count])
        return time.process_time() - start


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("library", help="plain_loop, as built")
    library = ctypes.CDLL(parser.parse_args().library)
    fmus = Fmus()
    scenario = load_scenario("swaying_ship", fmus, settings=SHORT, running=None)
    clock = Clock(time.process_time)
    Loop.run = clock.timed("loop", Loop.run)  # type: ignore[method-assign]

    def compiled(source: FmuSource, sinks: list[Sink]) -> None:
        connection.record(scenario, fmus, source, sinks, master=Master.compiled)

    ways: dict[str, tuple[tuple[str, ...] | None, Stepping]] = {
        BY_HAND: (None, by_hand(library, scenario)),
        "as a campaign does": (outputs(), compiled),
        "as a run does": (None, compiled),
    }
    for count in (1, len(scenario.filters())):
        found: defaultdict[str, list[float]] = defaultdict(list)
        for _ in range(TURNS):
            for name, way in ways.items():
                clock.spent.clear()
                found[name].append(spent(scenario, fmus, count, *way))
                if name != BY_HAND:
                    found[f"{name}, the loop alone"].append(clock.spent["loop"])
        print(f"plant + {count}, {scenario.duration:g} s, CPU seconds and ratios, medians of {TURNS} turns:")
        for name, seconds in found.items():
            ratio = median(one / other for one, other in zip(seconds, found[BY_HAND], strict=True))
            print(f"  {name:<34} {median(seconds):7.4f}   {ratio:5.3f}")


if __name__ == "__main__":
    main()
