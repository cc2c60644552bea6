"""Verdict on integrated navigation: position, velocity, tilt and heading over the evaluation window.

Yardstick is what the receiver alone would give: a filter that knows the horizontal position worse than a
single fix does has not navigated.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from sim_scenarios.attitude import wrap
from sim_scenarios.metrics.statistics import nees_of, rms, within
from sim_scenarios.metrics.verdict import UNFIT, Rmse, Verdict, of_fixes, status_at_end, window
from sim_scenarios.units import ARCMIN


@dataclass(frozen=True, kw_only=True, repr=False)
class NavigationVerdict(Verdict):
    """How well a filter navigated: root mean square errors of a run over the window; SI units.

    `ok`: the horizontal RMSE is within the limit, and the filter is neither waiting nor coasting nor faulted
    at the end.

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
    """

    horizontal: float
    vertical: float
    velocity: float
    tilt: float
    yaw: float
    limit: float
    horizontal_sigma: float | None
    nees: float | None

    @property
    def rmse(self) -> Rmse:
        """That of the horizontal position."""
        return Rmse("horizontal [m]", self.horizontal)

    def sentence(self) -> str:
        """The verdict in a sentence."""
        rmse = f"horizontal RMSE {self.horizontal:.2f} m"
        if self.ok:
            return f"Navigated: {rmse} (limit {self.limit:.2f} m), heading {self.yaw / ARCMIN:.2f} arcmin"
        if not self.fit:
            return f"Not navigated: the filter is {self.status} at the end; {rmse}"
        return f"Not navigated: {rmse} is beyond the limit of {self.limit:.2f} m"

    def headline(self) -> dict[str, str]:
        """Headline figures of a run."""
        sigma = {} if self.horizontal_sigma is None else {"Filter's own": f"{self.horizontal_sigma:.2f} m"}
        consistency = {} if self.nees is None else {"Mean NEES / states": f"{self.nees:.3f}"}
        return {
            "Horizontal RMSE": f"{self.horizontal:.2f} m",
            **sigma,
            "Vertical RMSE": f"{self.vertical:.2f} m",
            "Velocity RMSE": f"{self.velocity:.4f} m/s",
            "Tilt RMSE": f"{self.tilt / ARCMIN:.3f} arcmin",
            "Heading RMSE": f"{self.yaw / ARCMIN:.3f} arcmin",
            **consistency,
            **self._fix_figures(),
        }

    def row(self) -> dict[str, str]:
        """Figures of a line in a comparison."""
        return {
            "horiz.\n[m]": f"{self.horizontal:.2f}",
            "vert.\n[m]": f"{self.vertical:.2f}",
            "veloc.\n[m/s]": f"{self.velocity:.4f}",
            "tilt\n[']": f"{self.tilt / ARCMIN:.3f}",
            "head.\n[']": f"{self.yaw / ARCMIN:.3f}",
            "within\nlimit": "yes" if self.ok else "no",
            **self._fix_cells(),
        }

    def figures(self) -> dict[str, Any]:
        """Figures for machines."""
        return {
            "within_limit": self.ok,
            "horizontal_rmse_m": self.horizontal,
            "horizontal_limit_m": self.limit,
            "horizontal_sigma_m": self.horizontal_sigma,
            "vertical_rmse_m": self.vertical,
            "velocity_rmse_m_per_s": self.velocity,
            "tilt_rmse_arcmin": self.tilt / ARCMIN,
            "heading_rmse_arcmin": self.yaw / ARCMIN,
            "nees_per_state": self.nees,
        }


def judge(run: xr.Dataset) -> NavigationVerdict:
    """Verdict on the navigation of one filter of a run (a data set of `sim_scenarios.run`)."""
    start, stop = window(run)
    time = run["time"].values

    def inside(name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
        return within(time, run[name].values, start, stop)

    position, attitude = inside("position_error"), wrap(inside("attitude_error"))
    horizontal, limit = rms(position[:, :2]), float(run.attrs["evaluation.horizontal_limit"])
    status = status_at_end(run)
    sigma = rms(inside("position_sigma")[:, :2]) if "position_sigma" in run else None
    return NavigationVerdict(
        ok=bool(horizontal <= limit and status not in UNFIT),
        status=status,
        horizontal=horizontal,
        vertical=rms(position[:, 2]),
        velocity=rms(inside("velocity_error")),
        tilt=rms(attitude[:, :2]),
        yaw=rms(wrap(inside("heading_error"))),
        limit=limit,
        horizontal_sigma=sigma,
        nees=float(np.mean(within(time, nees_of(run), start, stop))) if "covariance" in run else None,
        **of_fixes(run),
    )
