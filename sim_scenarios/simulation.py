"""From a scenario to a data set: plant and filters connected, initialised and run, with the bound."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import attitude, ports, recording
from sim_scenarios.bounds import POSITION, Knowledge, Log, Trajectory, cramer_rao
from sim_scenarios.cosimulation import (
    FIX_SIGNALS,
    AlignmentSource,
    DisturbedSource,
    FmuSource,
    Progress,
    Recorded,
    Sink,
    Source,
    Table,
    connected,
    simulate,
)
from sim_scenarios.earth import radii
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Fmus, Number
from sim_scenarios.instance import Instance, Message, Port
from sim_scenarios.scenario import FILTER, Scenario, load_scenario
from sim_scenarios.stepping import Order
from sim_scenarios.timeline import instants, whole
from sim_scenarios.vehicles.motion import STATE, Driver
from sim_scenarios.version import product_version

Array = NDArray[np.float64]

TRUTH = (
    "truth.roll",
    "truth.pitch",
    "truth.heading",
    "truth.latitude",
    "truth.longitude",
    "truth.height",
    *(f"truth.velocity[{i}]" for i in (1, 2, 3)),
)
NOT_IN_THE_BOUND = (
    *(
        f"imu.{sensor}.{error}"
        for sensor in ("gyro", "accelerometer")
        for error in (
            "bias_random_walk",
            "markov_sigma",
            "wave_sigma",
            "scale_factor",
            "misalignment",
            "quantisation",
            "bias_step[",
        )
    ),
    "gnss.latency",
    "gnss.position_outlier.probability",
    "gnss.velocity_outlier.probability",
    "gnss.outlier_epoch.probability",
    "gnss.outage.begin",
    "gnss.outage.end",
    "gnss.noise_scale.",
    "gnss.satellite_limit.",
    "fault.imu.kind",
    "fault.gnss.kind",
    "gnss.measures_",
    "body_velocity.lever_arm",
    "body_velocity.boresight_sigma",
    "body_velocity.measures",
    "body_velocity.outage.begin",
    "body_velocity.outage.end",
    "heading_aid.rate",
    "height_aid.rate",
)
"""Beginnings of the names of plant parameters that are no part of the Cramer-Rao bound."""
MANOEUVRES = (
    "motion.turn.angle",
    "motion.segment.turn_angle",
    "motion.segment.climb_angle",
    "motion.segment.acceleration",
)
"""Beginnings of the names of plant parameters that make the vehicle leave its steady course."""
ALIGNMENT = "alignment"
"""Label of an alignment that is handed over."""
DRAWS = 1
"""Random stream of the initial errors, apart from those of the plant."""


def run(
    scenario: str | Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    order: Order | str = Order.gauss_seidel,
    progress: Progress = lambda _: None,
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
    return recording.of_filter(run_filters(loaded, fmus, {FILTER: loaded.filter}, order, progress), FILTER)


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


def bound(
    scenario: str | Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002
    fmus: Fmus | None = None,
) -> xr.Dataset:
    """Posterior Cramer-Rao bound along the true trajectory of a scenario, without running a filter.

    Parameters as for `run`.
    """
    fmus = fmus or Fmus()
    return bound_of(load_scenario(scenario, fmus, seed=seed, settings=set), fmus)


def bound_of(scenario: Scenario, fmus: Fmus) -> xr.Dataset:
    """Posterior Cramer-Rao bound along the true trajectory of a loaded scenario.

    Beside it, where the vehicle manoeuvres, that of the same motion without: what the manoeuvres are worth.
    """
    trajectory = _true_trajectory(scenario, fmus)
    time = ("time", trajectory.time, {"units": "s"})
    data = xr.Dataset(coords={"time": time}, attrs=attributes(scenario, fmus))
    data = _with_bound(data, trajectory, scenario, fmus)
    manoeuvres = [name for name, value in scenario.plant.items() if name.startswith(MANOEUVRES) and value]
    if manoeuvres:
        steady = scenario.model_copy(update={"plant": {**scenario.plant, **dict.fromkeys(manoeuvres, 0.0)}})
        without = _with_bound(xr.Dataset(), _true_trajectory(steady, fmus), steady, fmus)
        data["bound.heading_sigma_steady"] = without["bound.heading_sigma"]
        data["bound.heading_sigma_steady"].attrs["description"] += " without the manoeuvres"
        data.attrs["bound.heading_rms_steady"] = without.attrs["bound.heading_rms"]
    return data


def _true_trajectory(scenario: Scenario, fmus: Fmus) -> Trajectory:
    """Motion of the plant at the recording period; no filter runs."""
    times = instants(scenario.duration, scenario.communication_step, stride(scenario))
    with ExitStack() as stack:
        plant = start_plant(scenario, fmus, stack)
        table = Table(Port(plant, TRUTH), len(times))
        source = FmuSource(plant, TRUTH, driver(scenario, plant))
        table.append()
        for time, end in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            source.advance(time, end - time)
            table.append()
        return _trajectory(times, table.columns())


def run_filters(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
) -> xr.Dataset:
    """Run filters, given by label and parameters, on the signals of a scenario."""
    recorded, messages = simulated(scenario, fmus, filters, order, progress)
    data = dataset(recorded, scenario, fmus, list(filters))
    data.attrs = attributes(scenario, fmus, messages)
    assert recorded.truth is not None
    trajectory = _trajectory(recorded.time, recorded.truth)
    try:
        return _with_bound(data, trajectory, scenario, fmus)
    except InputError as error:  # a run is worth having without a bound
        data.attrs["bound.leaves_out"] = f"there is none: {error}"
        return data


def dataset(recorded: Recorded, scenario: Scenario, fmus: Fmus, labels: list[str]) -> xr.Dataset:
    """Data set of what a scenario recorded, without the bound; a label for each filter."""
    alignment = None if scenario.alignment is None else fmus[ALIGNMENT_FILTER]
    filters = {label: fmus[scenario.fmu_of(label)] for label in labels}
    return recording.dataset(recorded, filters, fmus.plant, alignment)


def simulated(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    order: Order = Order.gauss_seidel,
    progress: Progress = lambda _: None,
    added: Mapping[str, Array] | None = None,
) -> tuple[Recorded, list[Message]]:
    """What plant and filters recorded and said in a scenario; `added` as of `DisturbedSource`."""
    with ExitStack() as stack:
        source, sinks = connect(scenario, fmus, filters, stack, order)
        signals: Source = source
        if added is not None:
            if not isinstance(source, FmuSource):
                raise InputError(f"{scenario.name}: nothing is added to the signals of an alignment")
            signals = DisturbedSource(source, added)
        recorded = record(scenario, fmus, signals, sinks, order, progress)
        instances = (source.instance, source.alignment, *(sink.instance for sink in sinks))
        return recorded, [message for instance in instances if instance for message in instance.messages]


def connect(
    scenario: Scenario,
    fmus: Fmus,
    filters: Mapping[str, Mapping[str, Number]],
    stack: ExitStack,
    order: Order = Order.gauss_seidel,
) -> tuple[FmuSource | AlignmentSource, list[Sink]]:
    """Plant and filters, initialised and connected; the stack closes them.

    With an alignment, that is what starts from the truth with the initial error; the filters wait for it.
    """
    standard = fmus[scenario.standard]

    def begun(fmu: Fmu, label: str, values: Mapping[str, Number], source: Source) -> Sink:
        instance = stack.enter_context(closing(Instance(fmu, label, values)))
        outputs = None if label == ALIGNMENT else ports.recorded(fmu, standard)
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
    )


def stride(scenario: Scenario) -> int:
    """Communication steps from one recorded instant to the next."""
    return whole(scenario.recording_period, scenario.communication_step, "recording_period")


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


def knowledge(scenario: Scenario, plant: Fmu, filter_fmu: Fmu) -> Knowledge:
    """What the bound of a scenario knows: its prior, the white noise of the plant, and what is measured.

    Positions count if the filter measures them.
    """

    def value(name: str) -> float:
        return float(parameter(scenario, plant, name))

    def vector(name: str) -> tuple[float, float, float]:
        return value(f"{name}[1]"), value(f"{name}[2]"), value(f"{name}[3]")

    measures_position = _measures_position(scenario, filter_fmu)
    log = Log(
        vector("body_velocity.noise_sigma"), value("body_velocity.rate"), value("body_velocity.scale_sigma")
    )
    return Knowledge(
        **scenario.bound.model_dump(),
        angle_random_walk=value("imu.gyro.white_noise"),
        velocity_random_walk=value("imu.accelerometer.white_noise"),
        gnss_velocity_sigma=vector("gnss.velocity_sigma"),
        gnss_position_sigma=vector("gnss.position_sigma") if measures_position else None,
        gnss_rate=value("gnss.rate") if _has_fixes(scenario, plant) else 0.0,
        lever_arm=vector("gnss.lever_arm"),
        log=log if log.rate > 0 else None,
    )


def _has_fixes(scenario: Scenario, plant: Fmu) -> bool:
    """Whether there is a fix, or an outage from beginning to end."""
    begin, end = (parameter(scenario, plant, f"gnss.outage.{edge}[1]") for edge in ("begin", "end"))
    return not begin <= 0 < scenario.duration < end


def _measures_position(scenario: Scenario, filter_fmu: Fmu) -> bool:
    """Whether the error model does: of AlignmentFilter the invariant one, any of another filter."""
    if filter_fmu.name != ALIGNMENT_FILTER:
        return True
    models = filter_fmu.variables["error_model"].items
    chosen = scenario.filter.get("error_model", filter_fmu.start("error_model"))
    return bool(chosen == models["invariant"])


def left_out_of_the_bound(scenario: Scenario, plant: Fmu) -> list[str]:
    """Parameters of the plant that are in effect in a scenario and that its bound does not know."""
    in_effect = {
        name.partition("[")[0]
        for name, value in scenario.plant.items()
        if name.startswith(NOT_IN_THE_BOUND) and value != plant.start(name)
    }
    for sensor in ("gyro", "accelerometer"):
        drawn = parameter(scenario, plant, f"imu.{sensor}.bias_sigma")
        if drawn > 0 and not math.isclose(
            drawn, getattr(scenario.bound, f"{sensor}_bias_sigma"), rel_tol=1e-3
        ):
            in_effect.add(f"imu.{sensor}.bias_sigma")
    if not _has_fixes(scenario, plant):
        in_effect = {name for name in in_effect if not name.startswith("gnss.")}
    return [name for name in plant.arrays if name in in_effect]


def parameter(scenario: Scenario, plant: Fmu, name: str) -> Number:
    """Value of a parameter of the plant: the scenario's, else the FMU's own."""
    return scenario.plant.get(name, plant.start(name))


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


def _trajectory(time: Array, truth: Mapping[str, Array]) -> Trajectory:
    """True motion; a Jacobi master has the samples of the start twice, of which one counts."""
    new = np.concatenate(([True], np.diff(time) > 0))
    column = {name: truth[name][new] for name in TRUTH}
    return Trajectory(
        time=time[new],
        C_bn=attitude.dcm(column["truth.roll"], column["truth.pitch"], column["truth.heading"]),
        velocity=np.column_stack([column[f"truth.velocity[{i}]"] for i in (1, 2, 3)]),
        latitude=column["truth.latitude"],
        height=column["truth.height"],
    )


def _measured(known: Knowledge) -> str:
    """What the measurements of a bound are of, in words."""
    if known.gnss_rate == 0:
        return "velocity in body axes"
    velocity = "velocity" if known.log is None else "velocity, in body axes too,"
    return velocity.rstrip(",") if known.gnss_position_sigma is None else f"{velocity} and position"


def _with_bound(data: xr.Dataset, trajectory: Trajectory, scenario: Scenario, fmus: Fmus) -> xr.Dataset:
    """Data set with the bound along a trajectory, and with what the bound does not know."""
    known = knowledge(scenario, fmus.plant, fmus[scenario.filter_fmu])
    bound = cramer_rao(trajectory, known)
    attributes = {
        "bound.heading_rms": bound.heading_rms(scenario.evaluation.start, scenario.evaluation.stop),
        "bound.steady_course_limit": known.steady_course_limit(float(trajectory.latitude[0])),
        "bound.measured": _measured(known),
        "bound.leaves_out": ", ".join(left_out_of_the_bound(scenario, fmus.plant)),
    }
    data = data.assign_coords(bound_time=("bound_time", bound.time, {"units": "s"}))
    description = "Posterior Cramer-Rao bound of the "
    data["bound.heading_sigma"] = (
        "bound_time",
        bound.heading_sigma,
        {"units": "rad", "description": f"{description}heading"},
    )
    if known.gnss_position_sigma is not None:
        data["bound.position_sigma"] = (
            ("bound_time", "axis3"),
            bound.sigma[:, POSITION],
            {"units": "m", "description": f"{description}position (east, north, up)"},
        )
    data.attrs |= attributes
    return data


def attributes(scenario: Scenario, fmus: Fmus, messages: Sequence[Message] = ()) -> dict[str, str | float]:
    """What made a data set, and how to judge it."""
    window = scenario.evaluation
    plant, filter_fmu = fmus.plant, fmus[scenario.filter_fmu]
    settings = {"plant": _readable(scenario.plant, plant), "filter": _readable(scenario.filter, filter_fmu)}
    if scenario.alignment is not None:
        settings["alignment"] = _readable(scenario.alignment, fmus[ALIGNMENT_FILTER])
    for moved_by in (scenario.trajectory, scenario.waypoints):
        if moved_by is not None:
            settings["vehicle"] = {name: str(value) for name, value in moved_by.model_dump().items()}
    return {
        "scenario": scenario.name,
        "description": scenario.description,
        "notes": scenario.notes,
        "seed": int(parameter(scenario, plant, "seed")),
        "duration": scenario.duration,
        "communication_step": scenario.communication_step,
        "evaluation.start": window.start,
        "evaluation.stop": min(window.stop, scenario.duration),
        "evaluation.heading_limit": window.heading_limit,
        "evaluation.horizontal_limit": _horizontal_limit(scenario, plant),
        "filter_fmu": scenario.standard,
        "settings": json.dumps(settings),
        "filters": json.dumps(
            {k: _readable(v, fmus[scenario.fmu_of(k)]) for k, v in scenario.filters().items()}
        ),
        "versions": json.dumps(
            {
                "truenorth": product_version() or "not installed (checkout)",
                **{name: fmus[name].version for name in scenario.fmu_names()},
            }
        ),
        "messages": json.dumps([str(message) for message in messages]),
    }


def _horizontal_limit(scenario: Scenario, plant: Fmu) -> float:
    """Horizontal RMSE up to which a filter navigates [m]: of a single fix, or as the scenario has it."""
    if scenario.evaluation.horizontal_limit is not None:
        return scenario.evaluation.horizontal_limit
    return math.hypot(*(float(parameter(scenario, plant, f"gnss.position_sigma[{i}]")) for i in (1, 2)))


def _readable(values: Mapping[str, Number], fmu: Fmu) -> dict[str, str]:
    return {name: fmu.variables[name].display(value) for name, value in values.items()}
