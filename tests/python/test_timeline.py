"""One clock and one rule of windows: every command gives the same figure of the same run, to the last bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from sim_scenarios import provenance, simulation
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import judge
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master
from sim_scenarios.studies.ensemble import gathered, outputs, thinned
from sim_scenarios.studies.quantities import kept
from sim_scenarios.timeline import inside, instants, whole, within
from sim_scenarios.units import ARCMIN

DURATION = 62.0
STEPS = st.sampled_from([0.001, 0.0025, 0.005, 0.01, 0.02, 0.05, 0.1])


@dataclass(frozen=True)
class OneRun:
    """The same run by the Python master and, with the clock that it has, by the compiled loop."""

    by_master: xr.Dataset
    by_loop: xr.Dataset


@pytest.fixture(scope="module")
def one_run(fmus: Fmus) -> OneRun:
    settings = {"duration": DURATION, "evaluation.start": 20.0, "evaluation.stop": 41.4}
    scenario = load_scenario("swaying_ship", fmus, seed=1, settings=settings)
    filters = {"EKF": scenario.filters()["EKF"]}
    python, loop = (
        simulation.thin(scenario, fmus, filters, outputs(), master=master)
        for master in (Master.python, Master.compiled)
    )
    for data in (python, loop):
        data.attrs = provenance.attributes(scenario, fmus)
    return OneRun(python, loop)


def test_both_masters_have_one_clock(one_run: OneRun) -> None:
    np.testing.assert_array_equal(one_run.by_master["time"], one_run.by_loop["time"])


@given(
    tenths=st.tuples(st.integers(0, 600), st.integers(1, 200)), rounding=st.sampled_from([-1e-9, 0.0, 1e-9])
)
def test_compare_campaign_and_bands_agree_to_the_last_bit(
    one_run: OneRun, tenths: tuple[int, int], rounding: float
) -> None:
    """Whatever the window, and however its ends have been rounded."""
    start, length = tenths
    window = {
        "evaluation.start": 0.1 * start + rounding,
        "evaluation.stop": 0.1 * (start + length) + rounding,
    }
    compared, campaigned = (
        data.sel(filter="EKF").assign_attrs(window) for data in (one_run.by_master, one_run.by_loop)
    )
    verdict, of_campaign = judge(compared), kept(campaigned, 1.0)
    assert verdict.figures()["heading_rmse_arcmin"] == float(of_campaign["heading_rmse"]) / ARCMIN
    assert judge(campaigned).to_json() == verdict.to_json()
    runs = gathered([thinned(one_run.by_master.assign_attrs(window))])
    band = runs.figure("heading", "EKF", (window["evaluation.start"], window["evaluation.stop"]))
    assert band == verdict.figures()["heading_rmse_arcmin"]
    held = inside(one_run.by_master["time"].values, *window.values())
    assert held.sum() == min(start + length, round(10 * DURATION)) - start + 1


def test_the_window_that_two_clocks_and_three_rules_told_apart(one_run: OneRun) -> None:
    assert within(one_run.by_master["time"].values, one_run.by_master["time"].values, 20.0, 41.4)[-1] == (
        pytest.approx(41.4)
    )
    band = gathered([thinned(one_run.by_loop)]).figure("heading", "EKF", (20.0, 41.4))
    assert band == judge(one_run.by_master.sel(filter="EKF")).figures()["heading_rmse_arcmin"]


@given(step=STEPS, steps=st.integers(1, 20_000), every=st.integers(1, 500))
def test_recorded_instants_are_instants_of_the_run(step: float, steps: int, every: int) -> None:
    all_of_them = instants(steps * step, step)
    assert len(all_of_them) == steps + 1
    np.testing.assert_array_equal(instants(steps * step, step, every), all_of_them[::every])


@given(step=STEPS, first=st.integers(0, 5000), more=st.integers(0, 5000))
def test_a_window_has_both_its_ends(step: float, first: int, more: int) -> None:
    """Ends as people write them, in decimals, and as sums."""
    time = instants(10_000 * step, step)
    for start, stop in (
        (first * step, (first + more) * step),
        (round(first * step, 6), round(first * step, 6) + more * step),
    ):
        np.testing.assert_array_equal(np.flatnonzero(inside(time, start, stop)), first + np.arange(more + 1))


def test_a_span_that_is_no_number_of_steps_is_refused() -> None:
    assert whole(600.0, 0.01, "duration") == 60_000
    with pytest.raises(
        InputError, match=r"duration = 1.005 s: must be a whole multiple of the step of 0.01 s"
    ):
        whole(1.005, 0.01, "duration")
    with pytest.raises(InputError, match=r"nothing is recorded between 3 s and 4 s"):
        within(np.array([0.0, 1.0]), np.array([0.0, 1.0]), 3.0, 4.0)
