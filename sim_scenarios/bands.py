"""Monte-Carlo runs against the bands that the filters must keep: python -m sim_scenarios.bands -n 50.

A figure is taken over a window and over all runs (`metrics.figures`). A band is the figure of an independent
prototype of the filters with, for an alignment, about three standard deviations of such a figure of 50 runs
on either side, and for navigation 1.1 standard deviations of a single run; fewer runs scatter more. Where a
filter is meant to fail, its band is open above. Seeds are 1 to n. Prints a table in Markdown; the exit code
is 1 when a band is missed.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from sim_scenarios.ensemble import Ensemble, ensemble
from sim_scenarios.metrics.figures import known
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.processes import processes
from sim_scenarios.timeline import Window


@dataclass(frozen=True)
class Band:
    """What a figure of a filter must lie in, or its ratio to another filter's, or their difference.

    Attributes
    ----------
    label : str
        Filter that the scenario compares.
    low, high : float
    figure : str
        Name in `metrics.figures`.
    over : str or None
        Filter to divide by.
    minus : str or None
        Filter that may differ in nothing by more: the largest difference of any error, in SI units.
    states : int or None
        Of a NEES: the band is its 95 % interval, whatever the number of runs.
    """

    label: str
    low: float
    high: float
    figure: str = "heading"
    over: str | None = None
    minus: str | None = None
    states: int | None = None

    def of(self, runs: int) -> Band:
        """The band of so many runs."""
        if self.states is None:
            return self
        low, high = (limit / (self.states * runs) for limit in chi_square_interval(self.states * runs))
        return replace(self, low=low, high=high)

    @property
    def what(self) -> str:
        """The filter, or the two."""
        if self.minus:
            return f"{self.label} - {self.minus}"
        return f"{self.label} / {self.over}" if self.over else self.label

    @property
    def title(self) -> str:
        """The figure with its unit."""
        if self.minus:
            return "largest difference [SI]"
        figure = known()[self.figure]
        return figure.title if self.over else figure.label


@dataclass(frozen=True)
class Check:
    """A scenario with settings, the bands of its filters, and how many runs they are meant for."""

    scenario: str
    bands: Sequence[Band]
    runs: int = 50
    settings: Mapping[str, object] = field(default_factory=dict)
    case: str = ""

    @property
    def title(self) -> str:
        """The scenario, and what the settings make of it."""
        return f"{self.scenario}, {self.case}" if self.case else self.scenario

    @property
    def labels(self) -> list[str]:
        """Filters that are needed."""
        names = [name for band in self.bands for name in (band.label, band.over, band.minus) if name]
        return list(dict.fromkeys(names))


def at_rest() -> list[Band]:
    """Bands of Zhao 2012's three cases."""
    filters = ("EKF", "UKF")
    tilts = [Band(label, 0.15, 0.45, tilt) for tilt in ("tilt_east", "tilt_north") for label in filters]
    headings = [Band(label, 15, 21) for label in filters]
    return [*headings, *tilts, Band("UKF", 0.97, 1.03, over="EKF")]


def from_far(*labels: str) -> list[Band]:
    """Bands of filters that start with a heading that is far off."""
    return [
        band
        for label in labels
        for band in (
            Band(label, 11, 19),
            Band(label, -0.5, 0.5, "failures"),
            Band(label, 0, 260, "median_settling"),
        )
    ]


def wrong_by(angle: float) -> dict[str, object]:
    """Settings of a heading error at the start [deg]."""
    return {"initial_error.misalignment": ["0.5 deg", "0.5 deg", f"{angle:g} deg"]}


NAVIGATION = ("horizontal", "vertical", "velocity", "tilt", "yaw")


def navigation(
    label: str, *prototype: tuple[float, float], figures: Sequence[str] = NAVIGATION
) -> list[Band]:
    """Bands of mean and standard deviation of a prototype's runs, in the order of the figures."""
    return [
        Band(label, mean - 1.1 * deviation, mean + 1.1 * deviation, figure)
        for figure, (mean, deviation) in zip(figures, prototype, strict=True)
    ]


CLEAN = ((3.56, 0.72), (1.23, 0.24), (0.0389, 0.0061), (0.199, 0.036), (0.576, 0.34))

SOONER = Band("UKF", 0.65, 0.90, "settling", over="EKF")

