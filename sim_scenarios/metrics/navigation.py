"""Verdict on integrated navigation: position, velocity, tilt and heading over the evaluation window.

Yardstick is what the receiver alone would give: a filter that knows the horizontal position worse than a
single fix does has not navigated. Nor has one that waits for an alignment when the window begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import xarray as xr

from sim_scenarios.metrics import hand_over
from sim_scenarios.metrics.figures import over_evaluation
from sim_scenarios.metrics.hand_over import HandOver
from sim_scenarios.metrics.verdict import Rmse, Verdict, cell, common, given, known
from sim_scenarios.units import ARCMIN


@dataclass(frozen=True, kw_only=True, repr=False)
class NavigationVerdict(Verdict):
    """How well a filter navigated: root mean square errors of a run over the window; SI units.

    `ok`: the horizontal RMSE is within the limit, and the status of the end is one of `status.FIT`. Errors
    are NaN if the filter had no start by the window.

    Attributes
    ----------
    horizontal, vertical : float
        Position [m].
    velocity : float
        All three components [m/s].
    tilt : float
        Both misalignments about horizontal axes [rad].
    yaw : float
        Heading [rad].
    limit : float
        Of the horizontal RMSE [m]; that of a single fix unless the scenario says otherwise.
    horizontal_sigma : float or None
        RMS over the window of the horizontal sigma that the filter claims [m].
    nees : float or None
        Mean over the window, for each state of `statistics.nees_of`; of filters that put out a covariance.
    hand_over : HandOver or None
        Of an alignment that precedes.
    """

    horizontal: float
    vertical: float
    velocity: float
    tilt: float
    yaw: float
    limit: float
    horizontal_sigma: float | None
    nees: float | None
    hand_over: HandOver | None = None

    @property
    def within_limit(self) -> bool:
        """Whether the horizontal RMSE is, whatever the filter says of itself."""
        return self.horizontal <= self.limit

    @property
    def rmse(self) -> Rmse:
        """That of the horizontal position."""
        return Rmse("horizontal [m]", self.horizontal)

    def sentence(self) -> str:
        """The verdict in a sentence."""
        if self.hand_over is not None and not self.hand_over.in_time:
            return f"Not navigated: {self.hand_over.failure()}"
        rmse = f"horizontal RMSE {self.horizontal:.2f} m"
        if self.ok:
            doubt = (
                ", but its NIS is larger than its covariance allows" if self.nis.mean > self.nis.upper else ""
            )
            figures = f"{rmse} (limit {self.limit:.2f} m), heading {self.yaw / ARCMIN:.2f} arcmin"
            return f"Navigated: {figures}{doubt}"
        if not self.fit:
            return f"Not navigated: the filter is {self.status} at the end; {rmse}"
        return f"Not navigated: {rmse} is beyond the limit of {self.limit:.2f} m"

    def headline(self) -> dict[str, str]:
        """Headline figures of a run."""
        handed = {} if self.hand_over is None else self.hand_over.headline()
        if self.hand_over is not None and not self.hand_over.in_time:
            return {**handed, **self._common_figures()}
        sigma = {} if self.horizontal_sigma is None else {"Filter's own": f"{self.horizontal_sigma:.2f} m"}
        consistency = {} if self.nees is None else {"Mean NEES / states": f"{self.nees:.3f}"}
        return {
            **handed,
            "Horizontal RMSE": f"{self.horizontal:.2f} m",
            **sigma,
            "Vertical RMSE": f"{self.vertical:.2f} m",
            "Velocity RMSE": f"{self.velocity:.4f} m/s",
            "Tilt RMSE": f"{self.tilt / ARCMIN:.3f} arcmin",
            "Heading RMSE": f"{self.yaw / ARCMIN:.3f} arcmin",
            **consistency,
            **self._common_figures(),
        }

    def row(self) -> dict[str, str]:
        """Figures of a line in a comparison."""
        doubt = "" if self.fit else f", {self.status}"
        return {
            "horiz.\n[m]": cell(self.horizontal, 2),
            "vert.\n[m]": cell(self.vertical, 2),
            "veloc.\n[m/s]": cell(self.velocity, 4),
            "tilt\n[']": cell(self.tilt / ARCMIN, 3),
            "head.\n[']": cell(self.yaw / ARCMIN, 3),
            "within\nlimit": ("yes" if self.within_limit else "no") + doubt,
            **self._fix_cells(),
        }

    def figures(self) -> dict[str, Any]:
        """Figures for machines."""
        return {
            "within_limit": self.within_limit,
            "navigated": self.ok,
            "horizontal_rmse_m": known(self.horizontal),
            "horizontal_limit_m": self.limit,
            "horizontal_sigma_m": self.horizontal_sigma,
            "vertical_rmse_m": known(self.vertical),
            "velocity_rmse_m_per_s": known(self.velocity),
            "tilt_rmse_arcmin": known(self.tilt / ARCMIN),
            "heading_rmse_arcmin": known(self.yaw / ARCMIN),
            "nees_per_state": self.nees,
            **({} if self.hand_over is None else self.hand_over.figures()),
        }


def judge(run: xr.Dataset) -> NavigationVerdict:
    """Verdict on the navigation of one filter of a run (a data set of `sim_scenarios.run`)."""
    figure, handed = over_evaluation(run), hand_over.of_run(run)
    began = handed is None or handed.in_time
    return NavigationVerdict(
        horizontal=figure("horizontal_rmse"),
        vertical=figure("vertical_rmse"),
        velocity=figure("velocity_rmse"),
        tilt=figure("tilt_rmse"),
        yaw=figure("heading_rmse"),
        limit=float(run.attrs["evaluation.horizontal_limit"]),
        horizontal_sigma=given(figure("horizontal_sigma_rms")) if began else None,
        nees=given(figure("nees")),
        hand_over=handed,
        **common(run),
    )
