"""What an entry of a scenario may be: a quantity, or the parameters of an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, ValidationInfo

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu, Number, Unit
from sim_scenarios.toml import dotted

Parts = Mapping[str, Fmu]
"""The FMUs that a scenario connects, by the table of their parameters: plant, filter, perhaps alignment."""


def _quantity(unit: str) -> BeforeValidator:
    def to_si(given: object, info: ValidationInfo) -> float:
        declared = (fmu.units[unit] for fmu in _parts(info).values() if unit in fmu.units)
        return next(declared, Unit(unit)).to_si(given)

    return BeforeValidator(to_si)


def _parameters_of(part: str) -> BeforeValidator:
    def resolve(given: object, info: ValidationInfo) -> dict[str, Number]:
        return resolved(given, _parts(info)[part])

    return BeforeValidator(resolve)


def resolved(given: object, fmu: Fmu) -> dict[str, Number]:
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


def _positive(value: float) -> float:
    if value <= 0:
        raise InputError(f"{value:g}: must be greater than 0")
    return value


NotNegative = AfterValidator(_not_negative)
Positive = AfterValidator(_positive)
Angle = Annotated[float, _quantity("rad")]
Velocity = Annotated[float, _quantity("m/s")]
Length = Annotated[float, _quantity("m")]
AngleSigma = Annotated[Angle, NotNegative]
AngularRate = Annotated[float, _quantity("rad/s")]
AngularRateSigma = Annotated[AngularRate, NotNegative]
AccelerationSigma = Annotated[float, _quantity("m/s2"), NotNegative]
VelocitySigma = Annotated[Velocity, NotNegative]
LengthSigma = Annotated[Length, NotNegative]
Time = Annotated[float, _quantity("s")]
PlantParameters = Annotated[dict[str, Number], _parameters_of("plant")]
FilterParameters = Annotated[dict[str, Number], _parameters_of("filter")]
AlignmentParameters = Annotated[dict[str, Number], _parameters_of("alignment")]


def _with_height(given: object) -> object:
    return (*given, 0.0) if isinstance(given, list | tuple) and len(given) == 2 else given


Place = Annotated[tuple[Angle, Angle, Length], BeforeValidator(_with_height)]
"""Latitude, longitude, height."""
