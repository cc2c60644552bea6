"""Several filters on one recording, and what they were worth beside each other."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sim_scenarios.cosimulation import Progress, part_of
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import rms
from sim_scenarios.metrics.status import status_at_end
from sim_scenarios.metrics.verdict import cell
from sim_scenarios.recordings import comparison, outages
from sim_scenarios.recordings.description import load
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.tables import Recording
from sim_scenarios.units import DEGREE


def replays(
    recording: Recording | str | Path,
    filters: Mapping[str, Mapping[str, object]],
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    progress: Progress = lambda _: None,
    fmus: Fmus | None = None,
    **conditions: Any,
) -> dict[str, xr.Dataset]:
    """Replay one recording through several filters.

    Parameters
    ----------
    recording, set, progress, fmus
        As for `replay`; `set` is for all filters.
    filters : mapping
        Parameters of each, by label; none may be set for all as well.
    **conditions : object
        What else `replay` takes: `start`, `filter`, `outages`, `reference` ...

    Returns
    -------
    dict of str to Dataset
        As of `replay`, by label.

    Raises
    ------
    InputError
        When the recording lacks what is needed, or a setting is wrong; of a filter with its label.
    """
    for label, own in filters.items():
        if twice := [name for name in own if name in (set or {})]:
            raise InputError(f"the setting {twice[0]}: is for all filters, and {label} has one of its own")
    fmus = fmus or Fmus()
    if not isinstance(recording, Recording):
        recording = load(Path(recording))
    runs = {}
    for done, (label, own) in enumerate(filters.items()):
        try:
            runs[label] = replay(
                recording,
                set={**(set or {}), **own},
                progress=part_of(progress, done, len(filters)),
                fmus=fmus,
                **conditions,
            )
        except InputError as error:  # noqa: PERF203
            raise InputError(f"{label}: {error}") from None
    return runs


def table(runs: Mapping[str, xr.Dataset]) -> list[list[str]]:
    """Rows of the filters by label, the heading first; without the columns of which none has a figure."""
    rows = {label: _row(run) for label, run in runs.items()}
    columns = [name for name in next(iter(rows.values())) if any(row[name] != "-" for row in rows.values())]
    return [["Filter", *columns], *([label, *(row[name] for name in columns)] for label, row in rows.items())]


def together(runs: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """The first of the filters, with the settings and the messages of all, each message once."""
    settings = {
        f"{label}, {part}": told
        for label, run in runs.items()
        for part, told in json.loads(run.attrs["settings"]).items()
    }
    messages = dict.fromkeys(line for run in runs.values() for line in json.loads(run.attrs["messages"]))
    first: xr.Dataset = next(iter(runs.values()))
    told: xr.Dataset = first.assign_attrs(settings=json.dumps(settings), messages=json.dumps(list(messages)))
    return told


def _row(run: xr.Dataset) -> dict[str, str]:
    """Figures of one filter, all of them in every row."""
    fixes, referred = comparison.against_fixes(run), comparison.against_reference(run)
    in_outages = outages.figures(outages.ends(run))
    used = run["fix_used"].values
    of_reference = {
        "horiz.\n[m]": ("horizontal", 1.0),
        "vert.\n[m]": ("vertical", 1.0),
        "veloc.\n[m/s]": ("velocity", 1.0),
        "tilt\n[deg]": ("tilt", DEGREE),
        "head.\n[deg]": ("heading", DEGREE),
        "NEES /\nstates": ("nees", 1.0),
    }
    return {
        "status at\nthe end": status_at_end(run),
        "heading\n[deg]": cell(float(run["nav.heading"][-1]) / DEGREE, 3),
        "1 sigma\n[deg]": cell(float(run["heading_sigma"][-1]) / DEGREE, 3),
        **{
            title: "-" if referred is None else cell(getattr(referred, name) / unit, 3)
            for title, (name, unit) in of_reference.items()
        },
        "1 sigma,\nhoriz. [m]": cell(_horizontal_sigma(run), 3),
        "before fix,\nhoriz. [m]": cell(fixes.horizontal, 3),
        "vert.\nof it [m]": cell(fixes.vertical, 3),
        "st. dev. of head.\n- course [deg]": cell(fixes.heading_deviation / DEGREE, 2),
        "> 3 sigma\nwhile sure": f"{fixes.wrongly} / {fixes.sure}" if fixes.sure else "-",
        **{
            title: "-" if in_outages[name] is None else f"{in_outages[name]:.2f}"
            for title, name in (
                ("ends of\noutages [m]", "horizontal_rms_m"),
                ("largest\nin them [m]", "largest_m"),
            )
        },
        "fixes\nnot used": f"{int((~used).sum())} / {len(used)}" if len(used) else "-",
    }


def _horizontal_sigma(run: xr.Dataset) -> float:
    """Of the position, both components together, RMS since the evaluation starts [m]; NaN without any."""
    part = comparison.evaluated(run)
    if "position_sigma" not in part or part.sizes["time"] == 0:
        return np.nan
    return rms(np.linalg.norm(part["position_sigma"].values[:, :2], axis=1))
