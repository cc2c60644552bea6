"""Scenario files: what moves, what measures, what filters, how long, and what counts as converged.

A scenario is a TOML file. Parameters of the FMUs stand in its tables `plant` and `filter` under the FMU's own
names; `filter_fmu` names the filter's FMU, `compare` names variants of the filter. `filter_fmu` may be the
path of an FMU of somebody else's (`ports` says what it must have), and a filter of `compare` may have a
`filter_fmu` of its own; such a filter is told nothing but what its entry says. A scenario with a table
`alignment` has an AlignmentFilter with these parameters, which starts from the initial error and hands over
to its NavigationFilter. A quantity is a number in SI units or a text with one of the display units that the
FMU declares for it ("10 deg", "0.05 deg/h", "1 mg"). Nothing unknown is accepted. A file that `extends` a
shipped scenario states only what differs; its table `compare` replaces the whole comparison.

The vehicle may be one of somebody else's (`vehicles`): `trajectory` is a file of how it moves, `waypoints`
are places that it goes past. What the plant says of motion besides is not for it.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Container, Mapping
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from sim_scenarios import ports, toml
from sim_scenarios.bounds import Knowledge
from sim_scenarios.catalogue import (
    is_own_fmu,
    located,
    read_scenario,
    scenario_path,
    with_filter_fmu,
)
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import (
    ALIGNMENT_FILTER,
    NAVIGATION_FILTER,
    PLANT,
    START,
    Fmu,
    Fmus,
    Number,
    Unit,
    did_you_mean,
    no_such_parameter,
)
from sim_scenarios.names import Label, Name, Text
from sim_scenarios.timeline import RESOLUTION
from sim_scenarios.toml import dotted
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles import Vehicle

EKF_UKF_ROBUST: Final[dict[str, dict[str, Any]]] = {
    "EKF": {"predictor": "linearised", "corrector": "standard"},
    "UKF": {"predictor": "unscented", "corrector": "standard"},
    "robust UKF": {"predictor": "unscented", "corrector": "h_infinity"},
}
"""The comparison of Zhou 2011, for scenarios that name no other."""


MOST_ROWS: Final = {"communication_step": 100_000_000, "recording_period": 10_000_000}
"""How often a run may step and record: a day by milliseconds, twelve days by tenths of a second."""

FILTER: Final = "filter"
"""Label of the scenario's filter where it runs alone."""

_OF_THE_FILE: Final = ("name", "compare", "rivals")
"""Entries that are no settings."""

VEHICLES: Final = ("trajectory", "waypoints")
"""Entries that say how the vehicle moves."""

MOTION: Final = "motion."
"""Beginning of the names of parameters of the plant that are not for such a vehicle."""

Parts = Mapping[str, Fmu]
"""The FMUs that a scenario connects, by the table of their parameters: plant, filter, perhaps alignment."""


def _quantity(unit: str) -> BeforeValidator:
    def to_si(given: object, info: ValidationInfo) -> float:
        declared = (fmu.units[unit] for fmu in _parts(info).values() if unit in fmu.units)
        return next(declared, Unit(unit)).to_si(given)

    return BeforeValidator(to_si)


def _parameters_of(part: str) -> BeforeValidator:
    def resolve(given: object, info: ValidationInfo) -> dict[str, Number]:
        return _resolved(given, _parts(info)[part])

    return BeforeValidator(resolve)


def _resolved(given: object, fmu: Fmu) -> dict[str, Number]:
    """Values by scalar name of a table of parameters of an FMU."""
    values: dict[str, Number] = {}
    for name, value in dotted(given):
        values |= fmu.assignments(name, value)
    return values


def _parts(info: ValidationInfo) -> Parts:
    parts: Parts = (info.context or {})["parts"]
    return parts


def _not_negative(value: float) -> float:
    if value < 0:
        raise InputError(f"{value:g}: a sigma must be at least 0")
    return value


