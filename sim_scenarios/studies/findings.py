"""What a campaign found, in a few sentences: the best filter, what failed, who was wrongly sure.

The best filter of a case has the smallest RMSE of the error that counts, of those that have one of every run
as long as there are such: what is left of runs that stopped may be the easy ones. One whose regret (`regret`)
has 1 in its interval is not told from it. A filter is wrongly sure by more than chance if the interval of the
share of its converged time lies above what a consistent filter has (`metrics.certainty`); a single run has
no interval, and tells its share alone.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr
from scipy.special import chdtrc

from sim_scenarios.metrics.certainty import WRONG
from sim_scenarios.metrics.folds import Estimate, root_mean_square
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
    if not any(case.filters for case in cases):
        return "There are no runs yet."
    said = [_best(data, cases), _failed(cases), _wrongly_sure(cases), _missed(measured)]
    return " ".join(f"{sentence[0].upper()}{sentence[1:]}." for sentence in said if sentence)


@dataclass(frozen=True)
class _Contest:
    """Filters of one case against each other.

    Attributes
    ----------
    figures : dict of str to Estimate
        RMSE of the error that counts over the runs that have one, of the filters that have any.
    regret : mapping of str to Estimate
        Of those with a figure of every run; where there is none, of all with a figure.
    whole : bool
        Whether those have a figure of every run.
    without : list of str
        Filters without a figure.
    """

    case: CaseSummary
    figures: dict[str, Estimate]
    regret: Mapping[str, Estimate]
    whole: bool
    without: list[str]


def _contest(data: xr.Dataset, case: CaseSummary) -> _Contest:
    known = {label: one.each[np.isfinite(one.each)] for label, one in case.filters.items()}
    figures = {label: root_mean_square(each) for label, each in known.items() if len(each)}
    runs = max(one.runs for one in case.filters.values())
    whole = [label for label in figures if len(known[label]) == runs]
    contenders = data.sel(scenario=[case.label], filter=whole or list(figures))
    return _Contest(
        case,
        figures,
        regrets(contenders, case.counting)[case.label],
        bool(whole),
        [label for label in known if label not in figures],
    )


def _best(data: xr.Dataset, cases: Sequence[CaseSummary]) -> str:
    """Which filter is ahead; nothing where there is none to hold it against."""
    contests = [_contest(data, case) for case in cases if len(case.filters) > 1]
    contests = [contest for contest in contests if contest.figures]
    if len(contests) == 1:
        return _ahead(contests[0])
    ahead = Counter(label for one in contests for label in one.regret if _is_close(one.regret[label]))
    if not ahead:
        return ""
    most = max(ahead.values())
    labels = [label for label in ahead if ahead[label] == most]
    who = f"{_names(labels)} {'each have' if len(labels) > 1 else 'has'}"
    without = list(dict.fromkeys(label for one in contests for label in one.without))
    partial = sum(not one.whole for one in contests)
    return (
        f"{who} the smallest RMSE, or one that cannot be told from it, in {most} of {len(contests)} cases"
        + (", of the filters with one of every run" if any(_left_out(one) for one in contests) else "")
        + (f"; in {partial} no filter has one of every run" if partial else "")
        + (f"; {_names(without)} {_have(without)} none in some of them" if without else "")
    )


def _ahead(contest: _Contest) -> str:
    case, figures, regret = contest.case, contest.figures, contest.regret
    unit, error = unit_of(case), ERRORS[case.counting].title.lower()
    best = min(regret, key=lambda label: figures[label].value)
    figure = interval(figures[best] / unit.size, f" {unit.name}")
    close = [label for label in regret if label != best and _is_close(regret[label])]
    of_runs = "" if contest.whole else ", over the runs that have one"
    if len(regret) > 1:
        of_every = " with an RMSE of every run" if _left_out(contest) else ""
        said = (
            f"of {len(regret)} filters{of_every} {_names([best])} has the smallest RMSE of {error}{of_runs}"
        )
    else:
        of_every = " of every run" if _left_out(contest) else ""
        said = f"{_names([best])} alone has an RMSE of {error}{of_every}{of_runs}"
    return (
        f"{said}, {figure}"
        + (f"; {_names(close)} cannot be told from it" if close else "")
        + (f"; {_names(contest.without)} {_have(contest.without)} none" if contest.without else "")
    )


def _left_out(contest: _Contest) -> bool:
    """Whether a filter with a figure is not held against the others."""
    return len(contest.regret) < len(contest.figures)


def _have(labels: Sequence[str]) -> str:
    return "have" if len(labels) > 1 else "has"


def _is_close(regret: Estimate) -> bool:
    return not regret.lower > 1  # nor known


def _failed(cases: Sequence[CaseSummary]) -> str:
    rows = [(label, one) for case in cases for label, one in case.filters.items()]
    runs, failed = sum(one.runs for _, one in rows), Counter[str]()
    for label, one in rows:
        failed[label] += round(one.failures.value * one.runs)
    if not failed.total():
        return f"none of {runs} runs failed"
    if failed.total() == runs:
        return f"every one of {runs} runs failed"
    most = max(failed.values())
    labels = [label for label in failed if failed[label] == most]
    whose = f", {'all' if most == failed.total() else most} of them of {'each of ' * (len(labels) > 1)}"
    return f"{failed.total()} of {runs} runs failed{whose + _names(labels) if len(failed) > 1 else ''}"


def _wrongly_sure(cases: Sequence[CaseSummary]) -> str:
    rows = [(case.label, label, one) for case in cases for label, one in case.filters.items()]
    known = [row for row in rows if not math.isnan(row[-1].sure)]
    if not known:
        return "whether a filter reported convergence is not known"
    sure = [row for row in known if row[-1].sure > 0]
    if not sure:
        finished = " in a run that finished" if len(known) < len(rows) else ""
        return f"no filter reported convergence{finished}"
    unknown = list(dict.fromkeys(label for _, label, one in sure if math.isnan(one.wrongly_sure.value)))
    told = [row for row in sure if not math.isnan(row[-1].wrongly_sure.value)]
    if not told:
        return "whether a filter was wrongly sure is not known"
    above = [row for row in told if _is_above_chance(row[-1])]
    beyond = [row for row in above if not math.isnan(row[-1].wrongly_sure.lower)]
    once = [row for row in above if math.isnan(row[-1].wrongly_sure.lower)]
    in_a_case = len(cases) > 1
    said = [
        _for_how_long(beyond, " by more than chance,", in_a_case) if beyond else "",
        f"{_for_how_long(once, '', in_a_case)}: one run tells no more" if once else "",
        "" if above else "no filter was wrongly sure by more than chance",
        f"of {_names(unknown)} it is not known{' in every case' * in_a_case}" if unknown else "",
    ]
    return "; ".join(filter(None, said))


def _for_how_long(rows: Sequence[tuple[str, str, Summary]], beyond: str, in_a_case: bool) -> str:
    """That the filters of cases were wrongly sure, and the largest share of the time."""
    labels = list(dict.fromkeys(label for _, label, _ in rows))
    case, label, worst = max(rows, key=lambda row: row[-1].wrongly_sure.value)
    return (
        f"{_names(labels)} {'were' if len(labels) > 1 else 'was'} wrongly sure{beyond} "
        f"{'at most ' if len(rows) > 1 else ''}{f'{_names([label])} ' if len(labels) > 1 else ''}for "
        f"{interval(worst.wrongly_sure / PERCENT, ' %')} of the converged time"
        + (f" in {case}" if in_a_case else "")
    )


def _is_above_chance(one: Summary) -> bool:
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
