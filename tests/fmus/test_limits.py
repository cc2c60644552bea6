"""Every parameter has limits, and within them no output ever stops being a number."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from calls import OK, Fmu, Instance, Number
from fmpy.model_description import ScalarVariable
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

STEP = 0.1
STEPS = 150
MOST_CHANGED = 6
SHORT, LONG = 40, 2000

Values = dict[str, Number]

MEASURED: dict[str, str] = {
    "gnss.longitude": "gnss.measures_position[1]",
    "gnss.latitude": "gnss.measures_position[2]",
    "gnss.height": "gnss.measures_position[3]",
    **{f"gnss.velocity[{i}]": f"gnss.measures_velocity[{i}]" for i in (1, 2, 3)},
    **{f"body_velocity.velocity[{i}]": f"body_velocity.measures[{i}]" for i in (1, 2, 3)},
}
"""Outputs of the plant that are no number where they are not measured, and the parameter that says so."""


@pytest.fixture(scope="session")
def outputs_of_plant(fmus: dict[str, Fmu]) -> list[Values]:
    """What a filter is fed: the plant's outputs after each of STEPS steps."""
    with fmus["TruthPlant"].instance() as plant:
        plant.start()
        samples = []
        for index in range(STEPS):
            assert plant.step(index * STEP, STEP) == OK, plant.journal.last
            samples.append(plant.read())
        return samples


def numbers(variable: ScalarVariable) -> st.SearchStrategy[Number]:
    """What the declaration of a parameter admits; of a Real, as often its limits and small sizes."""
    if variable.type == "Boolean":
        return st.integers(0, 1)
    if variable.type == "Enumeration":
        return st.integers(1, len(variable.declaredType.items))
    if variable.type == "Integer":
        return st.integers(int(variable.min or 0), int(variable.max or 2**31 - 1))
    least, most = float(variable.min), float(variable.max)
    ends = [value for value in (least, most, 1e-100, 1e-30, 1e-6) if least <= value <= most]
    return st.sampled_from(ends) | st.floats(least, most)


def changes(fmu: Fmu) -> st.SearchStrategy[Values]:
    """A few parameters, with values that their declarations admit."""
    parameters = {variable.name: variable for variable in fmu.of("parameter")}
    chosen = st.lists(st.sampled_from(sorted(parameters)), min_size=1, max_size=MOST_CHANGED, unique=True)
    return chosen.flatmap(lambda names: st.fixed_dictionaries({n: numbers(parameters[n]) for n in names}))


def require_finite(instance: Instance, when: str) -> None:
    lost = [
        f"{name} = {value}"
        for name, value in instance.read().items()
        if not math.isfinite(value) and not (math.isnan(value) and absent(instance, name))
    ]
    assert not lost, f"{when}: {lost}"


def absent(instance: Instance, output: str) -> bool:
    if output.startswith("truth."):
        return instance.fmu.name == "Playback"  # whose recording has no reference
    measured = MEASURED.get(output, "")
    return measured in instance.fmu.variables and not instance.get(measured)


def run(instance: Instance, values: Values, samples: list[Values]) -> None:
    """As far as the FMU goes: what it refuses it must refuse with the name of a parameter."""
    for name, value in values.items():
        assert instance.set(name, value) == OK, instance.journal.last
    instance.set_up()
    instance.enter()
    if instance.exit() != OK:
        event("refused")
        assert any(name in instance.journal.last for name in instance.fmu.variables), instance.journal.last
        return
    event("run")
    require_finite(instance, "at the start")
    rate = instance.get("imu.rate") if "imu.rate" in instance.fmu.variables else 1.0 / STEP
    step = max(1, round(STEP * rate)) / rate
    for index, sample in enumerate(samples):
        instance.inputs.assign(sample)
        assert instance.inputs.write(instance) == OK
        if instance.step(index * step, step) != OK:
            # A plant runs into the ground or leaves the Earth; a filter says `faulted` and goes on.
            assert instance.fmu.name == "TruthPlant", instance.journal.last
            event("stopped")
            require_finite(instance, f"after step {index}, which failed")
            return
        require_finite(instance, f"after step {index}")


def search(fmu: Fmu, samples: list[Values], examples: int) -> None:
    """Run the FMU with random accepted parameters."""

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck), print_blob=True)
    @given(values=changes(fmu))
    def search_on(values: Values) -> None:
        with fmu.instance() as instance:
            run(instance, values, samples)

    find: Callable[[], None] = search_on
    find()


def test_every_real_parameter_has_limits(fmu: Fmu) -> None:
    for variable in fmu.of("parameter"):
        if variable.type == "Real":
            assert variable.min is not None, variable.name
            assert variable.max is not None, variable.name


def test_no_accepted_parameters_make_an_output_that_is_no_number(
    fmu: Fmu, outputs_of_plant: list[Values]
) -> None:
    search(fmu, outputs_of_plant, SHORT)


@pytest.mark.slow
def test_no_accepted_parameters_of_very_many(fmu: Fmu, outputs_of_plant: list[Values]) -> None:
    search(fmu, outputs_of_plant, LONG)
