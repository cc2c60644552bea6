"""Which columns of a text file a table has, and in which units."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict

from sim_scenarios.recordings import units as of
from sim_scenarios.recordings.readers.time_columns import ISO, TIME_OF_DAY

Column = Annotated[str, BeforeValidator(lambda given: str(given) if isinstance(given, int) else given)]
"""Name of a column, or its number from 1; "" stands for what the file does not have."""
Three = tuple[Column, Column, Column]
Stamps = Annotated[
    tuple[Column, ...], BeforeValidator(lambda given: given if isinstance(given, (list, tuple)) else (given,))
]
NONE: Final = ("", "", "")


def _one_of(*units: of.Units) -> AfterValidator:
    known = {name: size for some in units for name, size in some.items()}

    def check(text: str) -> str:
        of.si(text, known)
        return text

    return AfterValidator(check)


Time = Annotated[str, _one_of(of.TIME, {ISO: 1.0, TIME_OF_DAY: 1.0})]
Angular = Annotated[str, _one_of(of.ANGLE, of.ANGULAR_RATE)]
Force = Annotated[str, _one_of(of.DELTA_VELOCITY, of.SPECIFIC_FORCE)]
Angle = Annotated[str, _one_of(of.ANGLE)]
Length = Annotated[str, _one_of(of.LENGTH)]
Velocity = Annotated[str, _one_of(of.VELOCITY)]
"""Units of quantities."""


def three(prefix: str, axes: str = "east north up") -> Three:
    """Names with one beginning."""
    first, second, third = (f"{prefix}_{axis}" for axis in axes.split())
    return first, second, third


class _Said(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ImuColumns(_Said):
    """Columns of an IMU: rates or increments, as their units say."""

    time: Stamps = ("time",)
    angular: Three = three("delta_angle", "x y z")
    force: Three = three("delta_velocity", "x y z")


class ImuUnits(_Said):
    """Their units; angles with velocities are increments, angular rates with specific forces are rates."""

    time: Time = "s"
    angular: Angular = "rad"
    force: Force = "m/s"


class AccelerometerColumns(_Said):
    """Columns of forces that were recorded apart from the angles."""

    time: Stamps = ("time",)
    force: Three = three("delta_velocity", "x y z")


class AccelerometerUnits(_Said):
    """Their units."""

    time: Time = "s"
    force: Force = "m/s"


class GnssColumns(_Said):
    """Columns of fixes: latitude, longitude, height; the rest in east, north, up."""

    time: Stamps = ("time",)
    position: Three = NONE
    velocity: Three = NONE
    position_sigma: Three = NONE
    velocity_sigma: Three = NONE


class GnssUnits(_Said):
    """Their units; `position` is that of latitude and longitude."""

    time: Time = "s"
    position: Angle = "deg"
    height: Length = "m"
    velocity: Velocity = "m/s"
    position_sigma: Length = "m"
    velocity_sigma: Velocity = "m/s"


class BodyVelocityColumns(_Said):
    """Columns of a velocity in right, forward, up."""

    time: Stamps = ("time",)
    velocity: Three = NONE
    sigma: Three = NONE


class BodyVelocityUnits(_Said):
    """Their units."""

    time: Time = "s"
    velocity: Velocity = "m/s"
    sigma: Velocity = "m/s"


class HeadingColumns(_Said):
    """Columns of a heading, clockwise from north."""

    time: Stamps = ("time",)
    heading: Column = "heading"
    sigma: Column = ""


class HeadingUnits(_Said):
    """Their units."""

    time: Time = "s"
    heading: Angle = "deg"
    sigma: Angle = "deg"


class HeightColumns(_Said):
    """Columns of a height."""

    time: Stamps = ("time",)
    height: Column = "height"
    sigma: Column = ""


class HeightUnits(_Said):
    """Their units."""

    time: Time = "s"
    height: Length = "m"
    sigma: Length = "m"


class ReferenceColumns(_Said):
    """Columns of a reference: roll, pitch, heading; latitude, longitude, height; east, north, up."""

    time: Stamps = ("time",)
    attitude: Three = NONE
    position: Three = NONE
    velocity: Three = NONE


class ReferenceUnits(_Said):
    """Their units; `position` is that of latitude and longitude."""

    time: Time = "s"
    attitude: Angle = "deg"
    position: Angle = "deg"
    height: Length = "m"
    velocity: Velocity = "m/s"
