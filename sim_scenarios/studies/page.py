"""The report of a campaign: one page with curves that can be explored, and all that it needs inside."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import markdown
from sim_scenarios.folders import filled
from sim_scenarios.html import interactive, numbers, render
from sim_scenarios.names import file_names
from sim_scenarios.studies import pictures, regret, store, table
from sim_scenarios.studies.expectations import Expectations, Row
from sim_scenarios.studies.findings import found
from sim_scenarios.studies.quantities import ERRORS
from sim_scenarios.studies.statistics import CaseSummary, Course, Summary
from sim_scenarios.units import reading

Array = NDArray[np.float64]

MOST_POINTS: Final = 400
"""Points of a curve on the page; the data set has them all."""
MOST_NUMBERS: Final = 2_000_000
"""Numbers on the page, for which the curves of a large campaign have fewer points."""


def write(
    data: xr.Dataset,
    cases: Sequence[CaseSummary],
    folder: Path,
    expect: Sequence[Expectations] = (),
    measured: Sequence[Row] = (),
    report: Callable[[int, int], None] = lambda _done, _total: None,
) -> dict[str, str]:
    """Write page, pictures and tables into a folder, with what is expected and was measured; their paths.

    `report` is told after each picture how many are done, and of how many.
    """
    expected = table.expectations(measured)
    names = file_names(case.label for case in cases)
    with filled(folder, anew=True) as draft:
        for done, case in enumerate(cases, start=1):
            pictures.draw(case, draft / names[case.label])
            report(done, len(cases))
        overviews = [rows for _, rows in _overviews(data, cases)]
        tables = [rows for rows in (expected, *overviews) if rows]
        (draft / "table.md").write_text("\n".join(map(markdown.table, tables)), encoding="utf-8")
        reasons = [reason for one in expect for reason in one.reasons()]
        html = _html(data, cases, found(data, cases, measured), expected, reasons)
        (draft / "report.html").write_text(html, encoding="utf-8")
    there = {"report": "report.html", "table": "table.md", "data": store.NAME}
    return {what: str(folder / name) for what, name in there.items()}


def _html(
    data: xr.Dataset, cases: Sequence[CaseSummary], said: str, expected: table.Rows, reasons: Sequence[str]
) -> str:
    about = json.loads(data.attrs["cases"])
    return render(
        "campaign.html",
        title=data.attrs["campaign"],
        description=data.attrs["description"],
        runs=data.attrs["runs"],
        seed=data.attrs["seed"],
        found=said,
        cases=[(case, _tables(case)) for case in cases],
        expected=expected,
        reasons=reasons,
        overviews=_overviews(data, cases),
        about={label: {**case, "command": _command(case, data)} for label, case in about.items()},
        **interactive("campaign.js", _content(data, cases)),
    )


def _tables(case: CaseSummary) -> list[table.Rows]:
    """Tables of a case, those that there is something to say in."""
    tables = (table.figures(case), table.certainty(case), table.errors(case), table.own_figures(case))
    return [rows for rows in tables if rows]


def _overviews(data: xr.Dataset, cases: Sequence[CaseSummary]) -> list[tuple[str, table.Rows]]:
    """Tables of every filter in every case with their titles, those that there is something to say in."""
    tables = {
        "Every filter in every scenario": table.by_scenario(cases),
        "Wrongly sure": table.wrongly_sure(cases),
        "Time to recover from a fault": table.recoveries(cases),
        **regret.tables(data),
    }
    return [(title, rows) for title, rows in tables.items() if rows]


def _command(case: dict[str, Any], data: xr.Dataset) -> str:
    """Command that shows the first run of a case alone; empty of filters that no scenario compares."""
    if isinstance(json.loads(data.attrs["plan"]).get("filters"), dict):
        return ""
    settings = [f"{name}={_text(value)}" for name, value in {**case["settings"], **case["drawn"]}.items()]
    words = [part for setting in settings for part in ("--set", setting)]
    return shlex.join(["truenorth", "compare", case["scenario"], "--seed", str(data.attrs["seed"]), *words])


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _content(data: xr.Dataset, cases: Sequence[CaseSummary]) -> dict[str, Any]:
    """What the script of the page draws from."""
    curves = sum(3 * (len(ERRORS) + 2) * len(case.filters) for case in cases)
    points = min(MOST_POINTS, MOST_NUMBERS // max(1, curves))
    return {
        "filters": [str(label) for label in data["filter"].values],
        "quantities": {name: {"title": q.title, "unit": reading(q.unit).name} for name, q in ERRORS.items()},
        "cases": [_case(case, points) for case in cases],
    }


def _case(case: CaseSummary, points: int) -> dict[str, Any]:
    thin = slice(None, None, max(1, -(-len(case.time) // points)))
    return {
        "label": case.label,
        "time": numbers(case.time[thin]),
        "counting": case.counting,
        "bounds": {
            name: numbers(bound[thin] / reading(ERRORS[name].unit).size)
            for name, bound in case.bounds.items()
        },
        "filters": {
            label: _filter(one, thin, table.unit_of(case).size) for label, one in case.filters.items()
        },
    }


def _filter(one: Summary, thin: slice, unit: float) -> dict[str, Any]:
    return {
        "errors": {name: _course(one.errors[name], thin, reading(q.unit).size) for name, q in ERRORS.items()},
        "nis": _course(one.nis_course, thin),
        "nees": _course(one.nees_course, thin),
        "runs": one.runs,
        "each": numbers(np.sort(one.each) / unit),
    }


def _course(course: Course, thin: slice, unit: float = 1.0) -> dict[str, list[float | None]]:
    return {name: numbers(values[thin] / unit) for name, values in vars(course).items()}
