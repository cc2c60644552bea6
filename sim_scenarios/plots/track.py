"""Pictures of where a vehicle went, without a map from elsewhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sim_scenarios.earth import displacement
from sim_scenarios.plots.style import BLUE, GREEN, INK, ORANGE, PURPLE, figure
from sim_scenarios.recordings.comparison import MOVING, heading_minus_course
from sim_scenarios.recordings.outages import End
from sim_scenarios.recordings.smoothing import is_smoothed, solution
from sim_scenarios.recordings.track import navigates_from, positions
from sim_scenarios.units import DEGREE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def track(run: xr.Dataset) -> Figure:
    """Track of the filter and the fixes, east and north of the first one [m]."""
    going = run.isel(time=run["time"].values >= navigates_from(run))
    fixes = run["receiver.position"].values
    placed = np.isfinite(fixes).all(axis=1)
    origin = (fixes[placed] if placed.any() else positions(run))[0]
    with figure(rows=1, height=8.0) as (drawn, (axes,)):
        for withheld, colour, label in ((False, INK, "fixes"), (True, ORANGE, "fixes that were withheld")):
            shown = fixes[placed & (run["receiver.withheld"].values == withheld)]
            if len(shown):
                east, north, _ = displacement(shown, origin).T
                axes.plot(east, north, ".", ms=4, color=colour, alpha=0.6, label=label)
        east, north, _ = displacement(positions(going), origin).T
        axes.plot(east, north, color=BLUE, lw=1.2, label="filter")
        if is_smoothed(run):
            axes.plot(
                *displacement(positions(solution(going)), origin).T[:2],
                color=PURPLE,
                lw=1.2,
                label="smoothed",
            )
        if len(east):
            axes.plot(east[:1], north[:1], "o", color=GREEN, ms=8, label="start")
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("east [m]")
        axes.set_ylabel("north [m]")
        axes.set_title("Track")
        axes.legend(loc="best")
        return drawn


def course(run: xr.Dataset) -> Figure:
    """Heading minus course over ground at the fixes of a vehicle that moves, the speed below."""
    time, off = heading_minus_course(run)
    velocity = run["receiver.velocity"].values
    with figure(rows=2, height=5.6, sharex=True) as (drawn, (difference, speed)):
        difference.plot(time, off / DEGREE, ".", ms=3, color=BLUE)
        difference.axhline(0, color=INK, lw=0.5, alpha=0.5)
        low, high = np.percentile(off / DEGREE, (1, 99))
        difference.set_ylim(low - 2, high + 2)
        difference.set_ylabel("deg")
        difference.set_title(f"Heading minus course over ground, above {MOVING:g} m/s")
        speed.plot(run["receiver_time"], np.hypot(velocity[:, 0], velocity[:, 1]), color=INK, lw=1.0)
        speed.set_ylabel("speed [m/s]")
        speed.set_xlabel("time [s]")
        return drawn


def outage_ends(found: list[End]) -> Figure:
    """Horizontal error at the end of each outage, with what the filter claims."""
    number = np.arange(1, len(found) + 1)
    with figure(rows=1, height=3.6) as (drawn, (axes,)):
        axes.bar(number, [end.horizontal for end in found], color=BLUE, width=0.6, label="horizontal error")
        axes.plot(number, [end.sigma for end in found], "_", color=ORANGE, ms=24, mew=2, label="1 sigma")
        axes.set_xticks(number)
        axes.set_xlabel("outage")
        axes.set_ylabel("m")
        axes.set_title("Error at the ends of the outages")
        axes.legend(loc="best")
        return drawn
