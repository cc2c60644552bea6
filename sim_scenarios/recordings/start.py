"""From where a filter sets out on a recording: attitude, velocity and position of its beginning.

Roll and pitch come from levelling: the mean specific force f of the last seconds before the start, body axes,
is the acceleration a and gravity, of which the latter points up. With r, s, t = right, forward and up of
a + g in axes turned by the heading alone,

    f_forward = s cos(pitch) + t sin(pitch),
    (f_right, f_up) = (r, t cos(pitch) - s sin(pitch)) turned by the roll.

A vehicle that is taken to stand has a = 0; one that starts on its course accelerates as its fixes say.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.attitude import dcm
from sim_scenarios.earth import displaced
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Number
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.feed import SAME_MOMENT, before_first
from sim_scenarios.recordings.fixes import velocities
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording
from sim_scenarios.units import DEGREE, STANDARD_GRAVITY

Array = NDArray[np.float64]

UNKNOWN: Final = np.pi / np.sqrt(3)
"""Sigma of a heading of which nothing is known: uniform on the circle [rad]."""
ROUGH: Final = 10.0 * DEGREE
"""Sigma of a heading that somebody told without its sigma [rad]."""
TILT_ON_COURSE: Final = 3.0 * DEGREE
"""Sigma of roll and pitch levelled while the vehicle accelerates [rad]."""
WAIT: Final = 5.0
"""Time after the first sample until which the first fix still tells where that was [s]."""


@dataclass(frozen=True)
class Start:
    """What is known at the start.

    Attributes
    ----------
    heading : float or None
        [rad]; None: that of the recording's first heading aid, else unknown.
    heading_sigma : float or None
        [rad]; None: 10 deg of a heading that is told or a course, else that of the aid, or of no knowledge.
    levelling : float
        Seconds whose mean specific force gives roll and pitch: the first ones, or the last before a fix to
        start at.
    position : tuple of float or None
        Latitude [deg], longitude [deg], height [m] of the IMU; None: where the first fix has it, and the
        start is at that fix if it comes more than 5 s after the first sample.
    course_above : float or None
        Start at the first fix whose horizontal speed is at least this [m/s], with its course for heading.
    """

    heading: float | None = None
    heading_sigma: float | None = None
    levelling: float = 1.0
    position: tuple[float, float, float] | None = None
    course_above: float | None = None

    def __post_init__(self) -> None:
        """Refuse what is no quantity."""
        for name, value in vars(self).items():
            if value is not None and not np.isfinite(value).all():
                raise InputError(f"{name} = {value}: must be finite")
        if self.heading_sigma is not None and self.heading_sigma < 0:
            raise InputError(f"heading_sigma = {self.heading_sigma:g} rad: must be at least 0")
        if self.course_above is not None and self.course_above <= 0:
            raise InputError(f"course_above = {self.course_above:g} m/s: must be greater than 0")
        if self.course_above is not None and self.heading is not None:
            raise InputError("a heading is told, and to be taken from the course: only one can be")


@dataclass(frozen=True)
class Beginning:
    """Where the filter begins.

    Attributes
    ----------
    time : float
        [s]
    knows_heading : bool
        Whether anything is known of the heading.
    values : dict of str to float
        Parameters `initial.*` and `prior.*` of a filter by scalar name, without what is not known.
    words : str
        How it starts, for a reader.
    """

    time: float
    knows_heading: bool
    values: dict[str, Number]
    words: str


def beginning(recording: Recording, start: Start) -> Beginning:
    """Beginning of a filter on a recording.

    Raises
    ------
    InputError
        When no fix is as fast as the course needs, or levelling covers no sample with a force.
    """
    if start.course_above is not None:
        return _on_course(recording, start, start.course_above)
    imu, gnss = recording.imu, recording.gnss
    time = before_first(imu)
    levelled_from, waited = time, ""
    first = _first_fix(gnss, time)
    if start.position is None and time + WAIT < first < imu.time[-1]:
        time = _sample_at(imu, first)
        levelled_from = max(levelled_from, time - start.levelling)
        waited = f", at {time:.10g} s, where the first fix is"
    roll, pitch = level(_mean_force(recording, levelled_from, start.levelling))
    heading, sigma, words = _heading(recording, start, time)
    angles = roll, pitch, heading
    if gnss is None or not len(gnss.time):
        velocity, antenna = np.zeros(3), np.full(3, np.nan)
    else:
        since = gnss.time >= time - SAME_MOMENT
        velocity, antenna = (_first_finite(values[since]) for values in (gnss.velocity, gnss.position))
    values: dict[str, Number] = {**_values(angles, velocity, start.position, antenna, recording)}
    return Beginning(time, sigma < UNKNOWN, {**values, "prior.heading_sigma": sigma}, words + waited)


def level(force: Array, acceleration: Array | None = None) -> tuple[float, float]:
    """Roll and pitch [rad] at which a specific force in body axes is that of a vehicle on Earth.

    Parameters
    ----------
    force : ndarray, shape (3,)
        Right, forward, up [m/s2].
    acceleration : ndarray, shape (3,), optional
        Right, forward, up, in axes turned by the heading alone [m/s2]; none of a vehicle that stands.

    Returns
    -------
    tuple of float
    """
    x, y, z = force
    if acceleration is None:
        return float(np.arctan2(-x, z)), float(np.arctan2(y, np.hypot(x, z)))
    right, forward, up = acceleration + np.array([0.0, 0.0, STANDARD_GRAVITY])
    pitch = np.arcsin(np.clip(y / np.hypot(forward, up), -1, 1)) - np.arctan2(forward, up)
    rest = up * np.cos(pitch) - forward * np.sin(pitch)
    return float(np.arctan2(right, rest) - np.arctan2(x, z)), float(pitch)


def _on_course(recording: Recording, start: Start, limit: float) -> Beginning:
    gnss, stamp = recording.gnss, recording.imu.time
    if gnss is None:
        raise InputError(f"{recording.name}: has no fixes, and so no course to start on")
    velocity = velocities(gnss)
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    earliest = before_first(recording.imu) + start.levelling
    placed = np.isfinite(gnss.position).all(axis=1) & (gnss.time >= earliest) & (gnss.time < stamp[-1])
    fast = np.flatnonzero(placed & (speed >= limit))
    if len(fast) == 0:
        raise InputError(
            f"{recording.name}: no fix of the IMU's time is as fast as {limit:g} m/s; the fastest has "
            f"{np.max(speed[placed], initial=0.0):.3g} m/s"
        )
    fix = int(fast[0])
    time = _sample_at(recording.imu, float(gnss.time[fix]))
    heading = float(np.arctan2(velocity[fix, 0], velocity[fix, 1]))
    known = np.isfinite(velocity).all(axis=1)
    at = np.array([time - start.levelling, time])
    before, now = (np.array([np.interp(t, gnss.time[known], v) for v in velocity[known].T]) for t in at)
    acceleration = dcm(0.0, 0.0, heading).T @ ((now - before) / start.levelling)
    force = _mean_force(recording, time - start.levelling, start.levelling)
    angles = (*level(force, acceleration), heading)
    values = _values(angles, velocity[fix], start.position, gnss.position[fix], recording)
    sigma = ROUGH if start.heading_sigma is None else start.heading_sigma
    priors: dict[str, Number] = {"prior.heading_sigma": sigma, "prior.tilt_sigma": TILT_ON_COURSE}
    words = (
        f"started at {time:.10g} s on the course of {heading / DEGREE % 360:.4g} deg at {speed[fix]:.3g} m/s"
    )
    return Beginning(time, True, {**values, **priors}, words)


def _sample_at(imu: ImuTable, time: float) -> float:
    """Stamp of the last sample until a time; of the first if there is none [s]."""
    row = int(np.searchsorted(imu.time, time + SAME_MOMENT, side="right")) - 1
    return float(imu.time[max(row, 0)])


def _first_fix(gnss: FixTable | None, since: float) -> float:
    """Time of the first fix with a position, or with a velocity where none has one [s]; else infinite."""
    if gnss is None:
        return np.inf
    later = gnss.time >= since - SAME_MOMENT
    for values in (gnss.position, gnss.velocity):
        known = np.flatnonzero(later & np.isfinite(values).any(axis=1))
        if len(known):
            return float(gnss.time[known[0]])
    return np.inf


def _heading(recording: Recording, start: Start, time: float) -> tuple[float, float, str]:
    """Heading and sigma at the start [rad], and a sentence."""
    compass = recording.heading_aid
    if start.heading is not None:
        sigma = ROUGH if start.heading_sigma is None else start.heading_sigma
        return start.heading, sigma, f"started at a heading of {start.heading / DEGREE:.6g} deg"
    if compass is not None and len(compass.time):
        row = min(int(np.searchsorted(compass.time, time - SAME_MOMENT)), len(compass.time) - 1)
        told = float(compass.sigma[row]) or ROUGH
        heading, sigma = (
            float(compass.heading[row]),
            told if start.heading_sigma is None else start.heading_sigma,
        )
        return heading, sigma, f"started at the heading of its aid, {heading / DEGREE:.6g} deg"
    return 0.0, UNKNOWN, "started without a heading"


def _mean_force(recording: Recording, begin: float, span: float) -> Array:
    """Mean specific force of a span of time [m/s2]."""
    imu = recording.imu
    period = stamps.period(imu.time)
    inside = (imu.time > begin + period / 2) & (imu.time < begin + span + period / 2)
    if span <= 0 or not inside.any():
        raise InputError(f"levelling = {span:g} s: must cover at least one sample ({period:g} s)")
    increments = imu.delta_velocity[inside]
    known = np.isfinite(increments).all(axis=1)
    if not known.any():
        raise InputError(
            f"levelling = {span:g} s: no sample from {begin:.10g} s to {begin + span:.10g} s has a delta "
            "velocity"
        )
    mean: Array = np.mean(increments[known], axis=0) / period
    return mean


def _first_finite(values: Array) -> Array:
    """The first number of each column; not a number of one without."""
    return np.array([next(iter(column[np.isfinite(column)]), np.nan) for column in values.T])


def _values(
    angles: tuple[float, float, float],
    velocity: Array,
    place: tuple[float, float, float] | None,
    antenna: Array,
    recording: Recording,
) -> dict[str, Number]:
    """Parameters of the start; the IMU is where the antenna is not. A velocity that is not known is zero."""
    if place is not None:
        position = np.array(place) * [DEGREE, DEGREE, 1.0]
    else:
        position = displaced(antenna, -(dcm(*angles) @ np.array(recording.lever_arms.gnss)))
    places = zip(("initial.latitude", "initial.longitude", "initial.height"), position.tolist(), strict=True)
    return {
        **dict(zip(("initial.roll", "initial.pitch", "initial.heading"), angles, strict=True)),
        **{f"initial.velocity[{i}]": float(v) for i, v in enumerate(np.nan_to_num(velocity), start=1)},
        **{name: value for name, value in places if np.isfinite(value)},
    }
