"""Access to variables: who may set what and when, and the sentence for a bad parameter."""

from __future__ import annotations

import math
import re
from ctypes import byref, c_double, c_int, c_size_t, c_uint

import pytest
from archives import FILTERS, SAMPLES, STEP, choices
from calls import ERROR, OK, STARTS, Fmu, Instance, Number, run
from fmpy.model_description import ScalarVariable


def bad_values(variable: ScalarVariable) -> list[tuple[Number, str]]:
    """Values that break the declaration, and words of the rule."""
    if variable.type == "Enumeration":
        items = len(variable.declaredType.items)
        return [(0, "one of"), (items + 1, "one of")]
    values: list[tuple[Number, str]] = []
    if variable.type == "Real":
        values += [
            (math.nan, "a finite number"),
            (math.inf, "a finite number"),
            (-math.inf, "a finite number"),
        ]
    if variable.min is not None:
        least = STARTS[variable.type](variable.min)
        values.append((least - max(1, abs(least)), "at least |greater than "))
    if variable.max is not None:
        most = STARTS[variable.type](variable.max)
        values.append((most + max(1, abs(most)), "at most "))
    return values


def test_start_values_are_those_of_the_description(instance: Instance) -> None:
    instance.set_up()
    instance.enter()
    for variable in (*instance.fmu.of("parameter"), *instance.fmu.of("input")):
        base = "Integer" if variable.type == "Enumeration" else variable.type
        expected = STARTS[base]({"true": "1", "false": "0"}.get(variable.start, variable.start))
        number = instance.get(variable.name)
        assert number == expected or (math.isnan(number) and math.isnan(expected)), variable.name


def test_bad_parameters_fail_the_initialisation_with_a_sentence(fmu: Fmu) -> None:
    tried = 0
    with fmu.instance() as instance:
        for variable in fmu.of("parameter"):
            for value, rule in bad_values(variable):
                instance.reset()
                assert instance.set(variable.name, value) == OK
                instance.set_up()
                assert instance.enter() == OK
                assert instance.exit() == ERROR, f"{variable.name} = {value} was accepted"
                text = instance.journal.last
                assert text.startswith(f"fmi2ExitInitializationMode: {variable.name} = "), text
                assert re.search(f"must be ({rule})", text), text
                tried += 1
    assert tried > 10


def test_a_failed_initialisation_can_be_mended(fmu: Fmu) -> None:
    variable = next(v for v in fmu.of("parameter") if v.type == "Real")
    with fmu.instance() as instance:
        good = float(variable.start)
        instance.set(variable.name, math.nan)
        instance.set_up()
        instance.enter()
        assert instance.outputs.read(instance) == ERROR
        assert variable.name in instance.journal.last
        assert instance.exit() == ERROR
        assert instance.step(0.0, STEP) == ERROR
        assert instance.set(variable.name, good) == OK
        assert instance.exit() == OK
        assert instance.step(0.0, STEP) == OK


def test_outputs_can_be_read_in_initialisation_mode(fmu: Fmu) -> None:
    with fmu.instance() as instance:
        instance.set_up()
        instance.enter()
        instance.read()
        before = instance.outputs.bytes
        instance.exit()
        instance.read()
        assert instance.outputs.bytes == before


def test_outputs_in_initialisation_mode_follow_the_parameters(fmu: Fmu) -> None:
    name = next(n for n in ("initial.latitude", "motion.latitude", "recording.skip") if n in fmu.variables)
    output = {
        "initial.latitude": "nav.latitude",
        "motion.latitude": "truth.latitude",
        "recording.skip": "recording.time",
    }[name]
    with fmu.instance() as instance:
        instance.set_up()
        instance.enter()
        for value in (0.1, 0.7):
            instance.set(name, value)
            assert instance.read()[output] == pytest.approx(value, abs=1e-12)


def test_fixed_parameters_stay_fixed(fmu: Fmu) -> None:
    with fmu.instance() as instance:
        instance.start()
        for variable in fmu.of("parameter", "fixed"):
            before = instance.get(variable.name)
            assert instance.set(variable.name, before) == ERROR, variable.name
            assert instance.journal.last.endswith(
                f"{variable.name} is a fixed parameter and cannot change after initialisation"
            )


