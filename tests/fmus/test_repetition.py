"""Reset, and many instances at once: always the same bits."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from archives import SAMPLES, STEP
from calls import OK, Fmu, Number, run


def test_reset_gives_the_same_run(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    with fmu.instance() as instance:
        once = run(instance.start(), signals, 0, SAMPLES, STEP)
        assert instance.reset() == OK
        assert run(instance.start(), signals, 0, SAMPLES, STEP) == once


def test_reset_restores_parameters_inputs_and_times(fmu: Fmu) -> None:
    with fmu.instance() as instance, fmu.instance() as fresh:
        for variable in (*fmu.of("parameter"), *fmu.of("input")):
            if variable.type == "Real":
                instance.set(variable.name, 0.9 * float(variable.start))
        instance.set_up(start=3.0, stop=9.0)
        assert instance.reset() == OK
        assert instance.start().serialise() == fresh.start().serialise()


def test_eight_instances_in_eight_threads(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    def whole_run(_index: int) -> list[bytes]:
        with fmu.instance() as instance:
            return run(instance.start(), signals, 0, SAMPLES, STEP)

    alone = whole_run(0)
    with ThreadPoolExecutor(8) as threads:
        assert all(outputs == alone for outputs in threads.map(whole_run, range(8)))


def test_two_instances_interleaved(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    with fmu.instance() as one, fmu.instance() as other:
        one.start()
        other.start()
        for index in range(0, 600, 100):
            assert run(one, signals, index, index + 100, STEP) == run(
                other, signals, index, index + 100, STEP
            )
