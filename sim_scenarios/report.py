"""The report of a run: PNG pictures and one HTML page that needs nothing else.

The page follows the reader's light or dark screen (the pictures are inverted with their hues kept) and is
readable on a telephone.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from sim_scenarios import plots
from sim_scenarios.metrics import Verdict, judge
from sim_scenarios.units import ARCMIN, DEGREE

Array = NDArray[np.float64]
Draw = Callable[[xr.Dataset], Figure]

RUN: Mapping[str, tuple[Draw, str]] = {
    "heading": (
        plots.heading_error,
        "Heading error with the filter's 3 sigma and the Cramer-Rao bound; below, its end in arcminutes.",
    ),
    "states": (
        plots.states,
        "Error of every state with 3 sigma. A consistent filter keeps 99.7 % of each curve inside.",
    ),
    "innovations": (
        plots.innovations,
        "What each fix brought that the filter had not predicted, with 3 sigma; crosses were rejected.",
    ),
    "nis": (
        plots.nis,
        "Normalised innovation squared against its chi-square limits, one by one and in the mean.",
    ),
    "corrections": (
        plots.corrections,
        "Weights that the corrector gave, the gamma of the H-infinity update, rejected fixes, status.",
    ),
}
REPLAY: Mapping[str, tuple[Draw, str]] = {
    "heading": (plots.heading, "Heading with the filter's 3 sigma; below, its end."),
    **{key: RUN[key] for key in ("states", "innovations", "nis", "corrections")},
}
COMPARISON: Mapping[str, tuple[Draw, str]] = {
    "comparison": (plots.comparison, "Heading errors on the same signals; below, their end in arcminutes."),
}
BOUND: Mapping[str, tuple[Draw, str]] = {
    "bound": (plots.bound, "Sigma that no filter can beat in the mean, whatever its algorithm."),
}


@dataclass(frozen=True)
class Picture:
    """A picture and what it shows."""

    name: str
    caption: str
    png: bytes


@dataclass(frozen=True)
class Page:
    """Content of a report.

    Attributes
    ----------
    title, verdict : str
    good : bool or None
        Colours the verdict; None where nothing is judged.
    figures : dict of str to str
        Headline figures: label -> value with unit.
    table : list of list of str
        Rows of a comparison, the first is the heading; empty for none.
    """

    title: str
    verdict: str
    good: bool | None
    figures: Mapping[str, str]
    table: list[list[str]]


def report_run(run: xr.Dataset, folder: Path) -> Path:
    """Report of a run of `sim_scenarios.run`; returns the path of the page."""
    verdict = judge(run)
    page = Page(run.attrs["scenario"], sentence(verdict), verdict.converged, headline(verdict), [])
    return _write(run, RUN, page, folder)


def report_comparison(runs: xr.Dataset, folder: Path) -> Path:
    """Report of a comparison of `sim_scenarios.compare`; returns the path of the page."""
    verdicts = {str(label): judge(runs.sel(filter=label)) for label in runs["filter"].values}
    converged = [label for label, verdict in verdicts.items() if verdict.converged]
    text = f"{len(converged)} of {len(verdicts)} filters converged"
    bound = f"{runs.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin"
    page = Page(runs.attrs["scenario"], text, None, {"Cramer-Rao bound": bound}, comparison_table(verdicts))
    return _write(runs, COMPARISON, page, folder)


def report_bound(data: xr.Dataset, folder: Path) -> Path:
    """Report of the bound of `sim_scenarios.bound`; returns the path of the page."""
    rms = f"{data.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin"
    text = f"No filter knows the heading better than {rms} (RMS over the window)"
    return _write(data, BOUND, Page(data.attrs["scenario"], text, None, {}, bound_table(data)), folder)


def report_replay(run: xr.Dataset, folder: Path) -> Path:
    """Report of a recording of `sim_scenarios.replay`; returns the path of the page."""
    converged = bool(run["converged"].values[-1])
    heading, sigma = float(run["nav.heading"].values[-1]), float(run["heading_sigma"].values[-1])
    figures = {
        "Heading at the end": f"{heading / DEGREE:.3f} deg",
        "3 sigma": f"{3 * sigma / DEGREE:.3f} deg",
        "Rejected fixes": str(int(run["rejected_fixes"].values[-1])),
    }
    text = "The filter reports convergence" if converged else "The filter does not report convergence"
    return _write(
        run,
        REPLAY,
        Page(Path(run.attrs["recording"]).name, text, converged, figures, heading_table(run)),
        folder,
    )


def sentence(verdict: Verdict) -> str:
    """The verdict in a sentence."""
    if verdict.converged:
        since = (
            f", within the limit since {verdict.convergence_time:.0f} s" if verdict.convergence_time else ""
        )
        return f"Converged: heading RMSE {verdict.heading_rmse / ARCMIN:.2f} arcmin{since}"
    end = f"{verdict.heading_end / ARCMIN:+.2f} arcmin at the end"
    return f"Not converged: heading RMSE {verdict.heading_rmse / ARCMIN:.2f} arcmin, {end}"


def headline(verdict: Verdict) -> dict[str, str]:
    """Headline figures of a run."""
    nis = verdict.nis
    claimed = "never" if verdict.claimed_time is None else f"since {verdict.claimed_time:.0f} s"
    return {
        "Heading RMSE": f"{verdict.heading_rmse / ARCMIN:.2f} arcmin",
        "Cramer-Rao bound": f"{verdict.bound / ARCMIN:.2f} arcmin",
        "Filter's own sigma": f"{verdict.heading_sigma / ARCMIN:.2f} arcmin",
        "Filter reports convergence": claimed,
        "Mean NIS / channels": f"{nis.mean:.3f} ({nis.lower:.2f} to {nis.upper:.2f} is consistent)",
        "Fixes used, rejected": f"{verdict.used_fixes}, {verdict.rejected_fixes}",
    }


def comparison_table(verdicts: Mapping[str, Verdict]) -> list[list[str]]:
    """Rows of the comparison of filters, the heading first."""
    rows = [
        [
            "Filter",
            "RMSE [']",
            "/ bound",
            "mean [']",
            "largest [']",
            "own sigma [']",
            "converged",
            "NIS / channels",
            "rejected",
        ]
    ]
    for label, v in verdicts.items():
        since = f"{v.convergence_time:.0f} s" if v.converged and v.convergence_time is not None else "no"
        rows.append(
            [
                label,
                f"{v.heading_rmse / ARCMIN:.2f}",
                f"{v.heading_rmse / v.bound:.2f}",
                f"{v.heading_mean / ARCMIN:+.2f}",
                f"{v.heading_largest / ARCMIN:.2f}",
                f"{v.heading_sigma / ARCMIN:.2f}",
                since,
                f"{v.nis.mean:.2f}",
                str(v.rejected_fixes),
            ]
        )
    return rows


def bound_table(data: xr.Dataset) -> list[list[str]]:
    """Sigma of the heading at round times, the heading of the table first."""
    time, sigma = data["bound_time"].values, data["bound.heading_sigma"].values
    rows = [[f"{round(time[i], 3):g}", f"{sigma[i] / ARCMIN:.2f}"] for i in _at_round_times(time)]
    return [["time [s]", "sigma of the heading [arcmin]"], *rows]


def heading_table(run: xr.Dataset) -> list[list[str]]:
    """Heading at round times, the heading of the table first."""
    time = run["time"].values
    heading, sigma = run["nav.heading"].values / DEGREE, run["heading_sigma"].values / DEGREE
    status, names = run["status"].values, run["status"].attrs["flag_meanings"].split()
    rows = [
        [f"{round(time[i], 3):g}", f"{heading[i]:.3f}", f"{sigma[i]:.3f}", names[int(status[i]) - 1]]
        for i in _at_round_times(time)
    ]
    return [["time [s]", "heading [deg]", "sigma [deg]", "status"], *rows]


def _at_round_times(time: Array, most: int = 12) -> list[int]:
    """Indices of at most a dozen samples at multiples of a round interval, and of the last one."""
    span = float(time[-1] - time[0])
    interval = next(
        (s for s in (1, 2, 5, 10, 20, 30, 60, 120, 300, 600) if span / s <= most - 1), span / most
    )
    index = np.searchsorted(time, np.arange(time[0], time[-1], interval) - 1e-6)
    return [*index.tolist(), len(time) - 1]


def _write(data: xr.Dataset, drawings: Mapping[str, tuple[Draw, str]], page: Page, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [Picture(name, caption, plots.png(draw(data))) for name, (draw, caption) in drawings.items()]
    for picture in pictures:
        (folder / f"{picture.name}.png").write_bytes(picture.png)
    path = folder / "report.html"
    path.write_text(_html(data, page, pictures), encoding="utf-8")
    return path


def _html(data: xr.Dataset, page: Page, pictures: list[Picture]) -> str:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("sim_scenarios", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["base64"] = lambda raw: base64.b64encode(raw).decode("ascii")
    facts: dict[str, Any] = {
        key: json.loads(data.attrs.get(key, "{}")) for key in ("settings", "filters", "versions")
    }
    return environment.get_template("report.html").render(
        page=page,
        pictures=pictures,
        description=data.attrs["description"],
        notes=data.attrs.get("notes", ""),
        seed=data.attrs.get("seed"),
        window=[data.attrs.get(f"evaluation.{edge}") for edge in ("start", "stop")],
        messages=json.loads(data.attrs.get("messages", "[]")),
        **facts,
    )
