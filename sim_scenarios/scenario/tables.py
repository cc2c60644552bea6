"""The tables of a scenario file, and what must hold of them together."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Container, Mapping
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, model_validator

from sim_scenarios import toml
from sim_scenarios.bounds import Knowledge
from sim_scenarios.catalogue import is_own_fmu
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLANT, START, Fmus, Number
from sim_scenarios.names import Label, Name, Text
from sim_scenarios.scenario.entries import (
    AccelerationSigma,
    AlignmentParameters,
    Angle,
    AngleSigma,
    AngularRate,
    AngularRateSigma,
    FilterParameters,
    Length,
    LengthSigma,
    Parts,
    Place,
    PlantParameters,
    Positive,
    Time,
    Velocity,
    VelocitySigma,
    resolved,
)
from sim_scenarios.timeline import RESOLUTION
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles import Vehicle

MOST_ROWS: Final = {"communication_step": 100_000_000, "recording_period": 10_000_000}
"""How often a run may step and record: a day by milliseconds, twelve days by tenths of a second."""

FILTER: Final = "filter"
"""Label of the scenario's filter where it runs alone."""

VEHICLES: Final = ("trajectory", "waypoints")
"""Entries that say how the vehicle moves."""

MOTION: Final = "motion."
"""Beginning of the names of parameters of the plant that are not for such a vehicle."""