NotNegative = AfterValidator(_not_negative)
Angle = Annotated[float, _quantity("rad")]
Velocity = Annotated[float, _quantity("m/s")]
Length = Annotated[float, _quantity("m")]
AngleSigma = Annotated[Angle, NotNegative]
AngularRateSigma = Annotated[float, _quantity("rad/s"), NotNegative]
AccelerationSigma = Annotated[float, _quantity("m/s2"), NotNegative]
VelocitySigma = Annotated[Velocity, NotNegative]
LengthSigma = Annotated[Length, NotNegative]
Time = Annotated[float, _quantity("s")]
PlantParameters = Annotated[dict[str, Number], _parameters_of("plant")]
FilterParameters = Annotated[dict[str, Number], _parameters_of("filter")]
AlignmentParameters = Annotated[dict[str, Number], _parameters_of("alignment")]


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


def _positive(value: float) -> float:
    if value <= 0:
        raise InputError(f"{value:g}: must be greater than 0")
    return value


def _with_height(given: object) -> object:
    return (*given, 0.0) if isinstance(given, list | tuple) and len(given) == 2 else given


Place = Annotated[tuple[Angle, Angle, Length], BeforeValidator(_with_height)]
"""Latitude, longitude, height."""


def _rival(given: Mapping[str, Any], info: ValidationInfo) -> Rival:
    fmus: Fmus = (info.context or {})["fmus"]
    name = str(given["filter_fmu"])
    told = {key: value for key, value in given.items() if key != "filter_fmu"}
    return Rival(filter_fmu=name, parameters=_resolved(told, fmus[name]))


class Trajectory(Table):
    """A file of how the vehicle moves, known by its content."""

    path: str
    version: str


class Waypoints(Table):
    """Places that the vehicle goes past, with or without their heights: see `vehicles.waypoints`."""

    places: Annotated[tuple[Place, ...], Field(min_length=2)]
    speed: Annotated[Velocity, AfterValidator(_positive)]
    turn_rate: Annotated[float, _quantity("rad/s"), AfterValidator(_positive)] = 3 * DEGREE


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


def load_scenario(
    name: str | Path,
    fmus: Fmus,
    *,
    seed: int | None = None,
    settings: Mapping[str, object] | None = None,
    compare: Mapping[str, Mapping[str, object]] | None = None,
    running: Container[str] | None = (),
) -> Scenario:
    """Scenario of a shipped name or a path, with settings that override the file.

    Parameters
    ----------
    name : str or Path
        Name of a shipped scenario, or path of a TOML file, whose `.toml` may be left out.
    fmus : Fmus
        They have the FMUs whose parameters and units the file uses.
    seed : int, optional
        Seed of the plant.
    settings : mapping, optional
        Values by name: an FMU parameter (`imu.gyro.bias`), prefixed with `plant.`, `filter.` or `alignment.`
        where several FMUs have it, or an entry of the scenario (`duration`, `initial_error.misalignment`).
    compare : mapping, optional
        Filters to compare in place of the scenario's: parameters by label.
    running : container of str, optional
        Labels of the filters that are compared, None for all of them: no setting may overrule what one of
        these says of itself, for its label would not be true.

    Returns
    -------
    Scenario
    """
    path = scenario_path(name)
    table = {"name": path.stem, **read_scenario(path)}
    overriding = {**(settings or {}), **({} if seed is None else {"plant.seed": seed})}
    if "filter_fmu" in overriding:  # decides what the other entries may be
        given = located({"filter_fmu": overriding.pop("filter_fmu")}, Path())["filter_fmu"]
        table = with_filter_fmu(table, str(given))
    filter_fmu = str(table.get("filter_fmu", ALIGNMENT_FILTER))
    table.setdefault("compare", EKF_UKF_ROBUST if filter_fmu == ALIGNMENT_FILTER else {})
    try:
        parts = {"plant": fmus.plant, "filter": fmus[filter_fmu]}
        if "alignment" in table:
            parts["alignment"] = fmus[ALIGNMENT_FILTER]
            if filter_fmu != NAVIGATION_FILTER:
                raise InputError(
                    f"alignment: is handed over to a {NAVIGATION_FILTER}, and filter_fmu is {filter_fmu}"
                )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    unchanged = _check(table, parts, fmus, path)
    if compare is not None:
        table["compare"] = compare
    changed = _check(_overridden(table, parts, overriding), parts, fmus, "the settings")
    if running is None or running:
        says = unchanged if compare is None else _check(table, parts, fmus, "the filters")
        _refuse_overruled(says, changed, running, parts["filter"])
    changed = _bound_of_what_is_drawn(changed, overriding)
    if not (unchanged.notes and settings):
        return changed
    names = ", ".join(settings)
    return changed.model_copy(
        update={"notes": f"Of the scenario as it is written, before {names} changed: {changed.notes.strip()}"}
    )


