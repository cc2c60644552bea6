"""Every parameter of a filter changes what it puts out, where it should: none is read and forgotten."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import pytest
from archives import FILTERS
from calls import OK, Fmu, Number
from fmpy.model_description import ScalarVariable

STEP, STEPS = 0.1, 400
Settings = dict[str, Number]
SHIP: Settings = {"body_velocity.rate": 1.0, "heading_aid.rate": 1.0, "height_aid.rate": 1.0}
PLANTS: dict[str, Settings] = {
    "ship": SHIP,
    "bad receiver": {  # whose fixes are four times as noisy for a while, and then none
        **SHIP,
        "gnss.noise_scale.step.factor": 4.0,
        "gnss.noise_scale.step.begin": 5.0,
        "gnss.noise_scale.step.end": 20.0,
        "gnss.outage.begin[1]": 25.0,
        "gnss.outage.end[1]": 39.0,
    },
    "parked": {"motion.kind": 2},
}


@dataclass(frozen=True)
class Case:
    """Where parameters with such beginnings act; those of no case do so in a filter as it comes."""

    names: tuple[str, ...]
    settings: Settings = field(default_factory=dict)
    plant: str = "bad receiver"
    filters: tuple[str, ...] = tuple(FILTERS)


ALIGNMENT, NAVIGATION = ("AlignmentFilter",), ("NavigationFilter",)
NO_GATE: Settings = {"gate.enabled": 0}
INVARIANT: Settings = {"error_model": 5}
MARKOV: Settings = {
    **INVARIANT,
    "coarse.enabled": 0,
    "process.gyro_markov_sigma": 1e-6,
    "process.accelerometer_markov_sigma": 1e-3,
}
STANDING: Settings = {
    "initial.velocity[2]": 0.0,
    "standstill.velocity_sigma": 0.01,
    "standstill.rate_sigma": 1e-5,
    "standstill.window": 2.0,
    "standstill.rate_deviation": 1e-3,
    "standstill.force_deviation": 0.02,
}
CASES = {
    "H-infinity": Case(
        ("robust.gamma", "robust.scaling", "robust.states", "robust.horizon", "robust.heading_sigma"),
        {"corrector": 2, **NO_GATE},
    ),
    "H-infinity, ceiling": Case(("robust.ceiling",), {"corrector": 2, "robust.scaling": 3, **NO_GATE}),
    "IGG": Case(("igg.", "adaptive."), {"corrector": 3, **NO_GATE}),
    "variational Bayes": Case(
        tuple(
            f"variational_bayes.{name}" for name in ("form", "rho", "iterations", "limit", "a", "velocity")
        ),
        {"corrector": 5, **NO_GATE},
    ),
    "variational Bayes of positions": Case(
        ("variational_bayes.position_sigma",), {"corrector": 5, **MARKOV, **NO_GATE}, filters=ALIGNMENT
    ),
    "variational Bayes of positions, navigation": Case(
        ("variational_bayes.position_sigma",), {"corrector": 5, **NO_GATE}, filters=NAVIGATION
    ),
    "Huber": Case(("huber.",), {"corrector": 7, **NO_GATE}),
    "combined": Case(("combined.",)),
    "gate": Case(
        ("gate.", "consistency.limit"), {"corrector": 1, "gate.patience": 3, "consistency.limit": 1.0}
    ),
    "outage": Case(("coasting.",), {"corrector": 1, **NO_GATE}),
    "wheels": Case(("nonholonomic.",), {"nonholonomic.velocity_sigma": 1.0}, "ship"),
    "standing": Case(("standstill.",), STANDING, "parked"),
    "coarse stage": Case(
        (
            "coarse.",
            "prior.position",
            "prior.height_sigma",
            "measurement.position",
            "measurement.height_sigma",
        ),
        {**INVARIANT, "coarse.heading_sigma": 0.5},
        "ship",
        ALIGNMENT,
    ),
    "height": Case(("measurement.height_aid",), MARKOV, "ship", ALIGNMENT),
    "Gauss-Markov": Case(("process.gyro_markov", "process.accelerometer_markov"), MARKOV, "ship", ALIGNMENT),
    "tight": Case(
        (
            *("propagation", "prior.clock", "process.gyro_markov", "process.clock"),
            *("measurement.pseudorange", "measurement.range_rate", "unscented."),
        ),
        {"error_model": 3, "predictor": 3},
        "ship",
        NAVIGATION,
    ),
}
ALL = [(name, case) for name in FILTERS for case in CASES if name in CASES[case].filters]


@pytest.fixture(scope="module")
def sensed(fmus: dict[str, Fmu]) -> dict[str, list[Settings]]:
    """What each plant puts out."""
    signals: dict[str, list[Settings]] = {}
    for name, settings in PLANTS.items():
        with fmus["TruthPlant"].instance() as plant:
            plant.start(**settings)
            signals[name] = []
            for index in range(STEPS):
                assert plant.step(index * STEP, STEP) == OK, plant.journal.last
                signals[name].append(plant.read())
    return signals


def put_out(fmu: Fmu, signals: list[Settings], settings: Settings) -> list[bytes] | None:
    """The bits of all outputs after each step; none of a filter that refuses its settings."""
    with fmu.instance() as filter_:
        statuses = [filter_.set(name, value) for name, value in settings.items()]
        statuses += [filter_.set_up(), filter_.enter(), filter_.exit()]
        if any(status != OK for status in statuses):
            return None
        outputs = []
        for index, sample in enumerate(signals):
            filter_.inputs.assign(sample)
            assert filter_.inputs.write(filter_) == OK
            assert filter_.step(index * STEP, STEP) == OK, filter_.journal.last
            assert filter_.outputs.read(filter_) == OK
            outputs.append(filter_.outputs.bytes)
        return outputs


def others(variable: ScalarVariable, settings: Settings) -> Iterator[Number]:
    """Other values of a parameter."""
    start = variable.start == "true" if variable.type == "Boolean" else float(variable.start)
    value = settings.get(variable.name, start)
    if variable.type == "Boolean":
        yield int(not value)
    elif variable.type == "Real":
        yield from (1.5 * value, 0.1 * value) if value else (0.5, 1e-3)
    elif variable.type == "Enumeration":
        yield from (int(item.value) for item in variable.declaredType.items if int(item.value) != value)
    else:
        yield int(value) + 1


def without_effect(fmu: Fmu, signals: list[Settings], settings: Settings, names: list[str]) -> list[str]:
    """Parameters of which no other value that is accepted changes anything."""
    before = put_out(fmu, signals, settings)
    assert before is not None

    def acts(name: str) -> bool:
        return any(
            put_out(fmu, signals, {**settings, name: value}) not in (None, before)
            for value in others(fmu.variables[name], settings)
        )

    return [name for name in names if not acts(name)]


def parameters(fmu: Fmu) -> list[str]:
    return [
        name for name, v in fmu.variables.items() if v.causality == "parameter" or v.variability == "tunable"
    ]


@pytest.mark.parametrize("name", FILTERS)
def test_a_parameter_changes_something(
    name: str, fmus: dict[str, Fmu], sensed: dict[str, list[Settings]]
) -> None:
    special = tuple(start for filter_, case in ALL if filter_ == name for start in CASES[case].names)
    plain = [parameter for parameter in parameters(fmus[name]) if not parameter.startswith(special)]
    assert plain
    assert without_effect(fmus[name], sensed["ship"], {}, plain) == []


@pytest.mark.parametrize(("name", "case"), ALL)
def test_a_parameter_changes_something_where_it_should(
    name: str, case: str, fmus: dict[str, Fmu], sensed: dict[str, list[Settings]]
) -> None:
    chosen = CASES[case]
    concerned = [parameter for parameter in parameters(fmus[name]) if parameter.startswith(chosen.names)]
    assert concerned
    assert without_effect(fmus[name], sensed[chosen.plant], chosen.settings, concerned) == []
