"""Whether a recording contradicts physics: what is certain is refused, what is likely is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import ahead, forces, tracks, turns
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording, finite
from sim_scenarios.recordings.turns import Turns

SURE: Final = 0.8
"""Correlation from which on turns are compared at all."""
DEGREES: Final = (1 / 75, 1 / 43)
"""Slopes of angles in degrees that were read as radians: 1 / 57.3 within a third."""
RADIANS: Final = (43.0, 75.0)
RIGHT: Final = (0.75, 1.33)
AHEAD: Final = 0.7
"""Least share of the way ahead that is forward."""
SMALLEST: Final = 0.06  # rad; what a latitude and a longitude in radians are as degrees, at most
LATE: Final = 0.5  # s; receivers that stamp late are late by less
LEAP_SECONDS: Final = 18.0


def refuse(recording: Recording, path: Path) -> None:
    """Refuse what is certainly wrong.

    Raises
    ------
    InputError
        With the cause: increments of no IMU on Earth, a mean force that points down, angles in degrees,
        turns against the course, stamps that are seconds apart, latitudes beyond the poles, positions that
        do not move as the velocities say.
    """
    gnss = recording.gnss
    if gnss is not None and (np.abs(gnss.position[:, 0]) > np.pi / 2).any():
        raise InputError(
            f"{path}: gnss: latitudes must be between -90 and 90 deg; they are in other units, or longitudes "
            "are in their place"
        )
    if causes := _certain(_finite(recording)):
        raise InputError(f"{path}: {causes[0]}")


def doubts(recording: Recording) -> list[str]:
    """What was left out when it was read, and what is likely wrong, a sentence each.

    Parameters
    ----------
    recording : Recording
        As `load` gave it.

    Returns
    -------
    list of str
    """
    said = list(recording.remarks)
    recording = _finite(recording)
    up = float(forces.mean_direction(recording.imu)[2])
    if up < forces.UP:
        said.append(
            f"the mean specific force is {_direction(recording.imu)} of its size in right, forward, up: it "
            "points sideways, and on a vehicle that stands upright it points up"
        )
    if recording.gnss is not None:
        said += _doubts_of_fixes(recording.imu, recording.gnss)
    return said


def _finite(recording: Recording) -> Recording:
    """Recording in which infinite values of IMU and fixes are not numbers, as what was not measured."""
    gnss = recording.gnss
    return replace(recording, imu=_numbers(recording.imu), gnss=None if gnss is None else _numbers(gnss))


Table = TypeVar("Table", ImuTable, FixTable)


def _numbers(table: Table) -> Table:
    numbers: dict[str, Any] = {name: finite(values) for name, values in vars(table).items()}
    return replace(table, **numbers)


def _certain(recording: Recording) -> list[str]:
    imu, gnss = recording.imu, recording.gnss
    if wrong := forces.of_unit(imu):
        return [wrong]
    causes = []
    if forces.mean_direction(imu)[2] < forces.DOWN:
        causes.append(
            f"the mean specific force is {_direction(imu)} of its size in right, forward, up: it "
            "points down, and at rest it points up; the axes are others than the sensor's: say "
            "axes = 'forward-right-down' if its third axis points down, 'forward-left-up' if that points up"
        )
    tilts = forces.tilts(imu)
    if tilts.angles > forces.LEAST_TILT and tilts.correlation > 0.5 and _within(tilts.slope, DEGREES):
        causes.append(
            "delta angles seem to be in degrees: the specific force turns "
            f"{1 / tilts.slope:.0f} times less than they say"
        )
    return causes + ([] if gnss is None else _certain_of_fixes(imu, gnss))


def _certain_of_fixes(imu: ImuTable, gnss: FixTable) -> list[str]:
    causes = []
    unexplained, explanations = tracks.explanations(gnss)
    if unexplained > tracks.GOOD and explanations:
        causes.append(
            f"gnss: positions do not move as the velocities say, and they would if {explanations[0].sentence}"
        )
    if tracks.turned_upside_down(gnss):
        causes.append("gnss: heights fall while vertical velocities are positive: these point down")
    found = turns.compare(imu, gnss)
    if found is None or causes or abs(found.correlation) < SURE:
        return causes
    if _late_for_certain(found):
        causes.append(f"gnss: {_late(found.lag)}")
    elif _within(abs(found.slope), DEGREES):
        causes.append(
            f"delta angles seem to be in degrees: the course turns {1 / abs(found.slope):.0f} times less "
            "than they say"
        )
    elif _within(abs(found.slope), RADIANS):
        causes.append(
            f"delta angles seem to be radians read as degrees: the course turns {abs(found.slope):.0f} times "
            "more than they say"
        )
    elif _within(-found.slope, RIGHT):
        causes.append(
            "turn rates are against the course: the axes of the gyros are not those of the accelerometers"
        )
    return causes


def _doubts_of_fixes(imu: ImuTable, gnss: FixTable) -> list[str]:
    said = []
    unexplained, _ = tracks.explanations(gnss)
    if unexplained > tracks.GOOD:
        said.append(
            f"gnss: positions do not move as the velocities say: {np.sqrt(unexplained):.0%} of the way "
            "between fixes is left unexplained"
        )
    elif (np.abs(gnss.position[:, :2]) < SMALLEST).all():
        said.append("gnss: latitude and longitude are below 3.4 deg; are they radians read as degrees?")
    forward = ahead.find(imu, gnss)
    if forward is not None and forward.direction[1] < AHEAD:
        where = ", ".join(f"{share:.2f}" for share in forward.direction)
        said.append(
            f"speed is gained along {where} in right, forward, up, and it should be along forward: are "
            "the axes right?"
        )
    found = turns.compare(imu, gnss)
    if found is None or abs(found.correlation) < SURE:
        return said
    if abs(found.lag) > LATE and _turns_alike(found):
        said.append(f"gnss: {_late(found.lag)}")
    if not turns_alike(found.slope):
        said.append(f"the course turns {found.slope:.2f} times as far as the delta angles say")
    return said


def turns_alike(slope: float) -> bool:
    """Whether the course turns about as far as the IMU."""
    return _within(slope, RIGHT)


def _late_for_certain(found: Turns) -> bool:
    return abs(found.lag) > LATE and abs(found.unmoved) < 0.5 * abs(found.correlation) and _turns_alike(found)


def _turns_alike(found: Turns) -> bool:
    """Whether course and IMU turn as far, or apart by a unit: if not, the course shows another motion.

    So it does on a slow ship that rolls: the antenna on its mast moves as fast as the ship.
    """
    return any(_within(abs(found.slope), limits) for limits in (RIGHT, DEGREES, RADIANS))


def _late(lag: float) -> str:
    leap = (
        " (the leap seconds between GPS time and UTC are 18)" if abs(abs(lag) - LEAP_SECONDS) < LATE else ""
    )
    return (
        f"the course turns {abs(lag):.1f} s {'before' if lag > 0 else 'after'} the IMU by their stamps"
        f"{leap}; they go together with offset = {lag:.1f}"
    )


def _direction(imu: ImuTable) -> str:
    return ", ".join(f"{share:.2f}" for share in forces.mean_direction(imu))


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] < value < limits[1]
