"""How far each filter is from the best one of its case: its regret, the ratio of their errors.

The figure of a filter is its RMSE over the runs that it and the best one have finished, and the best one is
that with the smallest RMSE of all its runs. Intervals are those of the ratio over the same seeds
(`metrics.folds`). That of the best itself is 1; which filter that is, noise decides where several are
close, so that a regret of a few per cent that is within its interval of 1 is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.metrics.folds import Estimate, paired_ratio, root_mean_square
from sim_scenarios.studies.quantities import ERRORS
from sim_scenarios.studies.store import State
from sim_scenarios.studies.table import Rows, interval, number

Array = NDArray[np.float64]

QUANTITIES: Final = ("horizontal", "heading")
"""Errors of `quantities.ERRORS` of which there is a table."""
OF_ALL: Final = "largest"


def regrets(data: xr.Dataset, quantity: str) -> dict[str, dict[str, Estimate]]:
    """Regret of every filter in every case, by label; without filters that have no such error there.

    Parameters
    ----------
    data : xarray.Dataset
        Results of a campaign (see `store`).
    quantity : str
        Of `quantities.ERRORS`.
    """
    figures = data[[f"{quantity}_rmse", "state"]].load()
    return {str(case): _of_case(figures.sel(scenario=case), quantity) for case in data["scenario"].values}


def tables(data: xr.Dataset) -> dict[str, Rows]:
    """Tables of the regret by title: filters in lines, cases in columns, and the largest of each filter.

    Empty where no case has two filters to be compared.
    """
    made: dict[str, Rows] = {}
    for quantity in QUANTITIES:
        by_case = {case: found for case, found in regrets(data, quantity).items() if len(found) > 1}
        if by_case:
            title = ERRORS[quantity].title.lower()
            made[f"Regret: {title} RMSE by that of the best filter of the case"] = _rows(by_case)
    return made


def _of_case(case: xr.Dataset, quantity: str) -> dict[str, Estimate]:
    finished = case[f"{quantity}_rmse"].where(case["state"] == State.finished)
    each = {str(label): finished.sel(filter=label).values for label in case["filter"].values}
    each = {label: values for label, values in each.items() if np.isfinite(values).any()}
    if not each:
        return {}
    best = min(each, key=lambda label: root_mean_square(each[label][np.isfinite(each[label])]).value)
    return {label: _ratio(values, each[best]) for label, values in each.items()}


def _ratio(one: Array, best: Array) -> Estimate:
    both = np.isfinite(one) & np.isfinite(best)
    return paired_ratio(one[both], best[both])


def _rows(by_case: Mapping[str, Mapping[str, Estimate]]) -> Rows:
    labels = dict.fromkeys(label for found in by_case.values() for label in found)
    rows = [["filter", *by_case, OF_ALL]]
    for label in labels:
        found = [case.get(label) for case in by_case.values()]
        largest = max(one.value for one in found if one is not None)
        rows.append([label, *("" if one is None else interval(one) for one in found), number(largest)])
    return rows
