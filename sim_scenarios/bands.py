"""Monte-Carlo runs against the bands that the filters must keep: python -m sim_scenarios.bands -n 50.

The figure of a filter is the root mean square of its heading error over runs and over 300 to 600 s. A band is
the figure of an independent prototype of the filters with about three standard deviations, of such a figure
of 50 runs, on either side; fewer runs scatter more. Where a filter is meant to fail, its band is open above.
Seeds are 1 to n. Prints a table in Markdown; the exit code is 1 when a band is missed.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.metrics.alignment import judge
from sim_scenarios.simulation import compare
from sim_scenarios.units import ARCMIN

Array = NDArray[np.float64]
Range = tuple[float, float]


@dataclass(frozen=True)
class Check:
    """A scenario, the bands [arcmin] of its filters by label, and bands of ratios between two of them."""

    scenario: str
    bands: Mapping[str, Range]
    ratios: Mapping[tuple[str, str], Range] = field(default_factory=dict)


CHECKS = (
    Check(
        "swaying_ship",
        {"EKF": (11, 19), "UKF": (11, 19), "robust UKF": (11, 19)},
        {("robust UKF, L = I (printed)", "UKF"): (0.97, 1.03)},
    ),
    Check("zigzag", {"EKF": (4, 7.5), "UKF": (4, 7.5)}),
    Check(
        "overconfident_prior",
        {"UKF": (35, 50), "robust UKF, heading only": (24, 38)},
        {("UKF", "robust UKF, heading only"): (1.2, 1.6)},
    ),
    Check("gnss_outliers", {"UKF, gate": (11, 19), "UKF, no gate": (40, float("inf"))}),
)


@dataclass(frozen=True)
class Row:
    """A line of the table: what was measured, and whether it keeps its band."""

    scenario: str
    what: str
    value: float
    spread: Range | None
    band: Range

    @property
    def ok(self) -> bool:
        """Whether the value lies in the band."""
        return self.band[0] <= self.value <= self.band[1]

    def markdown(self) -> str:
        """The line in Markdown."""
        low, high = self.band
        band = f"{low:g} to {high:g}" if np.isfinite(high) else f"above {low:g}"
        spread = f"{self.spread[0]:.2f} to {self.spread[1]:.2f}" if self.spread else ""
        kept = "ok" if self.ok else "**missed**"
        return f"| {self.scenario} | {self.what} | {self.value:.2f} | {spread} | {band} | {kept} |"


HEADING = "| scenario | filter | RMSE ['] | smallest to largest run | band | |\n|---|---|---|---|---|---|"


def heading_rmse(scenario: str, seed: int) -> dict[str, float]:
    """Heading RMSE [arcmin] of every filter that a scenario compares."""
    runs = compare(scenario, seed=seed)
    return {
        str(label): judge(runs.sel(filter=label)).heading_rmse / ARCMIN for label in runs["filter"].values
    }


def rows(check: Check, runs: list[dict[str, float]]) -> Iterator[Row]:
    """Lines of a check from the figures of its runs."""
    each = {label: np.array([run[label] for run in runs]) for label in runs[0]}
    total = {label: float(np.sqrt(np.mean(values**2))) for label, values in each.items()}
    for label, band in check.bands.items():
        spread = float(each[label].min()), float(each[label].max())
        yield Row(check.scenario, label, total[label], spread, band)
    for (label, reference), band in check.ratios.items():
        yield Row(check.scenario, f"{label} / {reference}", total[label] / total[reference], None, band)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m sim_scenarios.bands", description=__doc__)
    parser.add_argument("-n", type=int, default=50, metavar="RUNS", help="runs of each scenario (default 50)")
    parser.add_argument(
        "--only",
        nargs="+",
        metavar="SCENARIO",
        choices=[check.scenario for check in CHECKS],
        help="scenarios to check (default: all)",
    )
    parser.add_argument("--workers", type=int, default=max(2, os.cpu_count() or 2), help="processes")
    arguments = parser.parse_args()
    checks = [check for check in CHECKS if not arguments.only or check.scenario in arguments.only]
    seeds = range(1, arguments.n + 1)
    print(HEADING)
    kept = True
    with ProcessPoolExecutor(arguments.workers) as pool:
        for check in checks:
            runs = list(pool.map(heading_rmse, [check.scenario] * len(seeds), seeds))
            for row in rows(check, runs):
                print(row.markdown(), flush=True)
                kept &= row.ok
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
