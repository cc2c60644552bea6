"""The verdict on an alignment, on made-up runs."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy.stats import chi2
from statuses import BAD, FLAGS, ITEMS

from sim_scenarios.metrics import judge
from sim_scenarios.metrics.alignment import AlignmentVerdict
from sim_scenarios.units import ARCMIN, DEGREE

TIME = np.arange(601.0)


def recorded(error: np.ndarray, status: int = 3) -> xr.Dataset:
    """A run with a given heading error, a fix each second of which the first is rejected."""
    return xr.Dataset(
        {
            "heading_error": ("time", error),
            "heading_sigma": ("time", np.full(601, 10 * ARCMIN)),
            "converged": ("time", TIME >= 100),
            "status": ("time", np.full(601, status), FLAGS),
            "nis": ("fix", np.full(600, 2.0)),
            "innovation_sigma": (("fix", "axis3"), np.tile([0.1, 0.1, 0.0], (600, 1))),  # up is not measured
            "fix_used": ("fix", TIME[1:] > 1),
            "rejected_fixes": ("fix", np.ones(600, dtype=int)),
        },
        coords={"time": TIME, "fix_time": ("fix", TIME[1:])},
        attrs={
            "evaluation.start": 300.0,
            "evaluation.stop": 600.0,
            "evaluation.heading_limit": 0.5 * DEGREE,
            "bound.heading_rms": 5 * ARCMIN,
        },
    )


def test_verdict() -> None:
    verdict = judge(recorded(np.where(TIME < 150, 1.0, 20 * ARCMIN)))
    assert isinstance(verdict, AlignmentVerdict)
    assert verdict.ok
    assert verdict.heading_rmse == pytest.approx(20 * ARCMIN)
    assert verdict.convergence_time == 150
    assert verdict.claimed_time == 100
    assert verdict.nis.mean == pytest.approx(1)
    assert verdict.nis.count == 301
    assert (verdict.used_fixes, verdict.rejected_fixes) == (599, 1)
    json = verdict.to_json()
    assert json["heading_rmse_arcmin"] == pytest.approx(20)
    assert json["bound_arcmin"] == pytest.approx(5)
    assert json["nis_consistent"] is True
    assert json["nis_interval"] == pytest.approx(np.array(chi2.interval(0.95, 602)) / 602)


def test_a_large_error_or_a_late_divergence_is_no_convergence() -> None:
    assert not judge(recorded(np.full(601, 31 * ARCMIN))).ok
    assert not judge(recorded(np.where(TIME < 600, 0.0, 31 * ARCMIN))).ok
    assert judge(recorded(np.full(601, 29 * ARCMIN))).ok


@pytest.mark.parametrize(("status", "word"), BAD)
def test_a_filter_that_cannot_be_relied_on_has_not_converged(status: int, word: str) -> None:
    verdict = judge(recorded(np.zeros(601), status))
    assert not verdict.ok
    assert f"the filter is {word} at the end" in verdict.sentence()
    assert verdict.to_json()["status"] == word


def test_a_run_without_a_fix_or_a_bound_has_a_verdict() -> None:
    run = recorded(np.zeros(601)).isel(fix=slice(0, 0))
    del run.attrs["bound.heading_rms"]
    verdict = judge(run)
    assert isinstance(verdict, AlignmentVerdict)
    assert verdict.ok
    assert (verdict.bound, verdict.used_fixes) == (None, 0)
    json = verdict.to_json()
    assert json["bound_arcmin"] is json["nis_per_channel"] is json["nis_interval"] is None
    assert json["nis_consistent"] is None
    assert verdict.headline()["Mean NIS / channels"] == "no fix was used"


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_filter_that_puts_out_no_number_has_a_verdict(value: float) -> None:
    """In JSON as None, which every reader takes."""
    run = recorded(np.where(TIME < 400, 0.0, value))
    run["heading_sigma"][400:] = value
    run["nis"][400:] = value
    verdict = judge(run)
    assert not verdict.ok
    figures = json.loads(json.dumps(verdict.to_json(), allow_nan=False))
    assert figures["heading_rmse_arcmin"] is figures["nis_per_channel"] is None
    assert figures["heading_sigma_arcmin"] is figures["heading_end_arcmin"] is None
    assert figures["bound_arcmin"] == pytest.approx(5)


def test_it_reads_in_arcminutes() -> None:
    text = str(judge(recorded(np.full(601, 20 * ARCMIN))))
    assert text.startswith("Converged: heading RMSE 20.00 arcmin")
    assert "Cramer-Rao bound: 5.00 arcmin (RMS over many runs; one run may lie below)" in text
    assert "Filter's own sigma: 10.00 arcmin" in text
    without = judge(recorded(np.full(601, 20 * ARCMIN)).drop_vars("heading_sigma"))
    assert without.headline()["Filter's own sigma"] == "none"


@pytest.mark.parametrize(
    ("reports", "words"),
    [
        (TIME >= 100, "since 100 s"),
        ((TIME >= 100) & (TIME < 122), "not at the end, for 22.0 s before"),
        (TIME < 0, "never"),
    ],
)
def test_it_says_for_how_long_the_filter_reported_convergence(reports: np.ndarray, words: str) -> None:
    verdict = judge(recorded(np.zeros(601)).assign(converged=("time", reports)))
    assert verdict.headline()["Filter reports convergence"] == words
    assert verdict.to_json()["reports_convergence"] is bool(reports[-1])


def test_it_says_converged_only_of_a_filter_that_does() -> None:
    aligning = judge(recorded(np.zeros(601), status=2))
    assert ITEMS["aligning"] == 2
    assert aligning.ok
    assert aligning.sentence().startswith("Within the limit, but the filter is still aligning: heading RMSE")
    for run in (recorded(np.zeros(601)), recorded(np.zeros(601)).drop_vars("status")):
        assert judge(run).sentence().startswith("Converged: heading RMSE")