class Table(BaseModel):
    """A table of a scenario file: no entry but those declared."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class InitialError(Table):
    """Error of what a coarse alignment hands over (east, north, up); a sigma adds a drawn part."""

    misalignment: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    misalignment_sigma: tuple[AngleSigma, AngleSigma, AngleSigma] = (0.0, 0.0, 0.0)
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    velocity_sigma: tuple[VelocitySigma, VelocitySigma, VelocitySigma] = (0.0, 0.0, 0.0)
    position: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    position_sigma: tuple[LengthSigma, LengthSigma, LengthSigma] = (0.0, 0.0, 0.0)


class Evaluation(Table):
    """What is judged: RMSE over a window; the heading of an alignment, or the horizontal position.

    Without a limit of its own, the horizontal RMSE is held against a single fix.
    """

    start: Time = 300.0
    stop: Time = 600.0
    heading_limit: Angle = 0.5 * DEGREE
    horizontal_limit: Length | None = None


class Prior(Table):
    """Prior knowledge that the Cramer-Rao bound assumes (science of the scenario, not belief of a filter)."""

    tilt_sigma: AngleSigma = Knowledge.tilt_sigma
    heading_sigma: AngleSigma = Knowledge.heading_sigma
    velocity_sigma: VelocitySigma = Knowledge.velocity_sigma
    gyro_bias_sigma: AngularRateSigma = Knowledge.gyro_bias_sigma
    accelerometer_bias_sigma: AccelerationSigma = Knowledge.accelerometer_bias_sigma
    position_sigma: LengthSigma = Knowledge.position_sigma


class Rival(Table):
    """A filter of a comparison that has an FMU of its own, and its parameters."""

    filter_fmu: str
    parameters: dict[str, Number]


def _rival(given: Mapping[str, Any], info: ValidationInfo) -> Rival:
    fmus: Fmus = (info.context or {})["fmus"]
    name = str(given["filter_fmu"])
    told = {key: value for key, value in given.items() if key != "filter_fmu"}
    return Rival(filter_fmu=name, parameters=resolved(told, fmus[name]))


class Trajectory(Table):
    """A file of how the vehicle moves, known by its content."""

    path: str
    version: str


class Waypoints(Table):
    """Places that the vehicle goes past, with or without their heights: see `vehicles.waypoints`."""

    places: Annotated[tuple[Place, ...], Field(min_length=2)]
    speed: Annotated[Velocity, Positive]
    turn_rate: Annotated[AngularRate, Positive] = 3 * DEGREE


def _trajectory(given: object) -> object:
    if not isinstance(given, str):
        return given
    path = Path(given).absolute()
    if not toml.exists(path):
        raise InputError(f"there is no file {given}")
    return Trajectory(path=str(path), version=f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}")


class Scenario(Table):
    """A scenario, checked against the FMUs; FMU parameters by scalar name in the FMU's units."""

    name: Name
    description: Text
    notes: Text = ""
    duration: Time = 600.0
    communication_step: Time = 0.01
    recording_period: Time = 0.1
    initial_error: InitialError = InitialError()
    evaluation: Evaluation = Evaluation()
    bound: Prior = Prior()
    filter_fmu: str = ALIGNMENT_FILTER
    trajectory: Annotated[Trajectory | None, BeforeValidator(_trajectory)] = None
    waypoints: Waypoints | None = None
    plant: PlantParameters = {}
    filter: FilterParameters = {}
    alignment: AlignmentParameters | None = None
    compare: dict[Label, FilterParameters] = Field(default={})
    rivals: dict[Label, Annotated[Rival, BeforeValidator(_rival)]] = Field(default={})
    """Filters of the table `compare` that have an FMU of their own."""

    @model_validator(mode="after")
    def _times_fit(self) -> Scenario:
        if self.communication_step <= 0:
            raise InputError(f"communication_step = {self.communication_step:g} s: must be greater than 0")
        if self.recording_period <= 0:
            raise InputError(f"recording_period = {self.recording_period:g} s: must be greater than 0")
        if self.duration < self.communication_step:
            raise InputError(f"duration = {self.duration:g} s: must be at least one communication_step")
        if self.duration < self.recording_period:
            raise InputError(f"duration = {self.duration:g} s: must be at least one recording_period")
        for name, most in MOST_ROWS.items():
            if self.duration > most * (step := getattr(self, name)):
                raise InputError(
                    f"duration = {self.duration:g} s: must be at most {most} times the {name} of {step:g} s"
                )
        if not 0 <= self.evaluation.start < self.evaluation.stop:
            raise InputError(
                f"evaluation.start = {self.evaluation.start:g} s: must be at least 0 and before "
                f"evaluation.stop ({self.evaluation.stop:g} s)"
            )
        if self.evaluation.start >= self.duration:
            raise InputError(
                f"evaluation.start = {self.evaluation.start:g}: must be below duration ({self.duration:g} s)"
            )
        stop = min(self.evaluation.stop, self.duration)
        period = self.recording_period
        if math.ceil((self.evaluation.start - RESOLUTION) / period) * period > stop + RESOLUTION:
            raise InputError(
                f"evaluation.start = {self.evaluation.start:g} s: nothing is recorded from there to "
                f"{stop:g} s with a recording_period of {period:g} s"
            )
        for name in ("heading_limit", "horizontal_limit"):
            limit = getattr(self.evaluation, name)
            if limit is not None and limit <= 0:
                raise InputError(f"evaluation.{name} = {limit:g}: must be greater than 0")
        return self

    @model_validator(mode="after")
    def _alignment_fits(self) -> Scenario:
        given = [name for values in (self.filter, *self.compare.values()) for name in values]
        if self.alignment is not None and (handed := [name for name in given if name.startswith(START)]):
            raise InputError(
                f"filter: {handed[0]} is handed over; the alignment starts from alignment.{START}*"
            )
        if self.alignment is not None and self.rivals:
            label, rival = next(iter(self.rivals.items()))
            raise InputError(
                f"compare.{label}: {rival.filter_fmu} cannot follow an alignment, which is handed over to a "
                f"{NAVIGATION_FILTER}"
            )
        if FILTER in self.rivals:
            raise InputError(f"compare.{FILTER}: that is what the filter of the scenario is called")
        return self

    @model_validator(mode="after")
    def _vehicle_fits(self) -> Scenario:
        if self.trajectory is not None and self.waypoints is not None:
            raise InputError("trajectory and waypoints: there must be one of them alone")
        vehicle = self.vehicle()
        if vehicle is not None and self.duration > vehicle.end + RESOLUTION:
            what = "trajectory" if self.waypoints is None else "way past the waypoints"
            raise InputError(
                f"duration = {self.duration:g} s: must be at most {vehicle.end:.9g} s, when the {what} ends"
            )
        return self

    def vehicle(self) -> Vehicle | None:
        """Vehicle that moves the plant; None if the plant moves by itself."""
        from sim_scenarios.vehicles import trajectory, waypoints  # slow: pandas

        if self.trajectory is not None:
            return trajectory.vehicle(Path(self.trajectory.path), self.trajectory.version)
        if self.waypoints is not None:
            return waypoints.vehicle(self.waypoints.places, self.waypoints.speed, self.waypoints.turn_rate)
        return None

    @property
    def standard(self) -> str:
        """Name of the filter of ours whose outputs are recorded, and by whose task all filters are judged.

        That is the scenario's; of one of somebody else's NavigationFilter, if there is a `horizontal_limit`,
        else AlignmentFilter.
        """
        if not is_own_fmu(self.filter_fmu):
            return self.filter_fmu
        return ALIGNMENT_FILTER if self.evaluation.horizontal_limit is None else NAVIGATION_FILTER

    def fmu_names(self) -> list[str]:
        """Names of the FMUs that the scenario connects."""
        alignment = [] if self.alignment is None else [ALIGNMENT_FILTER]
        return [PLANT, *alignment, self.filter_fmu, *(rival.filter_fmu for rival in self.rivals.values())]

    def fmu_of(self, label: str) -> str:
        """Name of the FMU of one of its filters."""
        return self.rivals[label].filter_fmu if label in self.rivals else self.filter_fmu

    def filters(self) -> dict[str, dict[str, Number]]:
        """Parameters of each filter to compare, by label."""
        variants = {label: {**self.filter, **variant} for label, variant in self.compare.items()}
        return {**variants, **{label: rival.parameters for label, rival in self.rivals.items()}}

    def with_filters(self, labels: Container[str]) -> Scenario:
        """The scenario with those of its filters to compare alone that have certain labels."""
        chosen = {
            name: {label: one for label, one in getattr(self, name).items() if label in labels}
            for name in ("compare", "rivals")
        }
        return self.model_copy(update=chosen)


def parts_of(scenario: Scenario, fmus: Fmus) -> Parts:
    """The FMUs that a scenario connects, by the table of their parameters."""
    parts = {"plant": fmus.plant, "filter": fmus[scenario.filter_fmu]}
    return parts if scenario.alignment is None else {**parts, "alignment": fmus[ALIGNMENT_FILTER]}
