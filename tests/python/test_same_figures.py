"""Whoever tells a figure of a run tells the same one, to the last bit: compare, campaign, bands and papers.

Runs are recorded arrays that are made up: no window, step or period may tell them apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from made_up import run_with

from sim_scenarios.fmus import NAVIGATION_FILTER
from sim_scenarios.metrics import judge
from sim_scenarios.metrics.figures import FIGURES
from sim_scenarios.recording import of_filter
from sim_scenarios.studies.ensemble import gathered, thinned
from sim_scenarios.studies.expectations import Expectations, asked, rows
from sim_scenarios.studies.quantities import kept, variable
from sim_scenarios.timeline import RESOLUTION, Window, inside, instants
from sim_scenarios.units import ARCMIN

STATUS = {"flag_values": [1, 2, 3], "flag_meanings": "waiting aligning converged"}


@dataclass(frozen=True)
class Made:
    """A run of two filters, and the period at which a campaign keeps its series [s]."""

    run: xr.Dataset
    window: Window
    period: float


@st.composite
def runs(draw: st.DrawFn) -> Made:
    """Any clock, and any window that has an instant: on instants, beside them, rounded."""
    step = draw(st.sampled_from([0.001, 0.0025, 0.01, 0.02, 0.05, 0.1, 1.0]))
    every, count = draw(st.sampled_from([1, 2, 5, 10])), draw(st.integers(2, 120))
    time = instants(step * every * count, step, every)
    first = draw(st.integers(0, count))
    last = draw(st.integers(first, count))
    off = st.sampled_from([-0.4, 0.0, 0.4])
    rounding = st.sampled_from([-1e-9, 0.0, 1e-9])
    start = time[first] + draw(off) * step * every * (last > first + 1) + draw(rounding)
    stop = time[last] + draw(off) * step * every * (last > first + 1) + draw(rounding)
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    navigating = draw(st.booleans())
    filters = xr.DataArray(["UKF", "EKF"], dims="filter", name="filter")
    both = [recorded(time, rng) for _ in filters]
    run = xr.concat(both, dim=filters, combine_attrs="override").assign_attrs(
        {
            "evaluation.start": float(start),
            "evaluation.stop": float(stop),
            "filter_fmu": NAVIGATION_FILTER if navigating else "AlignmentFilter",
        }
    )
    period = step * every * draw(st.integers(1, count))
    return Made(run, (float(start), float(stop)), period)


def recorded(time: np.ndarray, rng: np.random.Generator) -> xr.Dataset:
    """A run of one filter at some instants, with errors of all sizes and a fix every now and then."""
    count, fixes = len(time), len(time) // 3
    vectors = {name: rng.standard_normal((count, 3)) for name in ("attitude", "velocity", "position")}
    run = run_with(time, limit=0.7, heading=rng.standard_normal(count), **vectors)
    channels = (np.arange(6) < rng.integers(0, 7, fixes)[:, None]).astype(float)
    covariance = np.eye(12) + 0.1 * rng.random((12, 12))
    run = run.assign(
        heading_sigma=("time", rng.random(count)),
        position_sigma=(("time", "axis3"), rng.random((count, 3))),
        converged=("time", rng.random(count) < 0.5),
        status=("time", rng.integers(1, 4, count), STATUS),
        covariance=(("time", "row12", "column12"), np.tile((covariance + covariance.T) / 2, (count, 1, 1))),
        nis=("fix", rng.random(fixes)),
        innovation_sigma=(("fix", "axis6"), channels),
        fix_used=("fix", rng.random(fixes) < 0.8),
        rejected_fixes=("fix", np.arange(fixes)),
    )
    run["truth.velocity"] = ("time", "axis3"), rng.standard_normal((count, 3))
    return run.assign_coords(fix_time=("fix", time[1 : 3 * fixes : 3]))


# What bands and papers call a figure, where a campaign keeps it, what a verdict calls it, and its unit.
SAME = [
    ("heading", "heading_rmse", "heading_rmse_arcmin", ARCMIN),
    ("yaw", "heading_rmse", "heading_rmse_arcmin", ARCMIN),
    ("horizontal", "horizontal_rmse", "horizontal_rmse_m", 1.0),
    ("vertical", "vertical_rmse", "vertical_rmse_m", 1.0),
    ("velocity", "velocity_rmse", "velocity_rmse_m_per_s", 1.0),
    ("tilt", "tilt_rmse", "tilt_rmse_arcmin", ARCMIN),
    ("heading_end", "heading_end", "heading_end_arcmin", ARCMIN),
    ("heading_sigma_rms", "heading_sigma_rms", "heading_sigma_arcmin", ARCMIN),
    ("horizontal_sigma_rms", None, "horizontal_sigma_m", 1.0),
    ("convergence_time", "convergence_time", "convergence_time_s", 1.0),
    ("claimed_time", "claimed_time", "claimed_time_s", 1.0),
    ("sure_time", "sure_time", "sure_for_s", 1.0),
    ("wrongly_sure_time", "wrongly_sure_time", "wrongly_sure_for_s", 1.0),
    ("longest_wrongly_sure", "longest_wrongly_sure", "longest_wrongly_sure_s", 1.0),
    ("nis", None, "nis_per_channel", 1.0),
    ("nees", None, "nees_per_state", 1.0),
    ("used_fixes", "used_fixes", "used_fixes", 1.0),
    ("rejected_fixes", "rejected_fixes", "rejected_fixes", 1.0),
]


def told(value: float) -> float | None:
    """A figure as machines are told it: None where there is none."""
    return value if math.isfinite(value) else None


@given(made=runs())
def test_compare_campaign_bands_and_papers_agree_to_the_last_bit(made: Made) -> None:
    together = gathered([thinned(made.run)])
    for label in ("UKF", "EKF"):
        one = of_filter(made.run, label)
        verdict = judge(one).to_json()
        printed = {label: {ours: 0.0 for ours, *_ in SAME}}
        of_band, of_paper = Expectations(figures=printed), Expectations(window=made.window, figures=printed)
        stored = kept(one, made.period, asked([of_band, of_paper]))
        found_of_paper = [told(row.measured) for row in rows(of_paper, together)]
        assert found_of_paper == [told(row.measured) for row in rows(of_band, together)]
        for (ours, kept_as, called, size), found in zip(SAME, found_of_paper, strict=True):
            assert told(FIGURES[ours].of(one, made.window) / size) == found, ours
            for window in (None, made.window):
                assert told(float(stored[variable(ours, window)]) / size) == found, ours
            if kept_as is not None:
                assert told(float(stored[kept_as]) / size) == found, ours
            if called in verdict:
                assert verdict[called] == found, ours
        assert stored["success"] == judge(one).ok


@given(made=runs())
def test_a_figure_is_of_the_instants_between_the_ends_of_its_window(made: Made) -> None:
    """An oracle without the rule of windows: instants one by one, in steps."""
    time, (start, stop) = made.run["time"].values, made.window
    held = [k for k, t in enumerate(time.tolist()) if start - RESOLUTION <= t <= stop + RESOLUTION]
    np.testing.assert_array_equal(np.flatnonzero(inside(time, start, stop)), held)
    up = made.run["position_error"].sel(filter="UKF").values[held, 2]
    found = gathered([thinned(made.run)]).figure("vertical", "UKF", made.window)
    assert found == pytest.approx(math.sqrt(math.fsum(up**2) / len(held)), rel=1e-12)
