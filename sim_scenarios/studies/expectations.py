"""What is expected of the figures of a study, what was measured, and whether that is within its band.

Expectations are tables of a TOML file, of a campaign as of a paper ::

    [[expect]]
    window = [300.0, 600.0]              # s; that of the evaluation, if left out
    cases = ["zigzag"]                   # those of the campaign that are meant; all, if left out
    why = "Three standard deviations of such a figure on either side of an independent prototype's"

    [expect.figures]                     # filter, ratio of two, or difference: figures of `metrics.figures`
    "EKF" = { heading = [11.0, 19.0], failures = [-0.5, 0.5] }
    "UKF" = { horizontal = { mean = 3.56, deviation = 0.72 }, nees_at_end = { states = 12 } }
    "UKF / EKF" = { heading = 1.0, settling = "sooner" }
    "UKF - EKF" = { largest_difference = [0.0, 1e-7] }

A band is two limits in the unit in which people read the figure, or what makes them: `REACH` standard
deviations of a single run on either side of a prototype's mean, or the 95 % interval of a consistent filter
of so many states, whatever the number of runs. A number or a word is what somebody else says: it stands
beside what is measured, and nothing is missed. `why` is a sentence, or one for each figure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from sim_scenarios.fmus import did_you_mean
from sim_scenarios.metrics.figures import Figure, known
from sim_scenarios.metrics.folds import OF_ERRORS
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.scenario.tables import Table
from sim_scenarios.studies.measured import Measured
from sim_scenarios.studies.quantities import Asked
from sim_scenarios.timeline import Window

Array = NDArray[np.float64]

OVER: Final = " / "
"""Between the two filters of a ratio."""
MINUS: Final = " - "
"""Between two filters that are to be one."""
DIFFERENCE: Final = "largest_difference"
"""What is expected of these: the largest difference of any error at any time, in SI units."""
REACH: Final = 1.1
"""Of a band around a mean, in standard deviations of a single run."""


def known_name(what: str, name: str, names: list[str]) -> str:
    """A name, if it is one of those that there are."""
    if name in names:
        return name
    hint = did_you_mean(name, names) or f"; there are {', '.join(names)}"
    raise ValueError(f"there is no {what} '{name}'{hint}")


def _figure(name: str) -> str:
    return known_name("figure", name, [*known(), DIFFERENCE])


def _band(given: object) -> object:
    """Limits of a band, of what stands for them."""
    if isinstance(given, list | tuple) and len(given) == 2:
        return {"low": given[0], "high": given[1]}
    if isinstance(given, Mapping) and given.keys() == {"mean", "deviation"}:
        mean, reach = given["mean"], REACH * given["deviation"]
        return {"low": mean - reach, "high": mean + reach}
    return given


class Band(Table):
    """What a figure must lie in; of a NEES with so many states, its 95 % interval."""

    low: float = -math.inf
    high: float = math.inf
    states: int | None = None

    @model_validator(mode="after")
    def _is_open(self) -> Band:
        if not self.low < self.high:
            raise ValueError(f"{self.low:g} to {self.high:g}: the first must be below the second")
        return self

    def of(self, runs: int) -> Band:
        """The band of so many runs."""
        if self.states is None:
            return self
        low, high = (limit / (self.states * runs) for limit in chi_square_interval(self.states * runs))
        return Band(low=low, high=high)


FigureName = Annotated[str, AfterValidator(_figure)]
Expected = Annotated[Band, BeforeValidator(_band)] | float | str


class Expectations(Table):
    """What is expected of filters, or said of them, over one window."""

    title: str = ""
    window: Window | None = None
    cases: tuple[str, ...] = ()
    figures: dict[str, dict[FigureName, Expected]]
    why: str | dict[FigureName, str] = Field(default="")

    @model_validator(mode="after")
    def _differences_are_of_two(self) -> Expectations:
        for what, expected in self.figures.items():
            if (DIFFERENCE in expected) is not (MINUS in what) or (MINUS in what and len(expected) > 1):
                raise ValueError(f"{what}: {DIFFERENCE} is of two filters, such as 'UKF{MINUS}EKF', alone")
        return self

    def filters(self) -> list[str]:
        """Filters that it is of."""
        return list(dict.fromkeys(label for what in self.figures for label in _two(what)))

    def reasons(self) -> list[str]:
        """Why, in sentences."""
        if isinstance(self.why, str):
            return [self.why] if self.why else []
        return [f"{_title(name)}: {why}" for name, why in self.why.items()]


def asked(expectations: Iterable[Expectations]) -> Asked:
    """What must be kept of the runs of a campaign."""
    figures = [(one.window, name) for one in expectations for of in one.figures.values() for name in of]
    named = [(name, window) for window, name in figures if name != DIFFERENCE]
    errors = len(named) < len(figures) or any(known()[name].fold is OF_ERRORS for name, _ in named)
    return Asked(tuple(dict.fromkeys(named)), errors)


@dataclass(frozen=True)
class Row:
    """A figure that something is expected of.

    Attributes
    ----------
    what : str
        Filter, or the two of a ratio or a difference.
    figure : str
        Name in `metrics.figures`, or `DIFFERENCE`.
    expected : Band or float or str
        In the unit of the figure; a ratio has none.
    measured : float
        Over all runs.
    interval : tuple of float or None
        Of 95 %; None of a figure that has none, or of a single run.
    spread : tuple of float or None
        Smallest and largest of a single run.
    case : str
        Of a campaign.
    """

    what: str
    figure: str
    expected: Band | float | str
    measured: float
    interval: Window | None
    spread: Window | None
    case: str = ""

    @property
    def title(self) -> str:
        """The figure with its unit."""
        return _title(self.figure) if OVER in self.what else _title(self.figure, with_unit=True)

    @property
    def missed(self) -> bool:
        """Whether it has a band, and does not lie in it."""
        band = self.expected
        return isinstance(band, Band) and not band.low <= self.measured <= band.high

    def cells(self, digits: int = 3) -> list[str]:
        """A line of a table: filter, figure, expected, measured, interval, single runs."""
        return [
            self.what,
            self.title,
            _text(self.expected, digits),
            _text(self.measured, digits),
            _range(self.interval),
            _range(self.spread),
        ]

    def to_json(self) -> dict[str, Any]:
        """The same for machines."""
        unit = "" if self.figure == DIFFERENCE else known()[self.figure].reading.sign
        band = self.expected
        return {
            "filter": self.what,
            "figure": self.figure,
            "unit": "1" if OVER in self.what else unit,
            **(
                {"case": self.case, "band": _finite(band.low, band.high), "missed": self.missed}
                if isinstance(band, Band)
                else {"printed": band}
            ),
            "measured": _finite(self.measured)[0],
            "interval": self.interval,
            "smallest_and_largest_run": self.spread and _finite(*self.spread),
        }


def rows(expectations: Expectations, measured: Measured, case: str = "") -> Iterator[Row]:
    """What is expected, beside what was measured."""
    for what, figures in expectations.figures.items():
        for name, expected in figures.items():
            band = expected.of(measured.count) if isinstance(expected, Band) else expected
            yield Row(what, name, band, *_measured(what, name, measured, expectations.window), case)


def _measured(
    what: str, name: str, measured: Measured, window: Window | None
) -> tuple[float, Window | None, Window | None]:
    one, *other = _two(what)
    if name == DIFFERENCE:
        return measured.largest_difference(one, *other), None, None
    value = measured.figure(name, one, window, *other)
    each = [measured.of_each(name, label, window) for label in (one, *other)]
    spread = None if other else (float(each[0].min()), float(each[0].max()))
    return value, _interval(known()[name], each), spread


def _title(name: str, with_unit: bool = False) -> str:
    if name == DIFFERENCE:
        return "largest difference [SI]"
    return known()[name].label if with_unit else known()[name].title


def _two(what: str) -> list[str]:
    return what.split(MINUS if MINUS in what else OVER)


def _interval(figure: Figure, each: Sequence[Array]) -> Window | None:
    """Interval of a figure, or of the ratio of two filters over the same runs, from those of single runs."""
    if len(each) == 1:
        estimate = figure.fold.estimate(each[0])
    elif figure.fold.ratio is not None:
        estimate = figure.fold.ratio(*each)
    else:
        return None
    return (estimate.lower, estimate.upper) if math.isfinite(estimate.lower) else None


def _finite(*values: float) -> list[float | None]:
    return [value if math.isfinite(value) else None for value in values]


def _range(of: Window | None) -> str:
    return " to ".join(_text(value) for value in of) if of else ""


def _text(value: Band | float | str, digits: int = 3) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, Band):
        low, high = (f"{limit:.{digits}g}" for limit in (value.low, value.high))
        return f"{low} to {high}" if math.isfinite(value.high) else f"above {low}"
    if math.isinf(value):
        return "never"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.{digits}g}"
