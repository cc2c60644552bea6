"""Pictures of several filters on one recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from sim_scenarios.attitude import wrap
from sim_scenarios.plots.style import figure, lines
from sim_scenarios.recordings import comparison, outages
from sim_scenarios.recordings.track import navigates_from
from sim_scenarios.units import DEGREE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Runs = Mapping[str, xr.Dataset]


def headings(runs: Runs) -> Figure:
    """Heading of each filter since it navigates; below, the sigma that it claims."""
    with figure(rows=2, height=6.6, sharex=True) as (drawn, (heading, sigma)):
        for label, colour, dashes in lines(runs):
            run = runs[label].isel(time=runs[label]["time"].values >= navigates_from(runs[label]))
            angle = np.unwrap(run["nav.heading"].values) / DEGREE
            heading.plot(run["time"], angle, dashes, color=colour, lw=1.3, label=label)
            sigma.plot(run["time"], run["heading_sigma"] / DEGREE, dashes, color=colour, lw=1.3)
        heading.set_ylabel("deg")
        heading.set_title("Heading of each filter, clockwise from north")
        heading.legend(loc="best", ncols=2)
        sigma.set_yscale("log")
        sigma.set_ylabel("1 sigma [deg]")
        sigma.set_xlabel("time [s]")
        return drawn


def before_fixes(runs: Runs) -> Figure:
    """By how much each filter was off horizontally before it took each fix."""
    with figure(rows=1, height=4.2) as (drawn, (axes,)):
        for label, colour, _ in lines(runs):
            run = comparison.evaluated(runs[label])
            off = np.linalg.norm(comparison.missed(run)[:, :2], axis=1)
            axes.plot(run["fix_time"], off, ".", ms=3, color=colour, alpha=0.7, label=label)
        axes.set_yscale("log")
        axes.set_ylabel("m")
        axes.set_xlabel("time [s]")
        axes.set_title("Horizontal innovation of the fixes")
        axes.legend(loc="best", ncols=2)
        return drawn


def outage_ends(runs: Runs) -> Figure:
    """Horizontal error of each filter at the end of each outage."""
    width = 0.8 / len(runs)
    with figure(rows=1, height=4.2) as (drawn, (axes,)):
        for i, (label, colour, _) in enumerate(lines(runs)):
            found = outages.ends(runs[label])
            middle = np.array([end.begin + end.end for end in found]) / 2
            spans = np.array([end.end - end.begin for end in found])
            place = middle + (i + 0.5 - len(runs) / 2) * width * spans
            axes.bar(place, [end.horizontal for end in found], color=colour, width=width * spans, label=label)
        axes.set_ylabel("m")
        axes.set_xlabel("time [s]")
        axes.set_title("Horizontal error at the ends of the outages")
        axes.legend(loc="best", ncols=2)
        return drawn


def errors(runs: Runs) -> Figure:
    """Errors of each filter against the reference, as far as it tells them."""
    with figure(rows=2, height=6.6, sharex=True) as (drawn, (position, heading)):
        for label, colour, dashes in lines(runs):
            run = comparison.compared(runs[label])
            if "position_error" in run:
                off = np.linalg.norm(run["position_error"].values[:, :2], axis=1)
                position.plot(run["time"], off, dashes, color=colour, lw=1.3, label=label)
            if "heading_error" in run:
                off = wrap(run["heading_error"].values) / DEGREE
                heading.plot(run["time"], off, dashes, color=colour, lw=1.3, label=label)
        position.set_ylabel("horizontal [m]")
        position.set_title("Errors of each filter against the reference")
        heading.set_ylabel("heading [deg]")
        heading.set_xlabel("time [s]")
        heading.legend(loc="best", ncols=2)
        return drawn
