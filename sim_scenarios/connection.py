"""Plant and filters of a scenario: initialised, connected, and stepped to its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing

import numpy as np

from sim_scenarios import attitude, ports, recording
from sim_scenarios.cosimulation import (
    FIX_SIGNALS,
    AlignmentSource,
    FmuSource,
    Progress,
    Recorded,
    Sink,
    Source,
    connected,
    simulate,
)
from sim_scenarios.earth import radii
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Fmus, Number
from sim_scenarios.instance import Instance
from sim_scenarios.scenario import Scenario
from sim_scenarios.stepping import Master, Order
from sim_scenarios.timeline import instants, whole
from sim_scenarios.vehicles.motion import STATE, Driver

TRUTH = (
    "truth.roll",
    "truth.pitch",
    "truth.heading",
    "truth.latitude",
    "truth.longitude",
    "truth.height",
    *(f"truth.velocity[{i}]" for i in (1, 2, 3)),
)
ALIGNMENT = "alignment"
"""Label of an alignment that is handed over."""
DRAWS = 1
"""Random stream of the initial errors, apart from those of the plant."""


def connect(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    stack: ExitStack,
    order: Order = Order.gauss_seidel,
    only: Sequence[str] | None = None,
) -> tuple[FmuSource | AlignmentSource, list[Sink]]:
    """Plant and filters, initialised and connected; the stack closes them.

    With an alignment, that is what starts from the truth with the initial error; the filters wait for it.
    `only` are the outputs of a filter that are recorded, arrays by their base name, without which all are.
    """
    standard = fmus[scenario.standard]

    def recorded(fmu: Fmu) -> list[str]:
        outputs = ports.recorded(fmu, standard)
        return outputs if only is None else [name for name in outputs if name.partition("[")[0] in only]

    def begun(fmu: Fmu, label: str, values: Mapping[str, Number], source: Source) -> Sink:
        instance = stack.enter_context(closing(Instance(fmu, label, values)))
        outputs = None if label == ALIGNMENT else recorded(fmu)
        return Sink.initialised(instance, source, 0.0, scenario.duration, outputs)

    used = {label: fmus[scenario.fmu_of(label)] for label in filters}
    plant = start_plant(scenario, fmus, stack)
    start = initial_values(scenario, fmus.plant, dict(zip(TRUTH, plant.read(TRUTH), strict=True)))
    source: FmuSource | AlignmentSource
    if scenario.alignment is None:
        taken = (name for fmu in used.values() for name in connected(fmus.plant.outputs(), fmu))
        names = list(dict.fromkeys((*taken, *FIX_SIGNALS)))
        source = FmuSource(plant, names, driver(scenario, plant))
        filters = {label: filter_values(used[label], start, values) for label, values in filters.items()}
    else:
        filter_fmu = fmus[scenario.filter_fmu]
        fmu = fmus[ALIGNMENT_FILTER]
        signals = FmuSource(plant, connected(fmus.plant.outputs(), fmu), driver(scenario, plant))
        alignment = begun(fmu, ALIGNMENT, filter_values(fmu, start, scenario.alignment), signals)
        source = AlignmentSource(signals, alignment, filter_fmu, order)
    return source, [begun(used[label], label, values, source) for label, values in filters.items()]


def record(
    scenario: Scenario,
    fmus: Fmus,
    source: Source,
    sinks: Sequence[Sink],
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    master: Master = Master.auto,
) -> Recorded:
    """Step connected plant and filters to the end of a scenario."""
    return simulate(
        source,
        sinks,
        instants(scenario.duration, scenario.communication_step),
        record_every=stride(scenario),
        source_outputs=[name for name in fmus.plant.outputs() if name.startswith("truth.")],
        fix_outputs=recording.fix_outputs(fmus[scenario.standard]),
        alignment_outputs=recording.ALIGNMENT_OUTPUTS,
        order=order,
        progress=progress,
        master=master,
    )


def stride(scenario: Scenario) -> int:
    """Communication steps from one recorded instant to the next."""
    return whole(scenario.recording_period, scenario.communication_step, "recording_period")


def start_plant(scenario: Scenario, fmus: Fmus, stack: ExitStack) -> Instance:
    """The plant of a scenario, initialised; the stack closes it."""
    vehicle = scenario.vehicle()
    first = {} if vehicle is None else dict(zip(STATE, vehicle.states(np.zeros(1))[0].tolist(), strict=True))
    plant = stack.enter_context(closing(Instance(fmus.plant, "plant", {**scenario.plant, **first})))
    plant.begin_initialisation(0.0, scenario.duration)
    plant.finish_initialisation()
    return plant


def driver(scenario: Scenario, plant: Instance) -> Driver | None:
    """What tells the plant of a scenario how its vehicle moves; None if the plant moves by itself."""
    vehicle = scenario.vehicle()
    return None if vehicle is None else Driver(plant, vehicle)


def filter_values(
    filter_fmu: Fmu, start: Mapping[str, Number], values: Mapping[str, Number]
) -> dict[str, Number]:
    """All that a filter is given: what it starts from, as far as it takes it, and its parameters."""
    return {**{name: value for name, value in start.items() if filter_fmu.has_parameter(name)}, **values}


def initial_values(scenario: Scenario, plant: Fmu, truth: Mapping[str, Number]) -> dict[str, float]:
    """What the coarse alignment hands to the first filter: the truth with the initial error of the scenario.

    The computed attitude is C_b^{n'} = C_n^{n'}(phi) C_b^n.
    """
    error = scenario.initial_error
    seed = int(parameter(scenario, plant, "seed"))
    draws = np.random.default_rng([DRAWS, seed]).standard_normal((3, 3))
    phi = np.array(error.misalignment) + draws[0] * error.misalignment_sigma
    C_bn = attitude.dcm(truth["truth.roll"], truth["truth.pitch"], truth["truth.heading"])
    roll, pitch, heading = attitude.euler_angles(attitude.misalignment(phi) @ C_bn)
    velocity = [truth[f"truth.velocity[{i}]"] for i in (1, 2, 3)]
    velocity = np.array(velocity) + error.velocity + draws[1] * error.velocity_sigma
    east, north, up = np.array(error.position) + draws[2] * error.position_sigma
    latitude, height = float(truth["truth.latitude"]), float(truth["truth.height"])
    meridian, prime_vertical = radii(latitude)
    return {
        "initial.roll": roll,
        "initial.pitch": pitch,
        "initial.heading": heading,
        **{f"initial.velocity[{i + 1}]": float(velocity[i]) for i in range(3)},
        "initial.latitude": latitude + north / (meridian + height),
        "initial.longitude": float(truth["truth.longitude"])
        + east / ((prime_vertical + height) * np.cos(latitude)),
        "initial.height": height + up,
    }


def parameter(scenario: Scenario, plant: Fmu, name: str) -> Number:
    """Value of a parameter of the plant: the scenario's, else the FMU's own."""
    return scenario.plant.get(name, plant.start(name))
