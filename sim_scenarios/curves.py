"""Curves of a run that its page draws so that a reader can zoom into them and read values off.

A panel is one of the pictures that can be chosen: a title, what is along its axes, and curves with x and y,
perhaps with a band between `lower` and `upper`, and perhaps the range of y that is seen at first. Curves are
thinned; the data set beside the page has all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.earth import displacement
from sim_scenarios.html import numbers
from sim_scenarios.metrics.statistics import is_measured
from sim_scenarios.plots.navigation import magnitudes
from sim_scenarios.plots.states import panels
from sim_scenarios.recordings import track
from sim_scenarios.recordings.smoothing import is_smoothed, solution
from sim_scenarios.units import ARCMIN, DEGREE

Array = NDArray[np.float64]
Panel = dict[str, Any]

MOST_POINTS: Final = 2000
"""Points of a curve."""
MOST_NUMBERS: Final = 250_000
"""Numbers of a page, for which the curves of many panels have fewer points."""
TIME: Final = "time [s]"


def of_run(run: xr.Dataset) -> list[Panel]:
    """Heading error with the bound, errors of every state, and the NIS of the fixes."""
    if run.sizes["time"] == 0:
        return []  # an alignment that never handed over
    return _thinned(lambda points: [_heading_error(run, points), *_states(run, points), *_nis(run, points)])


def of_replay(run: xr.Dataset) -> list[Panel]:
    """Heading, estimates of every state or their errors against a reference, track, and the NIS."""
    if run.sizes["time"] == 0:
        return []
    return _thinned(
        lambda points: [
            _heading(run, points),
            *_track(run, points),
            *_states(run, points),
            *_nis(run, points),
        ]
    )


def of_comparison(runs: xr.Dataset) -> list[Panel]:
    """Heading errors of each filter, and magnitudes of the others that all of them have."""
    if runs.sizes["time"] == 0:
        return []
    each = {str(label): runs.sel(filter=label) for label in runs["filter"].values}

    def made(points: int) -> list[Panel]:
        thin = _every(len(runs["time"]), points)
        time = numbers(runs["time"].values[thin])
        headings = [
            _curve(label, time, wrap(run["heading_error"].values)[thin] / ARCMIN)
            for label, run in each.items()
        ]
        found = [_settling("heading error", "arcmin", headings)]
        if "position_error" not in runs:
            return found
        courses: dict[str, list[Panel]] = {}
        for label, run in each.items():
            for title, error, _ in magnitudes(run):
                courses.setdefault(title, []).append(_curve(label, time, error[thin]))
        for title, curves in courses.items():
            name, _, unit = title.rstrip("]").partition(" [")
            found.append(_settling(f"magnitude of the {name} error", unit, curves))
        return found

    return _thinned(made)


def of_replays(runs: Mapping[str, xr.Dataset]) -> list[Panel]:
    """Heading of each filter on a recording, and its sigma."""

    def made(points: int) -> list[Panel]:
        headings, sigmas = [], []
        for label, run in runs.items():
            thin = _every(run.sizes["time"], points)
            time = numbers(run["time"].values[thin])
            headings.append(_curve(label, time, _continuous(run)[thin]))
            sigmas.append(_curve(label, time, run["heading_sigma"].values[thin] / DEGREE))
        return [
            _settling("heading", "deg", headings),
            _settling("1 sigma of the heading", "deg", sigmas),
        ]

    return _thinned(made)


def _thinned(made: Callable[[int], list[Panel]]) -> list[Panel]:
    """Panels of as many points a curve as a page may have."""
    found = made(MOST_POINTS)
    count = _count(found)
    return found if count <= MOST_NUMBERS else made(MOST_POINTS * MOST_NUMBERS // count)


def _count(found: list[Panel]) -> int:
    curves = (one for panel in found for one in panel["curves"])
    return sum(len(values) for one in curves for values in one.values() if isinstance(values, list))


def _every(length: int, points: int) -> slice:
    return slice(None, None, max(1, -(-length // points)))


def _panel(title: str, x: str, y: str, curves: list[dict[str, Any]], **more: object) -> Panel:
    return {"title": f"{title[0].upper()}{title[1:]}", "x": x, "y": y, "curves": curves, **more}


def _settling(title: str, y: str, curves: list[dict[str, Any]]) -> Panel:
    """Panel over time that shows at first what is reached from a fifth of the time on.

    An alignment begins with errors a hundred times as large as those that it is about.
    """
    late = []
    for one in curves:
        time = np.array(one["x"], dtype=float)
        settled = time >= time[0] + 0.2 * (time[-1] - time[0])
        late += [np.array(one[name], dtype=float)[settled] for name in ("y", "lower", "upper") if name in one]
    reached = np.concatenate(late)
    reached = reached[np.isfinite(reached)]
    if len(reached) == 0:
        return _panel(title, TIME, y, curves)
    low, high = reached.min(), reached.max()
    room = 0.05 * (high - low) or 1.0
    return _panel(title, TIME, y, curves, range=numbers(np.array([low - room, high + room])))


def _curve(name: str, x: list[float | None], y: Array, reach: Array | None = None) -> dict[str, Any]:
    """A curve, perhaps with a band round it."""
    curve: dict[str, Any] = {"name": name, "x": x, "y": numbers(y)}
    return curve if reach is None else curve | _band(y, reach)


def _band(middle: Array, reach: Array) -> dict[str, Any]:
    return {"lower": numbers(middle - reach), "upper": numbers(middle + reach)}


def _heading_error(run: xr.Dataset, points: int) -> Panel:
    thin = _every(run.sizes["time"], points)
    time, error = numbers(run["time"].values[thin]), wrap(run["heading_error"].values[thin]) / ARCMIN
    curve = _curve("heading error", time, error)
    if "heading_sigma" in run:
        curve |= _band(np.zeros_like(error), 3 * run["heading_sigma"].values[thin] / ARCMIN)
    curves = [curve]
    if "bound.heading_sigma" in run:
        of_bound = _every(run.sizes["bound_time"], points)
        bound = run["bound.heading_sigma"].values[of_bound] / ARCMIN
        when = numbers(run["bound_time"].values[of_bound])
        curves.append(_curve("Cramer-Rao bound, 1 sigma", when, bound))
    return _settling("heading error, with 3 sigma of the filter", "arcmin", curves)


def _heading(run: xr.Dataset, points: int) -> Panel:
    thin = _every(run.sizes["time"], points)
    time = numbers(run["time"].values[thin])
    curves = [
        _curve(name, time, _continuous(one)[thin], 3 * one["heading_sigma"].values[thin] / DEGREE)
        for name, one in _ways(run, "heading").items()
    ]
    return _settling("heading, with 3 sigma", "deg", curves)


def _ways(run: xr.Dataset, name: str) -> dict[str, xr.Dataset]:
    """A run by the name of its curve, and its smoothed navigation if it has one."""
    return {name: run, **({"smoothed": solution(run)} if is_smoothed(run) else {})}


def _continuous(run: xr.Dataset) -> Array:
    """Heading without leaps of a turn [deg]."""
    heading: Array = np.unwrap(run["nav.heading"].values) / DEGREE
    return heading


def _states(run: xr.Dataset, points: int) -> Iterator[Panel]:
    """Each state with 3 sigma: its error where the truth is known, else its estimate."""
    known = "attitude_error" in run
    thin = _every(run.sizes["time"], points)
    time = numbers(run["time"].values[thin])
    shown: dict[str, list[dict[str, Any]]] = {}
    for way, one in _ways(run, "").items():
        for title, values, sigma in panels(one, known):
            each, reach = values[thin], 3 * sigma[thin]
            curve = _curve(way or title.partition(" [")[0], time, each)
            shown.setdefault(title, []).append(curve | _band(np.zeros_like(each) if known else each, reach))
    for title, curves in shown.items():
        name, _, unit = title.rstrip("]").partition(" [")
        yield _settling(f"{name}: {'error' if known else 'estimate'} with 3 sigma", unit, curves)


def _nis(run: xr.Dataset, points: int) -> Iterator[Panel]:
    if "nis" not in run or run.sizes["fix"] == 0:
        return
    thin = _every(run.sizes["fix"], points)
    channels = is_measured(run).sum(axis=1)[thin]
    with np.errstate(divide="ignore", invalid="ignore"):
        each = np.where(channels > 0, run["nis"].values[thin] / channels, np.nan)
    curve = _curve("NIS / channels", numbers(run["fix_time"].values[thin]), each)
    yield _panel("NIS / channels of each fix", TIME, "", [curve], logarithmic=True)


def _track(run: xr.Dataset, points: int) -> Iterator[Panel]:
    """Where the filter was, and the fixes, east and north of the first place."""
    going = run.isel(time=run["time"].values >= track.navigates_from(run))
    if going.sizes["time"] == 0:
        return
    places = {name: track.positions(way) for name, way in _ways(going, "filter").items()}
    if "receiver.position" in run:
        fixes = run["receiver.position"].values
        places["fixes"] = fixes[np.isfinite(fixes).all(axis=1)]
    origin = places["filter"][0]
    curves = []
    for name, place in places.items():
        shown = place[_every(len(place), points)]
        east, north, _ = displacement(shown, np.broadcast_to(origin, shown.shape)).T
        curves.append(_curve(name, numbers(east), north))
    yield _panel("track", "east [m]", "north [m]", curves, equal=True)