CHECKS = (
    Check(
        "swaying_ship",
        [
            *(Band(label, 11, 19) for label in ("EKF", "UKF", "robust UKF", "invariant")),
            Band("robust UKF, L = I (printed)", 0.97, 1.03, over="UKF"),
        ],
    ),
    Check("zigzag", [Band(label, 4, 7.5) for label in ("EKF", "UKF", "invariant")]),
    Check("turn", [Band("UKF", 4.5, 8), Band("invariant", 4.2, 7.5)]),
    *(
        Check(
            "any_heading",
            from_far("invariant", "invariant, no coarse stage"),
            settings=wrong_by(angle),
            case=f"{angle} deg",
        )
        for angle in (60, 90, 150)
    ),
    Check(
        "coloured_noise",
        [
            Band("invariant", 24, 32),
            Band("invariant, wider white noise", 18, 27),
            Band("invariant, Gauss-Markov states", 0, 18),
        ],
    ),
    Check(
        "overconfident_prior",
        [
            Band("UKF", 35, 50),
            Band("robust UKF, heading only", 24, 38),
            Band("UKF", 1.2, 1.6, over="robust UKF, heading only"),
        ],
    ),
    Check("gnss_outliers", [Band("UKF, gate", 11, 19), Band("UKF, no gate", 40, float("inf"))]),
    Check("static_large_misalignment", [*at_rest(), SOONER], runs=100),
    Check("static_large_misalignment_azimuth", [*at_rest(), SOONER], runs=100),
    Check("static_large_misalignment_small", at_rest(), runs=100),
    Check(
        "flight_constant_speed",
        [
            *(band for label in ("EKF", "UKF", "augmented UKF") for band in navigation(label, *CLEAN)),
            *(Band("EKF", 0.98, 1.02, figure, over="UKF") for figure in NAVIGATION),
            Band("UKF", 0.98, 1.02, "nis"),
            Band("UKF", 0, np.inf, "nees_at_end", states=12),
            Band("UKF", 0, 1e-7, minus="EKF"),
        ],
        runs=20,
    ),
    Check(
        "flight_outliers",
        [
            *navigation("UKF", (13.4, 3.1), (4.6, 1.3), (0.139, 0.025), (0.51, 0.18), (1.21, 0.46)),
            *navigation("IGG", (3.57, 0.71), (1.24, 0.24), (0.0392, 0.0066), (0.201, 0.037), (0.58, 0.35)),
            Band("IGG", 0.26, 0.31, "velocity", over="UKF"),
        ],
        runs=20,
    ),
    Check(
        "flight_varying_noise",
        [
            *navigation("UKF", (10.1, 1.2), (4.55, 1.1), (0.382, 0.030), (4.41, 0.33), (7.9, 2.7)),
            *navigation("VB, rho 0.99", (9.7, 1.3), (3.15, 1.1), (0.260, 0.033), (2.26, 0.30), (3.6, 1.4)),
        ],
        runs=10,
    ),
    Check(
        "flight_accelerometer_fault",
        [
            *navigation("UKF", (104.59, 0.81), figures=["horizontal"]),
            *navigation("adaptive factor", (3.19, 0.32), figures=["horizontal"]),
            *navigation("IGG with guard", (3.42, 0.55), figures=["horizontal"]),
        ],
        runs=20,
    ),
    Check("car_odometer", [Band("with all of them", 0, 0.1, "horizontal_at_end", over="without")], runs=20),
    Check("gnss_outage_turn", navigation("UKF", (36, 23), figures=["horizontal_at_end"]), runs=20),
    Check("gnss_outage_turn_tight", navigation("UKF", (2.98, 1.6), figures=["horizontal_at_end"]), runs=20),
    Check(
        "flight_loose_tight",
        [
            *navigation("loose", (0.996, 0.21), figures=["horizontal"]),
            *navigation("tight", (0.673, 0.18), figures=["horizontal"]),
        ],
        runs=20,
    ),
)


@dataclass(frozen=True)
class Row:
    """A line of the table: what was measured, and whether it keeps its band."""

    check: Check
    band: Band
    runs: int
    value: float
    spread: Window | None

    @property
    def ok(self) -> bool:
        """Whether the value lies in the band."""
        return self.band.low <= self.value <= self.band.high

    def markdown(self) -> str:
        """The line in Markdown."""
        band = self.band
        limits = f"{band.low:.4g} to {band.high:.4g}" if np.isfinite(band.high) else f"above {band.low:g}"
        cells = (
            self.check.title,
            band.what,
            band.title,
            f"{self.value:.4g}",
            "{:.3g} to {:.3g}".format(*self.spread) if self.spread else "",
            limits,
            "ok" if self.ok else "**missed**",
            f"`--only {self.check.scenario} -n {self.runs}`",
        )
        return f"| {' | '.join(cells)} |"


HEADING = (
    "| scenario | filter | figure | measured | smallest to largest run | band | | command |\n"
    "|---|---|---|---|---|---|---|---|"
)


def rows(check: Check, runs: Ensemble, count: int) -> Iterator[Row]:
    """Lines of a check from its runs."""
    for band in (band.of(count) for band in check.bands):
        if band.minus:
            yield Row(check, band, count, runs.largest_difference(band.label, band.minus), None)
            continue
        value = runs.figure(band.figure, band.label, over=band.over)
        each = runs.of_each(band.figure, band.label)
        yield Row(check, band, count, value, None if band.over else (float(each.min()), float(each.max())))


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m sim_scenarios.bands", description=__doc__)
    parser.add_argument(
        "-n", type=int, metavar="RUNS", help="runs of each scenario (default: those that its bands are for)"
    )
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="SCENARIO",
        choices=list(dict.fromkeys(check.scenario for check in CHECKS)),
        help="scenarios to check (default: all)",
    )
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    arguments = parser.parse_args()
    checks = [check for check in CHECKS if not arguments.only or check.scenario in arguments.only]
    print(HEADING)
    kept = True
    with processes(arguments.workers) as pool:
        for check in checks:
            count = arguments.n or check.runs
            runs = ensemble(pool, check.scenario, range(1, count + 1), check.labels, check.settings)
            for row in rows(check, runs, count):
                print(row.markdown(), flush=True)
                kept &= row.ok
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
