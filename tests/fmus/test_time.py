"""Communication points and steps: what a master may ask for, and the sentence for what it may not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle

import pytest
from archives import FILTERS, STEP
from calls import ERROR, OK, Fmu, Instance, Number

REFUSED = {
    "zero": (0.0, 0.0, "step size = 0: must be greater than 0"),
    "negative": (0.0, -STEP, "step size = -0.01: must be greater than 0"),
    "not a number": (0.0, math.nan, "step size = nan: must be a finite number"),
    "infinite": (0.0, math.inf, "step size = inf: must be a finite number"),
    "no communication point": (math.nan, STEP, "current communication point = nan: must be a finite number"),
    "longer than a day": (0.0, 1e5, "step size = 1e+05: must be at most 86400 s"),
    "a gap": (1.0, STEP, "the step begins at 1 s, but the last one ended at 0 s"),
    "back in time": (-1.0, STEP, "the step begins at -1 s, but the last one ended at 0 s"),
    "beyond the stop time": (0.0, 20.0, "the step ends at 20 s, after the stop time of 10 s"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_steps_change_nothing(instance: Instance, case: str) -> None:
    time, size, reason = REFUSED[case]
    instance.start(stop=10.0)
    before = instance.serialise()
    assert instance.step(time, size) == ERROR
    assert instance.journal.last == f"fmi2DoStep: {reason}"
    assert instance.serialise() == before
    assert instance.step(0.0, STEP) == OK


@pytest.mark.parametrize(
    ("start", "stop", "reason"),
    [
        (math.nan, None, "start time = nan: must be a finite number"),
        (math.inf, None, "start time = inf: must be a finite number"),
        (-1e11, None, "start time = -1e+11: must be from -1e+10 to 1e+10 s"),
        (0.0, math.nan, "stop time = nan: must be a finite number"),
        (5.0, 4.0, "stop time = 4: must be at least the start time, 5"),
    ],
)
def test_refused_experiments(instance: Instance, start: float, stop: float | None, reason: str) -> None:
    assert instance.set_up(start, stop) == ERROR
    assert instance.journal.last == f"fmi2SetupExperiment: {reason}"


def test_the_master_may_round(instance: Instance) -> None:
    instance.start(stop=1.0)
    time = 0.0
    for index in range(100):
        assert instance.step(time, STEP) == OK, instance.journal.last
        time = time + STEP if index % 2 else (index + 1) * STEP


def test_a_start_time_other_than_zero(fmu: Fmu) -> None:
    with fmu.instance() as instance:
        instance.start(start=1000.0)
        assert instance.step(0.0, STEP) == ERROR
        assert instance.step(1000.0, STEP) == OK
        assert instance.step(1000.0 + STEP, STEP) == OK
        name = next((name for name in ("imu.time", "truth.time") if name in instance.outputs.names), None)
        if name:
            assert instance.read()[name] == pytest.approx(1000.0 + 2 * STEP, abs=1e-9)


def align(
    fmus: dict[str, Fmu], name: str, multiples: Sequence[int], duration: float, start: float = 0.0
) -> dict[str, Number]:
    """Plant and filter in Gauss-Seidel order; the filter's last outputs and the plant's.

    Steps are those multiples of STEP, over and over; the last one ends with the duration.
    """
    with fmus["TruthPlant"].instance() as plant, fmus[name].instance() as filter_:
        plant.start(start)
        truth = plant.read()
        filter_.start(
            start,
            **{
                "initial.roll": truth["truth.roll"] + 0.005,
                "initial.pitch": truth["truth.pitch"] - 0.005,
                "initial.heading": math.remainder(truth["truth.heading"] + 0.17, math.tau),
                "initial.latitude": truth["truth.latitude"],
                "initial.longitude": truth["truth.longitude"],
                "initial.velocity[2]": truth["truth.velocity[2]"],
            },
        )
        done, whole = 0, round(duration / STEP)
        for multiple in cycle(multiples):
            if done == whole:
                break
            time, size = start + done * STEP, min(multiple, whole - done) * STEP
            done += min(multiple, whole - done)
            assert plant.step(time, size) == OK, plant.journal.last
            filter_.inputs.assign(plant.read())
            assert filter_.inputs.write(filter_) == OK
            assert filter_.step(time, size) == OK, filter_.journal.last
        return {**plant.read(), **filter_.read()}


@pytest.mark.parametrize("name", FILTERS)
def test_the_communication_step_does_not_matter(fmus: dict[str, Fmu], name: str) -> None:
    """Within 0.1 arcmin of heading, at the same instant, steps of 1 to 10 periods, or all in turn."""
    patterns = [(1,), (2,), (5,), (10,), (1, 3, 2, 10, 7, 1, 1, 4)]
    results = [align(fmus, name, multiples, 240.0) for multiples in patterns]
    errors = [math.remainder(result["nav.heading"] - result["truth.heading"], math.tau) for result in results]
    truths = [result["truth.heading"] for result in results]
    assert truths == pytest.approx([truths[0]] * len(patterns), abs=1e-12)
    assert abs(errors[0]) < math.radians(3.0), "the filter must have worked for this to mean anything"
    assert errors == pytest.approx([errors[0]] * len(patterns), abs=math.radians(0.1 / 60))
    assert all(result["rejected_samples"] == 0 for result in results)
    assert len({result["used_fixes"] for result in results}) == 1


@pytest.mark.parametrize("name", FILTERS)
def test_the_start_time_does_not_matter_to_the_filter(fmus: dict[str, Fmu], name: str) -> None:
    late = align(fmus, name, (1,), 20.0, start=500.0)
    assert late["nav.time"] == pytest.approx(520.0, abs=1e-9)
    assert late["used_fixes"] == 20
    assert late["rejected_samples"] == 0


def test_a_step_that_the_plant_cannot_make(fmus: dict[str, Fmu]) -> None:
    with fmus["TruthPlant"].instance() as plant:
        plant.start()
        assert plant.step(0.0, 0.0123) == ERROR
        assert "0.0123" in plant.journal.last
        assert plant.step(0.0, STEP) == OK
