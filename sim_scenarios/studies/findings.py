"""What a campaign found, in a few sentences: the best filter, what failed, who was wrongly sure.

The best filter of a case has the smallest RMSE of the error that counts; one whose regret (`regret`) has 1 in
its interval is not told from it. A filter is wrongly sure by more than chance if the interval of the share of
its converged time lies above what a consistent filter has (`metrics.certainty`).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final

import xarray as xr
from scipy.special import chdtrc

from sim_scenarios.metrics.certainty import WRONG
from sim_scenarios.metrics.folds import Estimate
from sim_scenarios.studies.expectations import Band, Row
from sim_scenarios.studies.quantities import ERRORS
from sim_scenarios.studies.regret import regrets
from sim_scenarios.studies.statistics import CaseSummary, Summary
from sim_scenarios.studies.table import PERCENT, interval, unit_of

COMPONENTS: Final = {"heading": 1, "velocity": 3, "position": 3}
"""Of each quantity of `metrics.certainty`."""
MOST_NAMES: Final = 3


def found(data: xr.Dataset, cases: Sequence[CaseSummary], measured: Sequence[Row] = ()) -> str:
    """Sentences on the results of a campaign (see `store`), from figures that its tables have."""
    said = [_best(data, cases), _failed(cases), _wrongly_sure(cases), _missed(measured)]
    return " ".join(f"{sentence[0].upper()}{sentence[1:]}." for sentence in said if sentence)


def _best(data: xr.Dataset, cases: Sequence[CaseSummary]) -> str:
    """Which filter is ahead; nothing where there is none to hold it against."""
    by_quantity = {counting: regrets(data, counting) for counting in {case.counting for case in cases}}
    found = [(case, by_quantity[case.counting][case.label]) for case in cases]
    contests = [(case, regret) for case, regret in found if len(regret) > 1]
    if len(contests) == 1:
        return _ahead(*contests[0])
    ahead = Counter(label for _, regret in contests for label in regret if _is_close(regret[label]))
    if not ahead:
        return ""
    most = max(ahead.values())
    labels = [label for label in ahead if ahead[label] == most]
    who = f"{_names(labels)} {'each have' if len(labels) > 1 else 'has'}"
    return f"{who} the smallest RMSE, or one that cannot be told from it, in {most} of {len(contests)} cases"


def _ahead(case: CaseSummary, regret: Mapping[str, Estimate]) -> str:
    def rmse(label: str) -> Estimate:
        return case.filters[label].rmse[case.counting]

    unit = unit_of(case)
    best = min(regret, key=lambda label: (not math.isfinite(rmse(label).value), rmse(label).value))
    close = [label for label in regret if label != best and _is_close(regret[label])]
    return (
        f"of {len(regret)} filters {_names([best])} has the smallest RMSE of "
        f"{ERRORS[case.counting].title.lower()}, {interval(rmse(best) / unit.size, f' {unit.name}')}"
        + (f"; {_names(close)} cannot be told from it" if close else "")
    )


def _is_close(regret: Estimate) -> bool:
    return not regret.lower > 1  # nor known


def _failed(cases: Sequence[CaseSummary]) -> str:
    rows = [(label, one) for case in cases for label, one in case.filters.items()]
    runs, failed = sum(one.runs for _, one in rows), Counter[str]()
    for label, one in rows:
        failed[label] += round(one.failures.value * one.runs)
    if not failed.total():
        return f"none of {runs} runs failed"
    label, most = failed.most_common(1)[0]
    whose = f", {'all' if most == failed.total() else most} of them of {_names([label])}"
    return f"{failed.total()} of {runs} runs failed{whose if len(failed) > 1 else ''}"


def _wrongly_sure(cases: Sequence[CaseSummary]) -> str:
    rows = [(case.label, label, one) for case in cases for label, one in case.filters.items()]
    if not any(one.sure > 0 for *_, one in rows):
        return "no filter reported convergence"
    wrong = [row for row in rows if _is_beyond_chance(row[-1])]
    if not wrong:
        return "no filter was wrongly sure by more than chance"
    labels = list(dict.fromkeys(label for _, label, _ in wrong))
    case, label, worst = max(wrong, key=lambda row: row[-1].wrongly_sure.value)
    return (
        f"{_names(labels)} {'were' if len(labels) > 1 else 'was'} wrongly sure by more than chance, "
        f"{'at most ' if len(wrong) > 1 else ''}{f'{_names([label])} ' if len(labels) > 1 else ''}for "
        f"{interval(worst.wrongly_sure / PERCENT, ' %')} of the converged time"
        + (f" in {case}" if len(cases) > 1 else "")
    )


def _is_beyond_chance(one: Summary) -> bool:
    known = [name for name, share in one.wrongly_sure_in.items() if not math.isnan(share.value)]
    chance = float(chdtrc(1, WRONG**2)) * sum(COMPONENTS[name] for name in known)
    share = one.wrongly_sure
    return (share.value if math.isnan(share.lower) else share.lower) > chance


def _missed(measured: Sequence[Row]) -> str:
    banded = [row for row in measured if isinstance(row.expected, Band)]
    missed = sum(row.missed for row in banded)
    return f"{missed or 'none'} of {len(banded)} figures with a band missed it" if banded else ""


def _names(labels: Sequence[str]) -> str:
    """Labels in a row; how many there are, if they are more than a sentence bears."""
    if len(labels) > MOST_NAMES:
        return f"{len(labels)} filters"
    *others, last = (f"'{label}'" for label in labels)
    return f"{', '.join(others)} and {last}" if others else last