def _refuse_overruled(stated: Scenario, changed: Scenario, running: Container[str] | None, fmu: Fmu) -> None:
    """Refuse settings that make a filter another than its entry says, or two filters one."""
    labels = [label for label in stated.compare if running is None or label in running]
    for label in labels:
        for name, value in stated.compare[label].items():
            if changed.compare[label][name] != value:
                raise InputError(
                    f"the setting {name}: {label} is what it is by its own {name} = "
                    f"{fmu.variables[name].display(value)}; leave it out (--filter of a campaign, or a "
                    "comparison of your own), or run one filter alone"
                )

    def are_one(scenario: Scenario, labels: tuple[str, str]) -> bool:
        one, other = ({**scenario.filter, **scenario.compare[label]} for label in labels)
        return all(
            one.get(name, fmu.start(name)) == other.get(name, fmu.start(name)) for name in {*one, *other}
        )

    for pair in combinations(labels, 2):
        if are_one(changed, pair) and not are_one(stated, pair):
            raise InputError(f"the settings make {' and '.join(pair)} the same filter; run one of them alone")


def _bound_of_what_is_drawn(scenario: Scenario, settings: Mapping[str, object]) -> Scenario:
    """Scenario whose bound knows a sigma of drawn biases that settings have changed, unless they say what.

    Biases that are no longer drawn (sigma 0) leave the bound as it is: it would have to know them exactly.
    """
    known: dict[str, Number] = {}
    for sensor in ("gyro", "accelerometer"):
        name, entry = f"imu.{sensor}.bias_sigma", f"{sensor}_bias_sigma"
        is_changed = name in settings or f"plant.{name}" in settings
        is_said = "bound" in settings or f"bound.{entry}" in settings
        if is_changed and not is_said and scenario.plant[name] > 0:
            known[entry] = scenario.plant[name]
    return scenario.model_copy(update={"bound": scenario.bound.model_copy(update=known)})


def _check(table: Mapping[str, Any], parts: Parts, fmus: Fmus, where: Path | str) -> Scenario:
    context = {"parts": parts, "fmus": fmus}
    try:
        scenario = Scenario.model_validate(_driven(_with_rivals_apart(table, where)), context=context)
    except ValidationError as error:
        raise InputError("\n".join(_sentence(where, e) for e in error.errors())) from None
    external = parts["plant"].variables["motion.kind"].items["external"]
    if scenario.plant.get("motion.kind") == external and scenario.vehicle() is None:
        raise InputError(
            f"{where}: plant.motion.kind = external: needs a trajectory or waypoints to say how it moves"
        )
    rivals = (rival.filter_fmu for rival in scenario.rivals.values())
    for name in dict.fromkeys((scenario.filter_fmu, *rivals)):
        if name != scenario.standard:
            ports.check(fmus[name], fmus.plant, fmus[scenario.standard])
    return scenario


def _driven(table: dict[str, Any]) -> dict[str, Any]:
    """Scenario table whose plant moves as a trajectory or waypoints say, if it has any."""
    if all(table.get(name) is None for name in VEHICLES):
        return table
    plant = {name: value for name, value in dotted(table.get("plant", {})) if not name.startswith(MOTION)}
    return {**table, "plant": {**plant, "motion.kind": "external"}}


def _with_rivals_apart(table: Mapping[str, Any], where: Path | str) -> dict[str, Any]:
    """Scenario table with the filters of `compare` that have an FMU of their own in a table `rivals`."""
    if "rivals" in table:
        raise InputError(f"{where}: rivals: there is no such entry; a filter_fmu in compare makes one")
    compare = table.get("compare")
    if not isinstance(compare, Mapping):
        return dict(table)
    rivals = {k: v for k, v in compare.items() if isinstance(v, Mapping) and "filter_fmu" in v}
    return {**table, "compare": {k: v for k, v in compare.items() if k not in rivals}, "rivals": rivals}


