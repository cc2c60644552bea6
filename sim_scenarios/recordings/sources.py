"""A recording in a few words: which file, columns, units, axes, clock and lever arms.

    name = "car drive"

    [imu]
    file = "imu.csv.gz"
    clock = "gps-day"
    axes = "forward-right-down"             # into which the mounting leads
    mounting = [[...], [...], [...]]        # (forward, right, down) = mounting * (x, y, z of the sensor)
    columns = { time = "time_gpst_s", angular = ["gx", "gy", "gz"], force = ["ax", "ay", "az"] }
    units = { angular = "deg/s", force = "g" }

    [gnss]
    file = "gnss.pos.gz"
    lever_arm = [-0.05, 0.0, 0.0]

Tables `imu`, `accelerometer`, `gnss`, `body_velocity`, `heading`, `height`, `reference`, of which the first
is needed. The second is for forces in a file of their own, with stamps of their own: then the first has
angles alone. Each has

    file        relative to the description; that of the IMU where it is left out
    format      where it is not known by the file itself
    columns     names or numbers of columns of a text file; a minus in front turns the sign
    units       of these columns; those of the angular column decide between rates and increments
    clock       gps, unix, gps-week, gps-day, utc-day, own
    offset      seconds to add to its stamps; of the IMU or of the fixes "found": those with which one goes
                with the other, see `recordings.simultaneity`; that of `imu` holds for `accelerometer` too,
                unless that has its own
    stamps      "recorded"; "sorted": brought in order; "steady": moved onto the sensor's own steady clock

of fixes `velocity_offset`, the seconds from a stamp to when its velocity held: receivers that smooth it have
less than 0; and sigmas [SI, or "1 deg"], which hold in the place of those of the file. A sample of rates
covers the step that ends at its stamp; after a gap one ordinary period, so that the gap stays one.
"""

from __future__ import annotations

import math
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from sim_scenarios import toml
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.names import Text
from sim_scenarios.recordings import units as of
from sim_scenarios.recordings.readers import layouts
from sim_scenarios.recordings.readers.contents import Clock

Finite = Annotated[float, Field(allow_inf_nan=False)]
Vector = tuple[Finite, Finite, Finite]
FOUND: Final = "found"
"""Offset that is found of the motion."""


class StampsAre(Enum):
    """What is made of the stamps of a table."""

    RECORDED = "recorded"
    SORTED = "sorted"
    STEADY = "steady"


def _quantity(units: of.Units) -> BeforeValidator:
    def to_si(given: object) -> object:
        return of.si(given, units) if isinstance(given, str) else given

    return BeforeValidator(to_si)


def _in_each_direction(given: object) -> object:
    return given if isinstance(given, (list, tuple)) else (given, given, given)


def _seconds_or_found(given: object) -> object:
    if given == FOUND or (isinstance(given, (int, float)) and math.isfinite(given)):
        return given
    raise InputError(f"'{given}': must be a finite number of seconds, or '{FOUND}'")


Offset = Annotated[float | Literal["found"], BeforeValidator(_seconds_or_found)]
LengthSigma = Annotated[Finite, _quantity(of.LENGTH), Field(gt=0)]
VelocitySigma = Annotated[Finite, _quantity(of.VELOCITY), Field(gt=0)]
AngleSigma = Annotated[Finite, _quantity(of.ANGLE), Field(gt=0)]
LengthSigmas = Annotated[tuple[LengthSigma, LengthSigma, LengthSigma], BeforeValidator(_in_each_direction)]
VelocitySigmas = Annotated[
    tuple[VelocitySigma, VelocitySigma, VelocitySigma], BeforeValidator(_in_each_direction)
]


class _Said(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Source(_Said):
    """Where a table comes from, and on which clock its stamps are."""

    file: Path | None = None
    format: str | None = None
    clock: Clock | None = None
    offset: Offset = 0.0
    stamps: StampsAre = StampsAre.RECORDED


class ImuSource(Source):
    """An IMU."""

    file: Path
    columns: layouts.ImuColumns | None = None
    units: layouts.ImuUnits = layouts.ImuUnits()
    axes: str | None = None
    mounting: tuple[Vector, Vector, Vector] | None = None


class AccelerometerSource(Source):
    """Forces of an IMU that were recorded apart from its angles, in the same axes."""

    columns: layouts.AccelerometerColumns | None = None
    units: layouts.AccelerometerUnits = layouts.AccelerometerUnits()


class GnssSource(Source):
    """Fixes; sigmas in east, north, up, or one number for all three."""

    columns: layouts.GnssColumns | None = None
    units: layouts.GnssUnits = layouts.GnssUnits()
    lever_arm: Vector = (0.0, 0.0, 0.0)
    velocity_offset: float = Field(default=0.0, ge=-5.0, le=5.0, allow_inf_nan=False)
    position_sigma: LengthSigmas | None = None
    velocity_sigma: VelocitySigmas | None = None


class BodyVelocitySource(Source):
    """A log, an odometer; sigma in right, forward, up, or one number for all three."""

    columns: layouts.BodyVelocityColumns | None = None
    units: layouts.BodyVelocityUnits = layouts.BodyVelocityUnits()
    lever_arm: Vector = (0.0, 0.0, 0.0)
    sigma: VelocitySigmas | None = None


class HeadingSource(Source):
    """A second antenna, a compass."""

    columns: layouts.HeadingColumns | None = None
    units: layouts.HeadingUnits = layouts.HeadingUnits()
    sigma: AngleSigma | None = None


class HeightSource(Source):
    """A barometer, a depth gauge."""

    columns: layouts.HeightColumns | None = None
    units: layouts.HeightUnits = layouts.HeightUnits()
    sigma: LengthSigma | None = None


class ReferenceSource(Source):
    """Somebody else's solution."""

    columns: layouts.ReferenceColumns | None = None
    units: layouts.ReferenceUnits = layouts.ReferenceUnits()


class Description(_Said):
    """A recording as its file describes it."""

    name: Text = ""
    imu: ImuSource
    accelerometer: AccelerometerSource | None = None
    gnss: GnssSource | None = None
    body_velocity: BodyVelocitySource | None = None
    heading: HeadingSource | None = None
    height: HeightSource | None = None
    reference: ReferenceSource | None = None


def describe(path: Path) -> Description:
    """Content of a description file.

    Raises
    ------
    InputError
        If it has an entry that there is not, or a value that is none.
    """
    try:
        return Description.model_validate(toml.read(path))
    except ValidationError as error:
        raise InputError("\n".join(_sentence(path, e) for e in error.errors())) from None


def _sentence(path: Path, error: Any) -> str:
    where = ".".join(str(part) for part in error["loc"])
    if error["type"] == "missing" and isinstance(error["loc"][-1], int):
        where, _, count = where.rpartition(".")
        return f"{path}: {where}: there must be more numbers than {count}"
    cause = error.get("ctx", {}).get("error")
    if error["type"] == "extra_forbidden":
        *table, entry = error["loc"]
        reason = f"there is no such entry{did_you_mean(str(entry), _entries(table))}"
    else:
        reason = str(cause) if cause else f"{error['msg'][0].lower()}{error['msg'][1:]}"
    return f"{path}: {where}: {reason}"


def _entries(table: list[str | int]) -> list[str]:
    """Names of the entries that a table of a description may have."""
    model: type[BaseModel] = Description
    for key in table:
        kinds = model.model_fields[str(key)].annotation
        model = next(kind for kind in (kinds, *get_args(kinds)) if isinstance(kind, type))
    return list(model.model_fields)
