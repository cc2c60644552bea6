"""Tables of a campaign, for the terminal, for Markdown and for machines: figures with their intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

from sim_scenarios.metrics.certainty import QUANTITIES
from sim_scenarios.metrics.figures import own
from sim_scenarios.metrics.folds import Estimate
from sim_scenarios.studies.expectations import Row
from sim_scenarios.studies.quantities import ERRORS
from sim_scenarios.studies.statistics import CaseSummary, Summary
from sim_scenarios.units import Reading, reading

Rows = list[list[str]]

PERCENT: Final = 0.01
HOUR: Final = 3600.0


def figures(case: CaseSummary) -> Rows:
    """Main table of a case, its heading first: a line for each filter."""
    unit = unit_of(case)
    handed_over = any(math.isfinite(one.hand_over[0]) for one in case.filters.values())
    rows = [
        [
            "filter",
            f"{ERRORS[case.counting].title.lower()}\nRMSE [{unit.name}]",
            "95 %\ninterval",
            "/\nbound",
            f"/ {case.reference}\n(95 %)",
            "failed\nruns",
            "within\nlimit [s]",
            "wrongly\nconverged",
            "NIS /\nchannel",
            "NEES at\nthe end",
            *(["handed\nover [s]"] if handed_over else []),
        ]
    ]
    for label, one in case.filters.items():
        rmse = one.rmse[case.counting] / unit.size
        rows.append(
            [
                label,
                number(rmse.value),
                _span(rmse),
                number(one.to_bound.value),
                "1" if label == case.reference else f"{number(one.ratio.value)} ({_span(one.ratio)})",
                f"{round(one.failures.value * one.runs)} / {one.runs}",
                number(one.convergence[0], "never"),
                f"{round(one.wrong_claims.value * one.claims)} / {one.claims}" if one.claims else "-",
                _consistency(one.nis),
                _consistency(one.nees),
                *([" to ".join(map(number, one.hand_over))] if handed_over else []),
            ]
        )
    return rows


def certainty(case: CaseSummary) -> Rows:
    """How sure the filters of a case are and whether they are right, the heading of the table first."""
    all_of_them = case.filters.values()
    estimated = [name for name in QUANTITIES if any(_known(one.wrongly_sure_in[name]) for one in all_of_them)]
    recovers = any(_known(one.recovered) for one in all_of_them)
    instants = dict.fromkeys(instant for one in all_of_them for instant in one.nees_at)
    rows = [
        [
            "filter",
            "sure\n[s a run]",
            "wrongly\nsure [%]",
            *(f"by\n{name} [%]" for name in estimated),
            "longest\n[s]",
            *(["recovered\n[%]", "median time to\nrecover [s]"] if recovers else []),
            *(f"NEES at\n{span(instant)}" for instant in instants),
        ]
    ]
    for label, one in case.filters.items():
        recovery = [interval(one.recovered / PERCENT), number(one.recovery[0], "never")]
        rows.append(
            [
                label,
                number(one.sure),
                interval(one.wrongly_sure / PERCENT),
                *(interval(one.wrongly_sure_in[name] / PERCENT) for name in estimated),
                number(one.longest_wrongly_sure),
                *((recovery if _known(one.recovered) else ["-", "-"]) if recovers else []),
                *(_consistency(one.nees_at[instant]) for instant in instants),
            ]
        )
    return rows


def errors(case: CaseSummary) -> Rows:
    """RMSE of every quantity, the heading of the table first."""
    rows = [["filter", *(f"{q.title.lower()}\n[{reading(q.unit).name}]" for q in ERRORS.values())]]
    for label, one in case.filters.items():
        values = [interval(one.rmse[name] / reading(q.unit).size) for name, q in ERRORS.items()]
        rows.append([label, *values])
    return rows


def own_figures(case: CaseSummary) -> Rows:
    """Figures that other packages add, the heading of the table first; empty without any."""
    figures = {
        name: figure
        for name, figure in own().items()
        if all(name in one.own for one in case.filters.values())
    }
    if not figures:
        return []
    rows = [["filter", *(f"{figure.label}\n{figure.fold.name}" for figure in figures.values())]]
    for label, one in case.filters.items():
        values = [interval(one.own[name] / figure.reading.size) for name, figure in figures.items()]
        rows.append([label, *values])
    return rows


def expectations(rows: Sequence[Row], digits: int = 3) -> Rows:
    """What is expected beside what was measured, the heading of the table first; empty without any."""
    heading = ["case", "filter", "figure", "expected", "measured", "95 %", "single runs", ""]
    lines = [[one.case, *one.cells(digits), "**missed**" if one.missed else "ok"] for one in rows]
    return [heading, *lines] if lines else []


def by_scenario(cases: Sequence[CaseSummary]) -> Rows:
    """RMSE of the error that counts, and bound: filters in lines, or scenarios if there are more of them."""
    units = [unit_of(case) for case in cases]
    titles = [f"{c.label}: {c.counting} [{unit.name}]" for c, unit in zip(cases, units, strict=True)]
    bounds = [number(case.bound_rms / unit.size) for case, unit in zip(cases, units, strict=True)]

    def rmse(case: CaseSummary, one: Summary) -> str:
        return interval(one.rmse[case.counting] / unit_of(case).size)

    return _crossed("RMSE (95 % interval)", titles, cases, rmse, ["bound", *bounds])


def wrongly_sure(cases: Sequence[CaseSummary]) -> Rows:
    """Share of the time of each filter in each case in which it is wrongly sure, and the longest stretch."""

    def said(_: CaseSummary, one: Summary) -> str:
        longest = f", longest {number(one.longest_wrongly_sure)} s" if one.longest_wrongly_sure else ""
        return interval(one.wrongly_sure / PERCENT) + longest

    return _crossed("wrongly sure [%] (95 % interval)", [case.label for case in cases], cases, said)


def recoveries(cases: Sequence[CaseSummary]) -> Rows:
    """Median time to recover of each filter in each case with a fault that ends; empty without any."""
    with_fault = [case for case in cases if any(_known(one.recovered) for one in case.filters.values())]
    if not with_fault:
        return []

    def said(_: CaseSummary, one: Summary) -> str:
        if not _known(one.recovered):
            return "-"
        return f"{number(one.recovery[0], 'never')} ({interval(one.recovered / PERCENT, ' %')} recovered)"

    labels = [case.label for case in with_fault]
    return _crossed("median time to recover [s]", labels, with_fault, said)


def _crossed(
    title: str,
    titles: Sequence[str],
    cases: Sequence[CaseSummary],
    cell: Callable[[CaseSummary, Summary], str],
    last: list[str] | None = None,
) -> Rows:
    """Filters in lines and cases in columns, or the other way if there are more cases."""
    labels = dict.fromkeys(label for case in cases for label in case.filters)
    rows = [[title, *titles]]
    for label in labels:
        filters = [case.filters.get(label) for case in cases]
        rows.append(
            [label, *("" if one is None else cell(c, one) for c, one in zip(cases, filters, strict=True))]
        )
    rows += [last] if last else []
    return [list(column) for column in zip(*rows, strict=True)] if len(cases) > len(labels) else rows


def unit_of(case: CaseSummary) -> Reading:
    """Unit in which people read the error that counts."""
    return reading(ERRORS[case.counting].unit)


def for_machines(case: CaseSummary) -> dict[str, Any]:
    """All figures of a case in SI units; an interval as a list, None where a figure does not exist."""
    return {
        "reference": case.reference,
        "counting": case.counting,
        "bound": json_number(case.bound_rms),
        "filters": {
            label: {
                "runs": one.runs,
                "stopped": one.stopped,
                "failures": _estimate(one.failures),
                **{f"{name}_rmse": _estimate(value) for name, value in one.rmse.items()},
                "to_bound": _estimate(one.to_bound),
                "ratio_to_reference": _estimate(one.ratio),
                "convergence_median": json_number(one.convergence[0]),
                "convergence_90_percent": json_number(one.convergence[1]),
                "hand_over": [json_number(time) for time in one.hand_over],
                "claims": one.claims,
                "wrong_claims": _estimate(one.wrong_claims),
                "sure_mean": json_number(one.sure),
                "wrongly_sure": _estimate(one.wrongly_sure),
                **{f"wrongly_sure_{name}": _estimate(share) for name, share in one.wrongly_sure_in.items()},
                "longest_wrongly_sure": json_number(one.longest_wrongly_sure),
                "recovered": _estimate(one.recovered),
                "recovery_median": json_number(one.recovery[0]),
                "recovery_90_percent": json_number(one.recovery[1]),
                "nis": _estimate(one.nis),
                "nees_at_the_end": _estimate(one.nees),
                "nees_at": {f"{instant:g}": _estimate(value) for instant, value in one.nees_at.items()},
                **{name: _estimate(value) for name, value in one.own.items()},
            }
            for label, one in case.filters.items()
        },
    }


def interval(estimate: Estimate, unit: str = "") -> str:
    """A figure with its interval."""
    reach = _span(estimate)
    return number(estimate.value) + unit + (f" ({reach})" if reach else "")


def span(time: float) -> str:
    """A span of time as people read it."""
    return f"{time / HOUR:g} h" if time >= HOUR and time % HOUR == 0 else f"{time:g} s"


def number(value: float, missing: str = "-") -> str:
    """A figure with three digits that count."""
    return missing if math.isnan(value) else f"{value:.{_decimals(value)}f}"  # also "inf"


def _span(estimate: Estimate) -> str:
    """An interval with the decimals of its figure; nothing where there is none."""
    if math.isnan(estimate.lower):
        return ""
    decimals = _decimals(estimate.value)
    return f"{estimate.lower:.{decimals}f} to {estimate.upper:.{decimals}f}"


def _known(estimate: Estimate) -> bool:
    return not math.isnan(estimate.value)


def _consistency(estimate: Estimate) -> str:
    """A mean; a star where a consistent filter would have one outside its interval once in 20 times."""
    inside = math.isnan(estimate.value) or estimate.lower <= estimate.value <= estimate.upper
    return number(estimate.value) + ("" if inside else " *")


def _decimals(value: float) -> int:
    """Three digits that count."""
    return 2 if value == 0 or math.isinf(value) else max(0, min(4, 2 - math.floor(math.log10(abs(value)))))


def json_number(value: float) -> float | None:
    """A figure for machines: None where it does not exist."""
    return value if math.isfinite(value) else None


def _estimate(estimate: Estimate) -> list[float | None]:
    return [json_number(estimate.value), json_number(estimate.lower), json_number(estimate.upper)]
