"""Outages of a receiver made of a recording whose fixes are there: what navigation is off by at their ends.

Each period of `every` seconds ends with an outage of `length` seconds, whose fixes the filter does not get.
They are the truth of the test: at the last of them the filter has navigated without for the whole outage.
A smoother knows what came after it, and is off most somewhere in its middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.metrics.statistics import rms
from sim_scenarios.recordings import track

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outages:
    """One outage of `length` [s] in each period of `every` [s], at its end."""

    length: float
    every: float

    def __post_init__(self) -> None:
        """Refuse outages that leave no fixes between them, or are none."""
        if not 0 < self.length < self.every < np.inf:
            raise InputError(
                f"outages of {self.length:g} s every {self.every:g} s: they must be longer than 0 and "
                "shorter than their period"
            )

    def windows(self, begin: float, end: float) -> Array:
        """Begin and end of each outage within a span of time [s], shape (n, 2).

        Raises
        ------
        InputError
            When the span is shorter than one period.
        """
        ends = begin + self.every * np.arange(1, int((end - begin) / self.every + 1e-9) + 1)
        if len(ends) == 0:
            raise InputError(
                f"outages every {self.every:g} s: the recording must be at least that long; it lasts "
                f"{end - begin:g} s"
            )
        return np.column_stack((ends - self.length, ends))


@dataclass(frozen=True)
class End:
    """Error at the end of an outage, and the largest within it.

    Attributes
    ----------
    begin, end : float
        Of the outage [s].
    time : float
        Of the last fix that was withheld, to which the error belongs [s].
    horizontal, vertical : float
        Antenna of the filter minus fix [m].
    sigma : float
        Horizontal, of the position of the filter, both components together [m].
    largest : float
        Horizontal, at whichever of the fixes that were withheld [m].
    converged : bool
        Whether the filter reported convergence then.
    """

    begin: float
    end: float
    time: float
    horizontal: float
    vertical: float
    sigma: float
    largest: float
    converged: bool


def within(time: Array, windows: Array) -> NDArray[np.bool_]:
    """Whether instants lie in any of the outages, shape (n,); their ends do not."""
    inside = (time[:, None] >= windows[:, 0]) & (time[:, None] < windows[:, 1])
    some: NDArray[np.bool_] = np.any(inside, axis=1)
    return some


def ends(run: xr.Dataset) -> list[End]:
    """Errors at the ends of the outages of a replay; none of those before a hand-over or without a fix."""
    if "outage_begin" not in run:
        return []
    found = []
    time, position = run["receiver_time"].values, run["receiver.position"].values
    placed = np.isfinite(position).all(axis=1) & run["receiver.withheld"].values
    earliest = track.navigates_from(run)
    edges = (run[f"outage_{edge}"].values.tolist() for edge in ("begin", "end"))
    for begin, end in zip(*edges, strict=True):
        rows = np.flatnonzero(placed & (time >= begin) & (time < end))
        if len(rows) == 0 or begin < earliest:
            continue
        off = track.antenna_minus(run, time[rows], position[rows])
        horizontal = np.hypot(off[:, 0], off[:, 1])
        last = float(time[rows[-1]])
        row = int(np.searchsorted(run["time"].values, last, side="right")) - 1
        sigma = run["position_sigma"].values[row]
        found.append(
            End(
                begin=begin,
                end=end,
                time=last,
                horizontal=float(horizontal[-1]),
                vertical=float(abs(off[-1, 2])),
                sigma=float(np.hypot(*sigma[:2])),
                largest=float(horizontal.max()),
                converged=bool(run["converged"].values[row]),
            )
        )
    return found


def table(found: list[End], smoothed: list[End] | None = None) -> list[list[str]]:
    """Rows of the errors, the heading first, their root mean squares last; with those of a smoothed track."""
    columns = {
        "horizontal [m]": [end.horizontal for end in found],
        "vertical [m]": [end.vertical for end in found],
        "1 sigma [m]": [end.sigma for end in found],
    }
    if smoothed:
        columns["largest [m]"] = [end.largest for end in found]
        columns["largest, smoothed [m]"] = [end.largest for end in smoothed]
    rows = [
        [f"{end.begin:.10g}", f"{end.end:.10g}", *(f"{values[i]:.2f}" for values in columns.values())]
        for i, end in enumerate(found)
    ]
    means = [f"{rms(np.array(values)):.2f}" for values in columns.values()]
    return [["outage from [s]", "to [s]", *columns], *rows, ["RMS", "", *means]]


def figures(found: list[End]) -> dict[str, object]:
    """For machines."""
    return {
        "horizontal_rms_m": rms(np.array([e.horizontal for e in found])) if found else None,
        "vertical_rms_m": rms(np.array([e.vertical for e in found])) if found else None,
        "largest_m": max((e.largest for e in found), default=None),
        "each": [
            {
                "begin_s": e.begin,
                "end_s": e.end,
                "horizontal_m": e.horizontal,
                "vertical_m": e.vertical,
                "sigma_m": e.sigma,
                "largest_m": e.largest,
                "converged": e.converged,
            }
            for e in found
        ],
    }
