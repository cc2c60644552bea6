"""The report of a run: PNG pictures and one HTML page that needs nothing else.

The page follows the reader's light or dark screen (the pictures are inverted with their hues kept) and is
readable on a telephone. A picture of something that a run does not have is left out.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import curves
from sim_scenarios.folders import filled
from sim_scenarios.html import interactive, render
from sim_scenarios.metrics import Verdict, hand_over, is_navigation, judge
from sim_scenarios.metrics.alignment import bound_in_words
from sim_scenarios.metrics.statistics import is_measured
from sim_scenarios.metrics.status import status_at_end
from sim_scenarios.plots import fixes, heading, navigation
from sim_scenarios.plots import side_by_side as pictures_side_by_side
from sim_scenarios.plots import track as pictures_of_track
from sim_scenarios.plots.states import states
from sim_scenarios.plots.style import png
from sim_scenarios.recording import ALIGNMENT, ERRORS, HAND_OVER, of_filter, under_way
from sim_scenarios.recordings import comparison, outages, side_by_side, smoothing, track
from sim_scenarios.units import ARCMIN, DEGREE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drawing:
    """A picture to draw: its file name, caption, and what a run must have for it.

    It shows a run from the hand-over of an alignment on; or the whole of it.
    """

    name: str
    caption: str
    draw: Callable[[xr.Dataset], Figure]
    needs: tuple[str, ...] = ("time",)
    whole: bool = False


_OF_FIXES = ("innovation", "innovation_sigma", "nis", "measurement_weight", "fix_used", "status")
_STANDARDISED = Drawing(
    "innovations",
    "What each fix brought that the filter had not predicted, in units of its predicted sigma.",
    fixes.standardised_innovations,
    _OF_FIXES,
)
_FIXES = (
    Drawing(
        "nis",
        "Normalised innovation squared against its chi-square limits, one by one and in the mean.",
        fixes.nis,
        _OF_FIXES,
    ),
    Drawing(
        "corrections",
        "Weights that the corrector gave, the gamma of the H-infinity update, rejected fixes, status.",
        fixes.corrections,
        _OF_FIXES,
    ),
)
_INNOVATIONS = Drawing(
    "innovations",
    "What each fix brought that the filter had not predicted, with 3 sigma; crosses were rejected.",
    fixes.innovations,
    _OF_FIXES,
)
_STATES = Drawing(
    "states",
    "Error of every state with 3 sigma. A consistent filter keeps 99.7 % of each curve inside.",
    states,
    ("misalignment_sigma",),
)
RUN = (
    Drawing(
        "heading",
        "Heading error with 3 sigma of the filter and of the Cramer-Rao bound; below, its end in arcminutes. "
        "The bound starts from a prior of its own: a filter that is told a tighter one may claim a sigma "
        "inside the bound at first.",
        heading.heading_error,
    ),
    _STATES,
    _INNOVATIONS,
    *_FIXES,
)
NAVIGATION = (
    Drawing(
        "hand_over",
        "Heading error with 3 sigma: the alignment, then the navigation that takes over its attitude, biases "
        "and covariance; below in arcminutes. The other pictures show the navigation alone.",
        heading.hand_over,
        (HAND_OVER,),
        whole=True,
    ),
    Drawing(
        "navigation",
        "Magnitude of the errors with 1 sigma of the filter, on the scale of the evaluation window.",
        navigation.navigation_error,
    ),
    _STATES,
    _STANDARDISED,
    *_FIXES,
)
REPLAY = (
    Drawing(
        "heading",
        "Heading with 3 sigma of the filter; below, its end, or where the vehicle turns its sigma alone.",
        heading.heading,
    ),
    Drawing(
        "states",
        "Estimate of every state with 3 sigma; with feedback the misalignment is what the last fix found.",
        lambda run: states(run.drop_vars(ERRORS, errors="ignore")),
    ),
    _INNOVATIONS,
    *_FIXES,
)
COMPARISON = (
    Drawing(
        "comparison",
        "Heading errors on the same signals, with 1 sigma of the Cramer-Rao bound; below, their end in "
        "arcminutes.",
        heading.comparison,
    ),
)
NAVIGATION_COMPARISON = (
    Drawing("comparison", "Magnitude of the errors on the same signals.", navigation.comparison),
)
BOUND = (
    Drawing("bound", "Sigma that no filter can beat in the mean, whatever its algorithm.", heading.bound),
)


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
    smoothed : list of list of str
        Rows of a replay and of its smoothed navigation, the first is the heading; empty for none.
    curves : list of dict
        Panels of `curves` that a reader can zoom into; empty for none.
    """

    title: str
    verdict: str
    good: bool | None
    figures: Mapping[str, str]
    table: list[list[str]]
    curves: list[curves.Panel] = field(default_factory=list)
    smoothed: list[list[str]] = field(default_factory=list)


