"""What columns are likely to hold, by their names as loggers write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

_ANGULAR: Final = (
    r"gyro?(scope)?|gyros|g|w|omega|ang(ular)?_?(vel(ocity)?|rate)|rate|rot(ation)?_?rate|body_?rate|"
    r"(delta|d)_?(angle|ang|theta|th|tht)"
)
_FORCE: Final = (
    r"acc?(el|eleration|elerometer)?s?|a|f|specific_?force|sf|lin(ear)?_?acc(el|eleration)?|"
    r"(delta|d)_?v(el|elocity)?"
)
_VELOCITY: Final = r"v(el|elocity)?|speed"
_SIGMA: Final = r"s(d|td|tdv|igma|td_?dev)"
_BEFORE: Final = r"(?:(?:imu|gnss|gps|ins|nav|sensor|raw|body|b|field)\d?_)*"
_AFTER: Final = r"(?:_(?P<unit>\w+))?"
_EAST_NORTH_UP: Final = (r"e(ast)?", r"n(orth)?", r"u(p)?")
_EAST_NORTH_DOWN: Final = (*_EAST_NORTH_UP[:2], r"d(own)?")
_COORDINATES: Final = (r"lon(g|gitude)?", r"lat(itude)?", r"(alt(itude)?|h(eight|gt)?)")
_ABOVE: Final = r"(_above_ellipsoid|_ellipsoidal|_ellipsoid|_hae)?"

_UNITS: Final = {
    "deg/s": ("dps", "degs", "deg_s", "degps", "deg_sec", "d_s"),
    "rad/s": ("rps", "rads", "rad_s", "radps", "rad_sec", "r_s"),
    "deg": ("deg", "degree", "degrees"),
    "rad": ("rad", "radian", "radians"),
    "m/s2": ("ms2", "m_s2", "mps2", "m_s_2", "m_s_s", "mss", "m_ss", "mpss"),
    "mg": ("mg",),
    "g": ("g",),
    "m/s": ("ms", "m_s", "mps", "m_sec"),
    "km/h": ("kmh", "km_h", "kph"),
    "m": ("m",),
    "ms": ("ms", "msec", "millis", "milliseconds"),
    "us": ("us", "usec", "micros", "microseconds"),
    "ns": ("ns", "nsec", "nanos", "nanoseconds"),
    "s": ("s", "sec", "secs", "second", "seconds"),
}
"""Units by the ends of names."""


def unit(name: str, among: Sequence[str]) -> str:
    """Unit that a name ends with, of some; empty where there is none."""
    word = plain(name)
    endings = [
        (ending, symbol)
        for symbol in among
        for ending in _UNITS.get(symbol, ())
        if word.endswith(f"_{ending}")
    ]
    return max(endings, key=lambda found: len(found[0]))[1] if endings else ""


def is_increment(name: str) -> bool:
    """Whether a name is that of a delta angle or a delta velocity."""
    return (
        re.match(rf"{_BEFORE}(delta|d_?(v|th|tht|theta|ang|angle|vel|velocity)(_|$))", plain(name))
        is not None
    )


def plain(name: str) -> str:
    """A name in small letters, digits and underscores alone."""
    spelt = re.sub(r"[°º]", "deg", name).replace("²", "2").replace("^", "")
    spelt = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", spelt)
    return re.sub(r"[^a-z0-9]+", "_", spelt.casefold()).strip("_")


def likely(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Columns by what they are likely to hold.

    Parameters
    ----------
    names : sequence of str
        Names of columns.

    Returns
    -------
    dict
        Of `time`, `angular`, `force`, `position`, `velocity`, `position_sigma`, `velocity_sigma`,
        `attitude`, `heading`, `forward`, `height` those that were found: names of their columns, "" for what
        is missing, a minus in front of what points the other way.
    """
    of_place, of_velocity = _sigmas(names)
    found = {
        "time": _time(names),
        "angular": _triple(names, _ANGULAR, ("x", "y", "z")) or _counted(names, _ANGULAR),
        "force": _triple(names, _FORCE, ("x", "y", "z")) or _counted(names, _FORCE),
        "position": _position(names),
        "velocity": _east_north_up(names, _VELOCITY),
        "position_sigma": of_place,
        "velocity_sigma": of_velocity,
        "attitude": _each(names, r"roll", r"pitch", r"(heading|yaw|hdg|azimuth)")
        or _counted(names, r"(euler|rpy|attitude)(_?(angles?|attitude|rpy))?"),
        "heading": _each(names, r"(heading|hdg|heading_aid|yaw|azimuth)"),
        "forward": _each(
            names, r"(wheel|odo|odometer|dvl|log|v|vel|body)_?(velocity_?|speed_?|vel_?)?(forward|fwd|speed)"
        ),
        "height": _each(
            names, r"(height_aid|baro(meter)?_?(alt(itude)?|height)|pressure_?(alt(itude)?|height))"
        ),
    }
    return {what: columns for what, columns in found.items() if columns}