def test_tunable_parameters_change_between_steps_and_bad_values_do_not(fmu: Fmu) -> None:
    with fmu.instance() as instance:
        instance.start()
        for variable in fmu.of("parameter", "tunable"):
            good = instance.get(variable.name)
            assert instance.set(variable.name, good) == OK, instance.journal.last
            for value, _ in bad_values(variable):
                assert instance.set(variable.name, value) == ERROR, variable.name
                assert f"{variable.name} = " in instance.journal.last
                assert instance.get(variable.name) == good
        assert instance.step(0.0, STEP) == OK


def test_a_tuned_value_is_kept(fmu: Fmu) -> None:
    reals = [v for v in fmu.of("parameter", "tunable") if v.type == "Real"]
    if not reals:
        pytest.skip(f"{fmu.name} has no tunable Real")
    with fmu.instance() as instance:
        instance.start()
        value = 0.9 * instance.get(reals[0].name)
        assert instance.set(reals[0].name, value) == OK
        assert instance.get(reals[0].name) == value


@pytest.mark.parametrize("name", FILTERS)
def test_noise_that_is_tuned_counts_from_then_on(
    fmus: dict[str, Fmu], name: str, signals: list[dict[str, Number]]
) -> None:
    """Fixes are told to be a thousand times worse in the middle of a run, and innovations expected so."""
    half = SAMPLES // 2
    sigmas = []
    for factor in (1.0, 1000.0):
        with fmus[name].instance() as instance:
            instance.start()
            run(instance, signals, 0, half, STEP)
            told = factor * instance.get("measurement.velocity_sigma")
            assert instance.set("measurement.velocity_sigma", told) == OK, instance.journal.last
            run(instance, signals, half, SAMPLES, STEP)
            sigmas.append(max(v for n, v in instance.read().items() if n.startswith("innovation_sigma[")))
    assert sigmas[1] >= told > 2 * sigmas[0]


def test_a_gamma_that_is_tuned_counts_from_then_on(
    fmus: dict[str, Fmu], signals: list[dict[str, Number]]
) -> None:
    half = SAMPLES // 2
    corrector = choices(fmus["AlignmentFilter"], "corrector")[1]  # h_infinity
    with fmus["AlignmentFilter"].instance() as instance:
        instance.start(corrector=corrector)
        run(instance, signals, 0, half, STEP)
        before = instance.get("robust.gamma_effective")
        assert instance.set("robust.gamma", 2 * before) == OK, instance.journal.last
        run(instance, signals, half, SAMPLES, STEP)
        assert instance.get("robust.gamma_effective") == pytest.approx(2 * before)


def test_outputs_cannot_be_set(fmu: Fmu) -> None:
    with fmu.instance() as instance:
        for variable in fmu.of("output"):
            assert instance.set(variable.name, 1) == ERROR
            assert instance.journal.last.endswith(f"{variable.name} is an output and cannot be set")


@pytest.mark.parametrize("function", ["fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2SetReal"])
@pytest.mark.parametrize("reference", [100000, 2**32 - 1])
def test_unknown_value_reference(instance: Instance, function: str, reference: int) -> None:
    instance.start()
    value = c_double() if function.endswith("Real") else c_int()
    assert instance.call(function, byref(c_uint(reference)), c_size_t(1), byref(value)) == ERROR
    assert instance.journal.last.endswith(f"there is no variable with the value reference {reference}")


def test_wrong_type(instance: Instance) -> None:
    instance.start()
    variable = next(v for v in instance.fmu.variables.values() if v.type == "Real")
    value = c_int()
    reference = c_uint(variable.valueReference)
    assert instance.call("fmi2GetInteger", byref(reference), c_size_t(1), byref(value)) == ERROR
    assert f"{variable.name} has the type Real, not Integer" in instance.journal.last


def test_all_or_nothing(instance: Instance) -> None:
    reals = [v for v in instance.fmu.of("parameter") if v.type == "Real"]
    start = float(reals[0].start)
    references = (c_uint * 2)(reals[0].valueReference, 100000)
    values = (c_double * 2)(start + 1.0, 0.0)
    assert instance.call("fmi2SetReal", references, c_size_t(2), values) == ERROR
    instance.set_up()
    instance.enter()
    assert instance.get(reals[0].name) == start