def report_run(run: xr.Dataset, folder: Path) -> Path:
    """Report of a run of `sim_scenarios.run`; returns the path of the page."""
    verdict = judge(run)
    figures, zoomed = run_figures(run, verdict), curves.of_run(under_way(run))
    page = Page(run.attrs["scenario"], verdict.sentence(), verdict.ok, figures, [], zoomed)
    return _write(run, NAVIGATION if is_navigation(run) else RUN, page, folder)


def report_comparison(runs: xr.Dataset, folder: Path) -> Path:
    """Report of a comparison of `sim_scenarios.compare`; returns the path of the page."""
    verdicts = {str(label): judge(of_filter(runs, str(label))) for label in runs["filter"].values}
    count = sum(verdict.ok for verdict in verdicts.values())
    navigating = is_navigation(runs)
    text = f"{count} of {len(verdicts)} filters {'navigated' if navigating else 'converged'}"
    zoomed, figures = curves.of_comparison(under_way(runs)), comparison_figures(runs)
    page = Page(runs.attrs["scenario"], text, None, figures, comparison_table(verdicts), zoomed)
    return _write(runs, NAVIGATION_COMPARISON if navigating else COMPARISON, page, folder)


def report_bound(data: xr.Dataset, folder: Path) -> Path:
    """Report of the bound of `sim_scenarios.bound`; returns the path of the page."""
    if "bound.heading_rms_any" in data.attrs:
        known, error = (data.attrs[f"bound.heading_rms_any{what}"] for what in ("", "_standard_error"))
        rms = f"{known / ARCMIN:.2f} arcmin (standard error {error / ARCMIN:.2f})"
    else:
        rms = f"{data.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin"
    text = f"No filter knows the heading better than {rms} in the mean over many runs (RMS over the window)"
    page = Page(data.attrs["scenario"], text, None, about_bound(data), bound_table(data))
    return _write(data, BOUND, page, folder)


def report_replay(run: xr.Dataset, folder: Path) -> Path:
    """Report of a recording of `sim_scenarios.replay`; returns the path of the page."""
    ends, both = outages.ends(run), filtered_and_smoothed(run)
    smoothed_ends = outages.ends(both["smoothed"]) if both else None
    page = Page(
        Path(run.attrs["recording"]).name,
        replay_sentence(run),
        replay_converged(run),
        {**heading_at_end(run), **replay_figures(run)},
        outages.table(ends, smoothed_ends) if ends else heading_table(run),
        curves.of_replay(under_way(run)),
        side_by_side.table(both) if both else [],
    )
    return _write(run, [*REPLAY, *_of_recording(run, ends), *_of_smoothed(both)], page, folder)


def filtered_and_smoothed(run: xr.Dataset) -> dict[str, xr.Dataset]:
    """A replay and its smoothed navigation, by what they are; nothing where it is not smoothed."""
    return {"filter": run, "smoothed": smoothing.solution(run)} if smoothing.is_smoothed(run) else {}


