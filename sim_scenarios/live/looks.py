"""Looks at a run while it goes on: what its filter says, at a pace that eyes can follow.

A run of ten minutes takes a second, so that it is held back: it goes on by a frame at a time and then waits
for the clock on the wall. Nothing that it computes depends on that.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.cosimulation import Progress, Sink, Source
from sim_scenarios.earth import displacement
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Number
from sim_scenarios.instance import Instance
from sim_scenarios.scenario import Scenario
from sim_scenarios.simulation import Watch

Array = NDArray[np.float64]

FRAME: Final = 0.1
"""From one look to the next [s], by the clock on the wall."""
SPAN: Final = 30.0
"""How long a run is watched unless a pace is told [s]."""
WAITING: Final = "waiting"
"""Status of a filter that has nothing to start from yet."""

_SAID: Final = ("nav.heading", "heading_sigma", "status", "nav.latitude", "nav.longitude", "nav.height")
_TRUE: Final = ("truth.heading", "truth.latitude", "truth.longitude", "truth.height")

Place = tuple[float, float]
"""East and north of where the run began [m]."""


@dataclass(frozen=True)
class Look:
    """What the filter of a run says at an instant; not a number, or "", where it says nothing.

    Attributes
    ----------
    time, duration : float
        Since the start of the run, and of all of it [s].
    heading, heading_sigma, true_heading : float
        [rad]
    status : str
    place, true_place : Place
    """

    time: float
    duration: float
    heading: float
    heading_sigma: float
    true_heading: float
    status: str
    place: Place
    true_place: Place

    @property
    def heading_error(self) -> float:
        """Heading minus the true one [rad], from -pi to pi."""
        return math.remainder(self.heading - self.true_heading, 2 * math.pi)


def watch(show: Callable[[Look], None], pace: float | None = None) -> Watch:
    """What holds a run to a pace and shows its first filter.

    Parameters
    ----------
    show : callable
        Called with every look; the first is before the run begins, the last at its end.
    pace : float, optional
        Seconds of the run in one on the wall; without it the whole run takes `SPAN`.

    Raises
    ------
    InputError
        The pace is not a positive number.
    """
    if pace is not None and not 0 < pace < math.inf:
        raise InputError(f"pace = {pace:g}: must be greater than 0 and finite")

    def begun(scenario: Scenario, source: Source, sinks: Sequence[Sink]) -> Progress:
        eye = _Eye(source, sinks[0].instance, scenario.duration)
        speed = pace or scenario.duration / SPAN
        rows = count(1)
        show(eye.look(0.0))
        start = shown = time.monotonic()

        def advance(share: float) -> None:
            nonlocal shown
            instant, now = next(rows) * scenario.recording_period, time.monotonic()
            early = start + instant / speed - now
            if early >= FRAME or now - shown >= FRAME or share >= 1:
                shown = now + max(0.0, early)
                time.sleep(shown - now)
                show(eye.look(instant))

        return advance

    return begun


class _Eye:
    """Sees what a filter says, or the alignment that it still waits for, and the truth."""

    def __init__(self, source: Source, instance: Instance, duration: float) -> None:
        assert source.instance is not None  # the signals of a scenario are those of a plant
        self._plant, self._alignment, self._filter = source.instance, source.alignment, instance
        self._duration = duration
        self._origin = _position(_outputs(self._plant, _TRUE), "truth")

    def look(self, instant: float) -> Look:
        truth, seen = _outputs(self._plant, _TRUE), self._filter
        said = _outputs(seen, _SAID)
        if self._alignment is not None and _status(seen, said) == WAITING:
            seen = self._alignment
            said = _outputs(seen, _SAID)
        return Look(
            instant,
            self._duration,
            float(said.get("nav.heading", math.nan)),
            float(said.get("heading_sigma", math.nan)),
            float(truth["truth.heading"]),
            _status(seen, said),
            self._place(_position(said, "nav")),
            self._place(_position(truth, "truth")),
        )

    def _place(self, position: Array) -> Place:
        east, north, _ = displacement(position, self._origin)
        return float(east), float(north)


def _outputs(instance: Instance, names: Sequence[str]) -> dict[str, Number]:
    """Outputs of these names, those that there are."""
    there = [name for name in names if name in instance.fmu.variables]
    return dict(zip(there, instance.read(there), strict=True))


def _position(values: Mapping[str, Number], of: str) -> Array:
    """Latitude [rad], longitude [rad], height [m], shape (3,)."""
    return np.array([values.get(f"{of}.{name}", np.nan) for name in ("latitude", "longitude", "height")])


def _status(instance: Instance, said: Mapping[str, Number]) -> str:
    return instance.fmu.variables["status"].display(said["status"]) if "status" in said else ""
