"""Picture of many runs: root mean square errors over time."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.figure import Figure as Drawn

from sim_scenarios.ensemble import FIGURES, Ensemble, Window, rms_over_runs
from sim_scenarios.plots.style import INK, figure, lines


def over_time(runs: Ensemble, name: str, windows: Iterable[Window], title: str) -> Drawn:
    """Root mean square over runs of the error that a figure is made of, for every filter."""
    wanted = FIGURES[name]
    with figure(rows=1, height=4.2) as (drawn, (axes,)):
        for window in sorted(set(windows)):
            axes.axvspan(*window, color=INK, alpha=0.05, lw=0)
        for label, colour, dashes in lines(runs.filters):
            errors = runs.filters[label]
            whole = errors.part(wanted.columns, (float(errors.time[0]), float(errors.time[-1])))
            values = rms_over_runs(whole) / wanted.size
            axes.plot(errors.time, values, dashes, color=colour, lw=1.4, label=label)
        axes.set_yscale("log")
        axes.set_ylabel(f"{wanted.title} [{wanted.unit}]")
        axes.set_xlabel("time [s]")
        axes.set_title(title)
        axes.legend(loc="upper right", ncols=2)
        return drawn