def report_replays(runs: Mapping[str, xr.Dataset], folder: Path) -> Path:
    """Report of several filters on a recording (`recordings.side_by_side`); returns the path of the page."""
    about, sentence = side_by_side.together(runs), replays_sentence(runs)
    runs = smoothing.beside(runs)
    title = Path(about.attrs["recording"]).name
    page = Page(title, sentence, None, {}, side_by_side.table(runs), curves.of_replays(runs))
    return _write(about, list(_of_replays(runs)), page, folder)


def replays_sentence(runs: Mapping[str, xr.Dataset]) -> str:
    """What several filters say at the end of a recording."""
    count = sum(map(replay_converged, runs.values()))
    return f"{count} of {len(runs)} filters report convergence at the end"


def _of_replays(runs: Mapping[str, xr.Dataset]) -> Iterator[Drawing]:
    """Pictures of several filters on a recording, those that there is something to show in."""

    def drawing(name: str, caption: str, draw: Callable[[Mapping[str, xr.Dataset]], Figure]) -> Drawing:
        return Drawing(name, caption, lambda _: draw(runs))

    yield drawing("heading", "Heading of each filter, and its 1 sigma.", pictures_side_by_side.headings)
    if any(comparison.against_reference(run) is not None for run in runs.values()):
        yield drawing("errors", "Errors against the reference.", pictures_side_by_side.errors)
    if any(np.isfinite(comparison.missed(run)).any() for run in runs.values()):
        caption = "By how much each filter was off before it took a fix."
        yield drawing("fixes", caption, pictures_side_by_side.before_fixes)
    if any(outages.ends(run) for run in runs.values()):
        caption = "Antenna of each filter minus the last fix of each outage."
        yield drawing("outages", caption, pictures_side_by_side.outage_ends)


def _of_smoothed(both: Mapping[str, xr.Dataset]) -> Iterator[Drawing]:
    """Pictures of a replay beside its smoothed navigation."""
    for drawing in _of_replays(both) if both else ():
        if drawing.name != "fixes":  # of which a smoothed navigation is off from none
            caption = f"Filtered and smoothed. {drawing.caption}"
            yield replace(drawing, name=f"smoothed_{drawing.name}", caption=caption)


def replay_figures(run: xr.Dataset) -> dict[str, str]:
    """What a recording's result was worth: against its reference, its fixes, at the ends of its outages."""
    referred = comparison.against_reference(run)
    ends = outages.ends(run)
    used, rejected = (int(count.sum()) for count in (run["fix_used"], ~run["fix_used"]))
    figures = {} if referred is None else referred.headline()
    if ends:
        rms_at_ends = outages.figures(ends)["horizontal_rms_m"]
        figures[f"RMS at the ends of {len(ends)} outages"] = f"{rms_at_ends:.2f} m horizontal"
    return {
        **figures,
        **comparison.against_fixes(run).headline(),
        "Fixes used, rejected": f"{used}, {rejected}",
    }


def _of_recording(run: xr.Dataset, ends: list[outages.End]) -> list[Drawing]:
    """Pictures that not every recording has."""
    drawings = []
    if track.navigates_from(run) < np.inf and "receiver.position" in run:
        drawings.append(Drawing("track", "Track of the filter and the fixes.", pictures_of_track.track))
    if len(comparison.heading_minus_course(run)[0]):
        drawings.append(
            Drawing(
                "course",
                "Heading minus course over ground: mounting and side slip, and what the filter adds.",
                pictures_of_track.course,
            )
        )
    if ends:
        caption = "Error at the end of each outage: antenna of the filter minus the last fix of it."
        drawings.append(Drawing("outages", caption, lambda _: pictures_of_track.outage_ends(ends)))
    if comparison.against_reference(run) is not None and all(name in run for name in ERRORS):
        drawings += [
            Drawing(
                "navigation",
                "Magnitude of the errors against the reference with 1 sigma of the filter.",
                lambda data: navigation.navigation_error(comparison.compared(data)),
            ),
            Drawing(
                "errors",
                "Error of every state against the reference with 3 sigma.",
                lambda data: states(comparison.compared(data)),
            ),
        ]
    return drawings


