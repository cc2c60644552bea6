"""The log: silent unless asked, by category, always through "%s"."""

from __future__ import annotations

import ctypes
import math

import pytest
from archives import FILTERS, SAMPLES, STEP
from calls import ERROR, OK, Fmu, Instance, Number, run


def switch(instance: Instance, on: bool, *categories: str) -> int:
    names = (ctypes.c_char_p * len(categories))(*(category.encode() for category in categories))
    return instance.call("fmi2SetDebugLogging", int(on), ctypes.c_size_t(len(categories)), names)


def refused(instance: Instance) -> int:
    """How many lines a refused call writes."""
    before = len(instance.journal.lines)
    assert instance.step(math.nan, STEP) == ERROR
    return len(instance.journal.lines) - before


def test_steps_are_silent_by_default(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    with fmu.instance() as instance:
        run(instance.start(), signals, 0, SAMPLES, STEP)
        assert instance.journal.lines == []


@pytest.mark.parametrize("name", FILTERS)
def test_bad_data_is_silent_too_unless_asked_for(
    fmus: dict[str, Fmu], signals: list[dict[str, Number]], name: str
) -> None:
    bad = [{**signals[0], "imu.delta_angle[1]": math.nan}]
    for logging, lines in ((False, 0), (True, 1)):
        with fmus[name].instance(logging) as instance:
            run(instance.start(), bad, 0, 1, STEP)
            assert instance.read()["rejected_samples"] == 1
            assert len(instance.journal.lines) == lines


def test_refusals_are_logged_unless_switched_off(instance: Instance) -> None:
    instance.start()
    assert refused(instance) == 1
    assert switch(instance, False) == OK
    assert refused(instance) == 1
    assert switch(instance, False, "logStatusError") == OK
    assert refused(instance) == 0
    assert switch(instance, True, "logAll") == OK
    assert refused(instance) == 1
    assert switch(instance, False, "logAll") == OK
    assert refused(instance) == 0
    assert switch(instance, True) == OK
    assert refused(instance) == 1


def test_what_is_switched_on_by_name_is_told_alone(instance: Instance) -> None:
    instance.start()
    assert switch(instance, True, "logEvents") == OK
    assert refused(instance) == 0
    assert switch(instance, True, "logStatusError") == OK
    assert refused(instance) == 1


@pytest.mark.parametrize("name", FILTERS)
def test_events_can_be_switched(fmus: dict[str, Fmu], signals: list[dict[str, Number]], name: str) -> None:
    with fmus[name].instance() as instance:
        instance.start()
        index = 0

        def step(**spoilt: Number) -> int:
            """Lines that a step adds."""
            nonlocal index
            before = len(instance.journal.lines)
            instance.inputs.assign({**signals[index], **spoilt})
            instance.inputs.write(instance)
            assert instance.step(index * STEP, STEP) == OK
            index += 1
            return len(instance.journal.lines) - before

        # Each that is told is of a kind of its own: the same again would not be.
        not_finite, impossible = {"imu.delta_angle[1]": math.nan}, {"imu.delta_angle[1]": 100.0}
        spoilt: list[dict[str, Number]] = [not_finite, impossible, impossible, not_finite]
        for on, categories, lines in [
            (True, ("logEvents",), 1),
            (True, ("logStatusError",), 0),
            (True, ("logAll",), 1),
            (False, (), 0),
        ]:
            assert switch(instance, on, *categories) == OK
            assert step(**spoilt.pop()) == lines


@pytest.mark.parametrize("name", FILTERS)
def test_the_same_event_again_is_told_once_a_minute(
    fmus: dict[str, Fmu], signals: list[dict[str, Number]], name: str
) -> None:
    with fmus[name].instance(logging=True) as instance:
        instance.start()
        before = len(instance.journal.lines)
        for index in range(1000):
            spoilt = {"imu.sample": index + 1, "imu.delta_angle[1]": math.nan}
            instance.inputs.assign({**signals[0], **spoilt})
            instance.inputs.write(instance)
            assert instance.step(index * 0.13, 0.13) == OK  # 130 s
        told = [line.text for line in instance.journal.lines[before:] if "IMU sample" in line.text]
        assert len(told) == 3
        assert "more before" in told[-1]


@pytest.mark.parametrize("categories", [("logNothing",), ("logEvents", "logNothing")])
def test_unknown_categories(instance: Instance, categories: tuple[str, ...]) -> None:
    assert switch(instance, True, *categories) == ERROR
    assert (
        "there is no log category 'logNothing'; there are logStatusError, logEvents and logAll"
        in instance.journal.last
    )


def test_a_null_category(instance: Instance) -> None:
    names = (ctypes.c_char_p * 1)(None)
    assert instance.call("fmi2SetDebugLogging", 1, ctypes.c_size_t(1), names) == ERROR
    assert instance.journal.last == "fmi2SetDebugLogging: a category is NULL"
