"""Pictures of a campaign for papers: one figure a case, as PNG and SVG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter

from sim_scenarios.plots import style
from sim_scenarios.studies import table
from sim_scenarios.studies.quantities import ERRORS
from sim_scenarios.studies.statistics import CaseSummary, Course


def draw(case: CaseSummary, path: Path) -> list[Path]:
    """Draw a case into files of a path without its ending; the same case gives the same files."""
    with (
        mpl.rc_context({"svg.hashsalt": case.label}),
        style.figure(rows=2, columns=2, height=7.5) as (figure, axes),
    ):
        figure.suptitle(case.label, x=0.01, ha="left")
        error, runs, nees, nis = axes
        _errors(case, error)
        _runs(case, runs)
        _consistency(case, {k: f.nees_course for k, f in case.filters.items()}, nees, "heading NEES")
        _consistency(case, {k: f.nis_course for k, f in case.filters.items()}, nis, "NIS / channels")
        for panel in (error, nees, nis):
            _make_logarithmic(panel)
        figure.set_layout_engine("constrained")  # which alone makes room for a legend outside
        figure.legend(loc="outside lower center", ncols=3)
        files = [path.with_name(f"{path.name}.{kind}") for kind in ("png", "svg")]
        for file in files:
            about = {"Date": None} if file.suffix == ".svg" else None
            figure.savefig(file, dpi=150, metadata=about)
            figure.set_layout_engine("none")  # the second file has the layout of the first
    return files


def _make_logarithmic(axes: Axes) -> None:
    """Logarithmic vertical axis with plain numbers, where there is anything to show on it."""
    if not np.isfinite(axes.dataLim.minposy):
        return
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def _errors(case: CaseSummary, axes: Axes) -> None:
    unit = table.unit_of(case)
    for label, colour, dashes in style.lines(case.filters):
        course = case.filters[label].errors[case.counting]
        axes.plot(case.time, course.middle / unit.size, dashes, color=colour, lw=1.4, label=label)
    bound = case.bounds[case.counting]
    if np.isfinite(bound).any():
        axes.plot(case.time, bound / unit.size, color=style.INK, lw=1.0, label="bound")
    axes.set_title(f"{ERRORS[case.counting].title} error: RMS over runs")
    axes.set_ylabel(unit.name)
    axes.set_xlabel("time [s]")


def _runs(case: CaseSummary, axes: Axes) -> None:
    unit = table.unit_of(case)
    for label, colour, dashes in style.lines(case.filters):
        each = np.sort(case.filters[label].each) / unit.size
        share = np.arange(1, len(each) + 1) / case.filters[label].runs  # those that stopped have no RMSE
        axes.step(each, 100 * share, dashes, where="post", color=colour, lw=1.4)
    axes.set_title("Runs with at most this RMSE")
    axes.set_ylabel("%")
    axes.set_xlabel(unit.name)


def _consistency(case: CaseSummary, courses: dict[str, Course], axes: Axes, title: str) -> None:
    for label, colour, dashes in style.lines(courses):
        course = courses[label]
        axes.plot(case.time, course.middle, dashes, color=colour, lw=1.0)
    held = bands(list(courses.values()))
    for band in held:
        axes.fill_between(case.time, band.lower, band.upper, color=style.INK, alpha=0.14, lw=0)
    name = "bands" if len(held) > 1 else "band"
    axes.set_title(f"Mean {title}; {name}: 95 % of a consistent filter")
    axes.set_xlabel("time [s]")


def bands(courses: Sequence[Course]) -> list[Course]:
    """Courses that differ in what a consistent filter keeps to: those of more channels are narrower."""
    found: list[Course] = []
    for course in courses:
        if not any(
            np.array_equal(course.lower, other.lower, equal_nan=True)
            and np.array_equal(course.upper, other.upper, equal_nan=True)
            for other in found
        ):
            found.append(course)
    return found