def incomplete(names: Sequence[str]) -> tuple[str, ...]:
    """Columns that are likely rates or forces along one axis or two, of which another has none."""
    some = (_of_some_axes(names, stem, "xyz") for stem in (_ANGULAR, _FORCE))
    return tuple(name for columns in some if len(columns) < 3 for name in columns)


def _time(names: Sequence[str]) -> tuple[str, ...]:
    words = {name: plain(name) for name in names}
    for pattern in (
        r"time|t|timestamp|stamp",
        r"(time|timestamp|stamp|t)_\w+|\w+_(time|timestamp|stamp)|tow|sow|sod|epoch|seconds|sec|utc|gpst|datetime",
        r"\w*(time|stamp|tow|tov)\w*",
    ):
        for name, word in words.items():
            if re.fullmatch(pattern, word):
                return (name,)
    return ()


def _triple(names: Sequence[str], stem: str, axes: Sequence[str]) -> tuple[str, ...]:
    """Three columns of one stem, one for each axis, which stands behind the stem or in front of it."""
    columns = _of_some_axes(names, stem, axes)
    return columns if len(set(columns)) == len(axes) else ()


def _of_some_axes(names: Sequence[str], stem: str, axes: Sequence[str]) -> tuple[str, ...]:
    columns = []
    for axis in axes:
        behind = rf"{_BEFORE}(?:{stem})_?(?:{axis}){_AFTER}"
        in_front = rf"{_BEFORE}(?:{axis})_?(?:{stem}){_AFTER}"
        fitting = [n for n in names if re.fullmatch(behind, plain(n)) or re.fullmatch(in_front, plain(n))]
        columns += fitting[:1]
    return tuple(columns)


def of_one_sensor(names: Sequence[str], file: str) -> dict[str, tuple[str, ...]]:
    """Columns of a file of one sensor, which are called by their axes alone: the file or a unit says whose.

    Parameters
    ----------
    names : sequence of str
        Names of columns.
    file : str
        Name of the file.

    Returns
    -------
    dict
        Of `angular` or `force` the three columns; empty where nothing says which.
    """
    for what, units, called in (
        ("angular", ("deg/s", "rad/s"), "gyr|ang(ular)?_?(vel|rate)|rotation_?rate"),
        ("force", ("m/s2", "g", "mg"), "acc"),
    ):
        endings = "|".join(ending for unit in units for ending in _UNITS[unit])
        optional = "?" if re.search(called, plain(file)) else ""
        pattern = rf"{_BEFORE}(?P<axis>[xyz])(_?axis)?(_({endings})){optional}"
        found = {m["axis"]: name for name in names if (m := re.fullmatch(pattern, plain(name)))}
        if len(found) == 3:
            return {what: tuple(found[axis] for axis in "xyz")}
    return {}


def _counted(names: Sequence[str], stem: str) -> tuple[str, ...]:
    """Three columns of one stem, with an index from 0 or from 1."""
    for axes in (("0", "1", "2"), ("1", "2", "3")):
        columns = [
            name
            for axis in axes
            for name in [n for n in names if re.fullmatch(rf"{_BEFORE}(?:{stem})_{axis}", plain(n))][:1]
        ]
        if len(columns) == len(axes):
            return tuple(columns)
    return ()


def _each(names: Sequence[str], *patterns: str) -> tuple[str, ...]:
    columns = []
    for pattern in patterns:
        columns += [n for n in names if re.fullmatch(rf"{_BEFORE}{pattern}{_AFTER}", plain(n))][:1]
    return tuple(columns) if len(columns) == len(patterns) else ()


def _position(names: Sequence[str]) -> tuple[str, ...]:
    flat = _each(names, r"lat(itude)?", r"(lon|lng|long|longitude)")
    height = _each(names, rf"(alt|altitude|height|hgt|h|ellipsoidal_height|h_ell|up){_ABOVE}")
    return flat and (*flat, *(height or ("",)))


def _east_north_up(names: Sequence[str], stem: str) -> tuple[str, ...]:
    if up := _triple(names, stem, _EAST_NORTH_UP) or _counted(names, rf"(?:{stem})_?enu"):
        return up
    if down := _triple(names, stem, _EAST_NORTH_DOWN):
        return (*down[:2], f"-{down[2]}")
    if counted := _counted(names, rf"(?:{stem})_?ned"):
        return (counted[1], counted[0], f"-{counted[2]}")
    return ()


def _sigmas(names: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Sigmas of a place and of a velocity: east, north, up.

    Beside those of latitude and longitude, what is along north and east, and no more, is of a velocity.
    """
    of_velocity = rf"{_SIGMA}_?v|{_SIGMA}_?vel(ocity)?|v(el(ocity)?)?_?{_SIGMA}"
    coordinates = _triple(names, _SIGMA, _COORDINATES)
    directions = _unsigned(names, _SIGMA)
    velocity = _unsigned(names, of_velocity)
    return coordinates or directions, velocity or (directions if coordinates else ())


def _unsigned(names: Sequence[str], stem: str) -> tuple[str, ...]:
    return tuple(name.removeprefix("-") for name in _east_north_up(names, stem))
