"""Bound of a scenario (`bounds`, `heading_posterior`): its trajectory, what is known, what is left out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import attitude
from sim_scenarios.bounds import POSITION, Knowledge, Log, Trajectory, cramer_rao
from sim_scenarios.connection import TRUTH, driver, parameter, start_plant, stride
from sim_scenarios.cosimulation import FmuSource, Table
from sim_scenarios.errors import SimulationError
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmu, Fmus
from sim_scenarios.heading_posterior import WIDE, heading_posterior
from sim_scenarios.instance import Port
from sim_scenarios.provenance import attributes
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.timeline import instants

Array = NDArray[np.float64]

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

    Beside it, where the prior of the heading is wide, that of heading errors of any size; and where the
    vehicle manoeuvres, the Cramer-Rao bound of the same motion without: what the manoeuvres are worth. That
    is left out where that motion ends before the scenario does, at a pole, say.
    """
    true = _true_trajectory(scenario, fmus)
    time = ("time", true.time, {"units": "s"})
    data = xr.Dataset(coords={"time": time}, attrs=attributes(scenario, fmus))
    data = with_bound(data, true, scenario, fmus)
    known = knowledge(scenario, fmus.plant, fmus[scenario.filter_fmu])
    if known.heading_sigma >= WIDE and known.log is None:
        data = _with_posterior(data, true, known)
    manoeuvres = [name for name, value in scenario.plant.items() if name.startswith(MANOEUVRES) and value]
    if manoeuvres:
        steady = scenario.model_copy(update={"plant": {**scenario.plant, **dict.fromkeys(manoeuvres, 0.0)}})
        try:
            straight_on = _true_trajectory(steady, fmus)
        except SimulationError:
            return data
        without = with_bound(xr.Dataset(), straight_on, steady, fmus)
        data["bound.heading_sigma_steady"] = without["bound.heading_sigma"]
        data["bound.heading_sigma_steady"].attrs["description"] += " without the manoeuvres"
        data.attrs["bound.heading_rms_steady"] = without.attrs["bound.heading_rms"]
    return data


def with_bound(data: xr.Dataset, true: Trajectory, scenario: Scenario, fmus: Fmus) -> xr.Dataset:
    """Data set with the bound along a trajectory, and with what the bound does not know."""
    known = knowledge(scenario, fmus.plant, fmus[scenario.filter_fmu])
    bound = cramer_rao(true, known)
    about = {
        "bound.heading_rms": bound.heading_rms(scenario.evaluation.start, scenario.evaluation.stop),
        "bound.steady_course_limit": known.steady_course_limit(float(true.latitude[0])),
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
    data.attrs |= about
    return data


def _with_posterior(data: xr.Dataset, true: Trajectory, known: Knowledge) -> xr.Dataset:
    """Data set of a bound with that of heading errors of any size."""
    posterior = heading_posterior(true, known)
    data["bound.heading_sigma_any"] = (
        "bound_time",
        posterior.heading_sigma,
        {"units": "rad", "description": "Least root mean square error of the heading, whatever its size"},
    )
    rms, standard_error = posterior.heading_rms(
        *(data.attrs[f"evaluation.{edge}"] for edge in ("start", "stop"))
    )
    data.attrs |= {"bound.heading_rms_any": rms, "bound.heading_rms_any_standard_error": standard_error}
    return data


def trajectory(time: Array, truth: Mapping[str, Array]) -> Trajectory:
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
        return trajectory(times, table.columns())


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


def _measured(known: Knowledge) -> str:
    """What the measurements of a bound are of, in words."""
    if known.gnss_rate == 0:
        return "velocity in body axes"
    velocity = "velocity" if known.log is None else "velocity, in body axes too,"
    return velocity.rstrip(",") if known.gnss_position_sigma is None else f"{velocity} and position"
