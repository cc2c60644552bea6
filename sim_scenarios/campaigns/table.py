"""Tables of a campaign, for the terminal, for Markdown and for machines: figures with their intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

from sim_scenarios.campaigns.quantities import ERRORS
from sim_scenarios.campaigns.statistics import CaseSummary, Estimate
from sim_scenarios.units import ARCMIN

Rows = list[list[str]]

UNITS: Final = {"rad": ("arcmin", ARCMIN), "m/s": ("m/s", 1.0), "m": ("m", 1.0)}
"""Unit in which people read a quantity, and its size."""


def figures(case: CaseSummary) -> Rows:
    """Main table of a case, its heading first: a line for each filter."""
    unit, size = unit_of(case)
    handed_over = any(math.isfinite(one.hand_over[0]) for one in case.filters.values())
    rows = [
        [
            "filter",
            f"{ERRORS[case.counting].title.lower()}\nRMSE [{unit}]",
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
        rmse = one.rmse[case.counting] / size
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


def errors(case: CaseSummary) -> Rows:
    """RMSE of every quantity, the heading of the table first."""
    rows = [["filter", *(f"{q.title.lower()}\n[{UNITS[q.unit][0]}]" for q in ERRORS.values())]]
    for label, one in case.filters.items():
        values = [interval(one.rmse[name] / UNITS[q.unit][1]) for name, q in ERRORS.items()]
        rows.append([label, *values])
    return rows


def by_scenario(cases: Sequence[CaseSummary]) -> Rows:
    """RMSE of the error that counts, and bound: filters in lines, or scenarios if there are more of them."""
    labels = dict.fromkeys(label for case in cases for label in case.filters)
    units = [unit_of(case) for case in cases]
    titles = [f"{case.label}: {case.counting} [{unit}]" for case, (unit, _) in zip(cases, units, strict=True)]
    rows = [["RMSE (95 % interval)", *titles]]
    for label in labels:
        row = [label]
        for case, (_, size) in zip(cases, units, strict=True):
            one = case.filters.get(label)
            row.append("" if one is None else interval(one.rmse[case.counting] / size))
        rows.append(row)
    bounds = [number(case.bound_rms / size) for case, (_, size) in zip(cases, units, strict=True)]
    rows.append(["Cramer-Rao bound", *bounds])
    return [list(column) for column in zip(*rows, strict=True)] if len(cases) > len(labels) else rows


def unit_of(case: CaseSummary) -> tuple[str, float]:
    """Unit in which people read the error that counts, and its size."""
    return UNITS[ERRORS[case.counting].unit]


def markdown(rows: Rows) -> str:
    """A table in Markdown."""
    heading, *body = ([cell.replace("\n", " ") for cell in cells] for cells in rows)
    lines = [heading, ["---"] * len(heading), *body]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


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
                "nis": _estimate(one.nis),
                "nees_at_the_end": _estimate(one.nees),
            }
            for label, one in case.filters.items()
        },
    }


def interval(estimate: Estimate) -> str:
    """A figure with its interval."""
    span = _span(estimate)
    return number(estimate.value) + (f" ({span})" if span else "")


def number(value: float, missing: str = "-") -> str:
    """A figure with three digits that count."""
    return missing if math.isnan(value) else f"{value:.{_decimals(value)}f}"


def _span(estimate: Estimate) -> str:
    """An interval with the decimals of its figure; nothing where there is none."""
    if math.isnan(estimate.lower):
        return ""
    decimals = _decimals(estimate.value)
    return f"{estimate.lower:.{decimals}f} to {estimate.upper:.{decimals}f}"


def _consistency(estimate: Estimate) -> str:
    """A mean; a star where a consistent filter would have one outside its interval once in 20 times."""
    inside = math.isnan(estimate.value) or estimate.lower <= estimate.value <= estimate.upper
    return number(estimate.value) + ("" if inside else " *")


def _decimals(value: float) -> int:
    """Three digits that count."""
    return 2 if value == 0 else max(0, min(4, 2 - math.floor(math.log10(abs(value)))))


def json_number(value: float) -> float | None:
    """A figure for machines: None where it does not exist."""
    return value if math.isfinite(value) else None


def _estimate(estimate: Estimate) -> list[float | None]:
    return [json_number(estimate.value), json_number(estimate.lower), json_number(estimate.upper)]
