"""What a run was worth: one verdict, on the heading of an alignment or on navigation as a whole.

A verdict is made of `figures`, and so is whatever else tells one.
"""

from __future__ import annotations

import xarray as xr

from sim_scenarios.metrics import alignment, navigation
from sim_scenarios.metrics.errors import that_counts
from sim_scenarios.metrics.verdict import Verdict

__all__ = ["Verdict", "judge"]


def judge(run: xr.Dataset) -> Verdict:
    """Verdict on one filter of a run (a data set of `sim_scenarios.run`), by what the filter is for."""
    return navigation.judge(run) if is_navigation(run) else alignment.judge(run)


def is_navigation(run: xr.Dataset) -> bool:
    """Whether the filter of a run is there to navigate, not to align alone."""
    return that_counts(run.attrs) == "horizontal"