def _sentence(where: Path | str, error: Any) -> str:
    table, *rest = error["loc"] or ("",)
    key = ".".join(str(part) for part in ("compare" if table == "rivals" else table, *rest))
    cause = error.get("ctx", {}).get("error")
    if error["type"] == "extra_forbidden":
        reason = f"there is no such entry{did_you_mean(str(error['loc'][-1]), _entries(error['loc'][:-1]))}"
    else:
        reason = str(cause) if cause else f"{error['msg'][0].lower()}{error['msg'][1:]}"
    return ": ".join(part for part in (str(where), key, reason) if part)


def _entries(location: tuple[str | int, ...]) -> list[str]:
    """Names of the entries that the table at a location may have."""
    model: type[BaseModel] = Scenario
    for key in location:
        annotation = model.model_fields[str(key)].annotation
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return []
        model = annotation
    return list(model.model_fields)


def _overridden(table: Mapping[str, Any], parts: Parts, settings: Mapping[str, object]) -> dict[str, Any]:
    """Scenario table with settings put where they belong; a filter's parameter goes to every variant."""
    own = {key: value for key, value in table.items() if key not in (*parts, "compare")}
    given = {part: dict(dotted(table.get(part, {}))) for part in parts}
    compare = {label: dict(dotted(variant)) for label, variant in table["compare"].items()}
    moved_by = [entry for entry in VEHICLES if own.get(entry) is not None or entry in settings]
    for name, value in settings.items():
        owner, parameter = setting_owner(name, parts)
        if owner == "plant" and parameter.startswith(MOTION) and moved_by:
            raise InputError(f"the setting {name}: has no effect: {moved_by[0]} says how the vehicle moves")
        if owner in parts:
            variants = [one for one in compare.values() if "filter_fmu" not in one]
            for values in (given[owner], *(variants if owner == "filter" else ())):
                _put(values, parts[owner], parameter, value)
        else:
            own = _with_entry(own, parameter.split("."), value)
    return {**own, **given, "compare": compare}


def _put(values: dict[str, object], fmu: Fmu, name: str, value: object) -> None:
    """Set a parameter after all that were set before (an element overrides what its array says)."""
    fmu.assignments(name, value)
    values.pop(name, None)
    values[name] = value


def parts_of(scenario: Scenario, fmus: Fmus) -> Parts:
    """The FMUs that a scenario connects, by the table of their parameters."""
    parts = {"plant": fmus.plant, "filter": fmus[scenario.filter_fmu]}
    return parts if scenario.alignment is None else {**parts, "alignment": fmus[ALIGNMENT_FILTER]}


def setting_owner(name: str, parts: Parts) -> tuple[str, str]:
    """Which part of a scenario a setting belongs to (one of its FMUs, or "scenario"), and its name there."""
    owners = [part for part, fmu in parts.items() if fmu.has_parameter(name)]
    if len(owners) > 1:
        all_of_them = "both" if len(owners) == 2 else f"{len(owners)}"
        choices = " or ".join(f"{owner}.{name}" for owner in owners)
        raise InputError(f"{all_of_them} FMUs have a parameter {name}; say {choices}")
    if owners:
        return owners[0], name
    prefix, _, rest = name.partition(".")
    if prefix in parts:
        return prefix, rest
    if prefix == "alignment":
        raise InputError(f"the setting {name}: the scenario has no table alignment")
    if prefix in _OF_THE_FILE:
        raise InputError(f"the setting {name}: {prefix} is no setting; write a scenario file with extends")
    if prefix in Scenario.model_fields:
        return "scenario", name
    entries = [entry for entry in Scenario.model_fields if entry not in _OF_THE_FILE]
    raise no_such_parameter(name, parts, entries)


def _with_entry(table: Mapping[str, Any], path: list[str], value: object) -> dict[str, Any]:
    key, *rest = path
    if not rest:
        return {**table, key: value}
    inner = table.get(key, {})
    return {**table, key: _with_entry(inner if isinstance(inner, Mapping) else {}, rest, value)}