CONTRADICTED: Final = ("inconsistent", "recovering")
"""Statuses of a filter that measurements contradict."""


def replay_converged(run: xr.Dataset) -> bool:
    """Whether the filter says at the end of a recording that its heading is to be relied on."""
    return bool(run["converged"].values[-1])


def replay_sentence(run: xr.Dataset) -> str:
    """What the filter says at the end of a recording."""
    if replay_converged(run):
        return "The filter reports convergence"
    aligned = track.navigates_from(run) < np.inf
    status = status_at_end(run, "status" if aligned else f"{ALIGNMENT}status")
    sentence = f"The filter does not report convergence: it is {status} at the end"
    if not aligned:
        sentence = f"Navigation did not begin: the alignment handed nothing over, it is {status} at the end"
    elif run.sizes["fix"] == 0:
        return f"The filter does not report convergence: no fix came, it is {status} at the end"
    if status in CONTRADICTED:
        return (
            f"{sentence}. Measurements contradict what it was told: `truenorth derive` finds their noise; a "
            "lever arm, the mounting or a clock in the description may be wrong"
        )
    return sentence


def heading_at_end(run: xr.Dataset) -> dict[str, str]:
    """Heading at the end of a recording, and how well the filter believes to know it."""
    angle, sigma = (float(_since_alignment(run, name)[-1]) / DEGREE for name in _OF_HEADING)
    return {"Heading at the end": f"{angle:.3f} deg", "Its 1 sigma": f"{sigma:.3f} deg"}


def run_figures(run: xr.Dataset, verdict: Verdict) -> dict[str, str]:
    """Headline figures of a run, with those of the bound."""
    return {**verdict.headline(), **about_bound(run)}


def comparison_figures(runs: xr.Dataset) -> dict[str, str]:
    """Headline figures of a comparison: what all filters have in common."""
    handed = hand_over.of_run(runs.isel(filter=0))
    return {**({} if handed is None else handed.headline()), **about_bound(runs)}


def about_bound(data: xr.Dataset) -> dict[str, str]:
    """The bound of the heading, what it is of, and what it leaves out."""
    left_out = data.attrs.get("bound.leaves_out", "")
    about = {"Bound leaves out": left_out} if left_out else {}
    if "bound.heading_rms" not in data.attrs:
        return about
    steady = data.attrs["bound.steady_course_limit"] / ARCMIN
    without, of_any = (data.attrs.get(f"bound.heading_rms_{which}") for which in ("steady", "any"))
    return {
        "Cramer-Rao bound": bound_in_words(data.attrs["bound.heading_rms"]),
        **({} if of_any is None else {"Of errors of any size": _with_standard_error(data, of_any)}),
        **({} if without is None else {"Without the manoeuvres": bound_in_words(without)}),
        "Steady-course limit": f"{steady:.2f} arcmin, eps_E / (w_ie cos L)",
        "Bound measures": f"GNSS {data.attrs['bound.measured']}",
        **about,
    }


def _with_standard_error(data: xr.Dataset, rms: float) -> str:
    standard_error = data.attrs["bound.heading_rms_any_standard_error"] / ARCMIN
    return f"{bound_in_words(rms)}, with a standard error of {standard_error:.2f} arcmin"


def comparison_table(verdicts: Mapping[str, Verdict]) -> list[list[str]]:
    """Rows of the comparison of filters, the heading first."""
    rows = {label: verdict.row() for label, verdict in verdicts.items()}
    columns = list(next(iter(rows.values())))
    return [["Filter", *columns], *([label, *row.values()] for label, row in rows.items())]


