"""What a filter says of itself at the end of a run, and whether it may then be relied on."""

from __future__ import annotations

from typing import Final

import xarray as xr

FIT: Final = ("aligning", "converged")
"""Status of a filter whose estimate may be relied on; in any other it may not, however small its error.

A filter of somebody else's that has no status is judged by its error alone.
"""


def is_fit(status: str | None) -> bool:
    """Whether the estimate of a filter with a status may be relied on."""
    return status is None or status in FIT


def own_status_at_end(run: xr.Dataset) -> str | None:
    """Name of the status of the filter at the end; None of one that has none."""
    return status_at_end(run) if "status" in run else None


def status_at_end(run: xr.Dataset, name: str = "status") -> str:
    """Name of the status of the filter at the end, or of another variable of that kind."""
    status = run[name]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    return str(names[int(status.values[-1])])