def bound_table(data: xr.Dataset) -> list[list[str]]:
    """Sigma of the heading, and of the position where it is measured, at round times, the heading first."""
    time = data["bound_time"].values
    columns = {"heading [']": data["bound.heading_sigma"].values / ARCMIN}
    if "bound.heading_sigma_any" in data:
        columns["heading, errors of any size [']"] = data["bound.heading_sigma_any"].values / ARCMIN
    if "bound.heading_sigma_steady" in data:
        columns["heading without manoeuvres [']"] = data["bound.heading_sigma_steady"].values / ARCMIN
    if "bound.position_sigma" in data:
        sigma = data["bound.position_sigma"].values
        columns |= {"horizontal [m]": np.hypot(sigma[:, 0], sigma[:, 1]), "vertical [m]": sigma[:, 2]}
    rows = [
        [f"{round(time[i], 3):g}", *(f"{values[i]:.2f}" for values in columns.values())]
        for i in _at_round_times(time)
    ]
    return [["time [s]", *(f"sigma of {name}" for name in columns)], *rows]


def heading_table(run: xr.Dataset) -> list[list[str]]:
    """Heading at round times, the heading of the table first; of an alignment, until it has handed over."""
    time = run["time"].values
    angle, sigma = (_since_alignment(run, name) / DEGREE for name in _OF_HEADING)
    status, names = _since_alignment(run, "status"), run["status"].attrs["flag_meanings"].split()
    rows = [
        [f"{round(time[i], 3):g}", f"{angle[i]:.3f}", f"{sigma[i]:.3f}", names[int(status[i]) - 1]]
        for i in _at_round_times(time)
    ]
    return [["time [s]", "heading [deg]", "1 sigma [deg]", "status"], *rows]


_OF_HEADING: Final = ("nav.heading", "heading_sigma")


def _since_alignment(run: xr.Dataset, name: str) -> Array:
    """Values of a variable, those of the alignment before it has handed over, if there is one."""
    values: Array = run[name].values
    if HAND_OVER not in run:
        return values
    return np.where(run["time"].values < track.navigates_from(run), run[f"{ALIGNMENT}{name}"].values, values)


def _at_round_times(time: Array, most: int = 12) -> list[int]:
    """Indices of at most a dozen samples at multiples of a round interval, and of the last one."""
    span = float(time[-1] - time[0])
    interval = next(
        (s for s in (1, 2, 5, 10, 20, 30, 60, 120, 300, 600) if span / s <= most - 1), span / most
    )
    index = np.searchsorted(time, np.arange(time[0], time[-1], interval) - 1e-6)
    return [*index.tolist(), len(time) - 1]


def _drawn(data: xr.Dataset, drawings: Sequence[Drawing]) -> Iterator[tuple[Drawing, Figure]]:
    """Drawings whose needs are recorded, with at least one value; those of fixes if one measured anything."""
    with_estimates = under_way(data)
    for drawing in drawings:
        shown = data if drawing.whole else with_estimates
        recorded = all(name in shown and shown[name].size > 0 for name in drawing.needs)
        if recorded and (drawing.needs != _OF_FIXES or is_measured(shown).any()):
            yield drawing, drawing.draw(shown)


def _write(data: xr.Dataset, drawings: Sequence[Drawing], page: Page, folder: Path) -> Path:
    pictures = []
    with filled(folder) as draft:
        for drawing, figure in _drawn(data, drawings):
            content = png(figure)
            (draft / f"{drawing.name}.png").write_bytes(content)
            pictures.append({"name": drawing.name, "caption": drawing.caption, "png": content})
        (draft / "report.html").write_text(_html(data, page, pictures), encoding="utf-8")
    return folder / "report.html"


def _html(data: xr.Dataset, page: Page, pictures: list[dict[str, Any]]) -> str:
    facts: dict[str, Any] = {
        key: json.loads(data.attrs.get(key, "{}")) for key in ("settings", "filters", "versions")
    }
    shown = interactive("curves.js", page.curves) if page.curves else {}
    return render(
        "report.html",
        page=page,
        pictures=pictures,
        description=data.attrs["description"],
        notes=data.attrs.get("notes", ""),
        seed=data.attrs.get("seed"),
        window=[data.attrs.get(f"evaluation.{edge}") for edge in ("start", "stop")],
        messages=json.loads(data.attrs.get("messages", "[]")),
        **facts,
        **shown,
    )
