"""An alignment that is handed over to navigation: plant and two filters, in both orders of the master."""

from __future__ import annotations

import json
import re
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import sim_scenarios
from sim_scenarios import connection, provenance, recording
from sim_scenarios.cli.application import app
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import judge
from sim_scenarios.report import report_comparison, report_run
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master, Order
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.runs import Bench
from sim_scenarios.studies.store import State

STEP = 0.01
SOON = {
    "alignment.error_model": "large_azimuth",
    "alignment.prior.heading_sigma": "0.4 deg",
    "alignment.convergence.hold_time": 5.0,  # s, from the first fix on
    "initial_error.misalignment": ["0.1 deg", "0.1 deg", "0.3 deg"],
    "duration": 30.0,
    "evaluation.start": 15.0,
    "evaluation.stop": 30.0,
}
NEVER = {**SOON, "alignment.convergence.heading_sigma": "0.1 arcmin"}
COVARIANCE = [f"covariance[{i},{j}]" for i in range(1, 13) for j in range(1, 13)]


def said_start(run: xr.Dataset) -> float:
    """When navigation starts, by what the filter says."""
    (start,) = re.findall(r"filter: navigation starts at ([0-9.]+) s", run.attrs["messages"])
    return float(start)


@pytest.fixture(scope="module", params=list(Order))
def run(request: pytest.FixtureRequest, fmus: Fmus) -> xr.Dataset:
    settings = {**SOON, "recording_period": STEP}
    return sim_scenarios.run("align_then_navigate", set=settings, order=request.param, fmus=fmus)


@pytest.fixture(scope="module")
def soon(fmus: Fmus) -> xr.Dataset:
    return sim_scenarios.run("align_then_navigate", set=SOON, fmus=fmus)


@pytest.fixture(scope="module")
def never(fmus: Fmus) -> xr.Dataset:
    return sim_scenarios.run("align_then_navigate", set=NEVER, fmus=fmus)


def test_navigation_begins_when_the_log_says(run: xr.Dataset) -> None:
    """A Jacobi master steps once more before it shows."""
    start = float(run["hand_over_time"])
    assert said_start(run) == pytest.approx(6.0, abs=STEP)
    assert said_start(run) - 1e-9 <= start <= said_start(run) + STEP + 1e-9
    first = int(np.argmax(run["alignment.converged"].values))
    assert run["time"].values[first] == pytest.approx(said_start(run))


def test_before_the_hand_over_there_are_no_errors_and_no_fixes(run: xr.Dataset) -> None:
    start = float(run["hand_over_time"])
    waits = run["time"].values < start
    assert set(run["status"].values[waits]) == {1}  # waiting
    for name in ("heading_error", "attitude_error", "position_error", "velocity_error"):
        assert np.isnan(run[name].values[waits]).all(), name
        assert np.isfinite(run[name].values[~waits]).all(), name
    assert np.isfinite(run["alignment.heading_error"].values).all()
    assert run["fix_time"].values[0] == 7.0
    assert run["fix_used"].values.all()


def test_the_first_heading_is_the_one_handed_over(run: xr.Dataset) -> None:
    """In the order of Jacobi navigation and alignment have both gone on by one sample since."""
    first = int(np.searchsorted(run["time"].values, float(run["hand_over_time"])))
    for name in ("nav.heading", "heading_sigma"):
        taken, handed = run[name].values[first], run[f"alignment.{name}"].values[first]
        assert taken == pytest.approx(handed, rel=1e-6), name
    assert run["alignment.heading_error"].values[first] == pytest.approx(
        run["heading_error"].values[first], abs=1e-8
    )


def test_jacobi_is_gauss_seidel_one_step_late(fmus: Fmus) -> None:
    settings = {**SOON, "recording_period": STEP}
    gauss_seidel, jacobi = (
        sim_scenarios.run("align_then_navigate", set=settings, order=order, fmus=fmus) for order in Order
    )
    for name in ("alignment.nav.heading", "alignment.heading_sigma", "alignment.converged"):
        np.testing.assert_array_equal(jacobi[name].values[1:], gauss_seidel[name].values[:-1], err_msg=name)
    since = jacobi["time"].values[1:] >= float(jacobi["hand_over_time"])
    for name in ("nav.heading", "nav.velocity", "gyro_bias", "covariance", "truth.heading"):
        np.testing.assert_array_equal(
            jacobi[name].values[1:][since], gauss_seidel[name].values[:-1][since], err_msg=name
        )


def test_the_covariance_is_taken_over(fmus: Fmus) -> None:
    scenario = load_scenario("align_then_navigate", fmus, settings=SOON)
    with ExitStack() as stack:
        source, sinks = connection.connect(scenario, fmus, scenario.filters(), stack)
        assert source.alignment is not None
        for k in range(round(scenario.duration / STEP)):
            source.advance(k * STEP, STEP)
            for sink in sinks:
                sink.receive()
                sink.advance(k * STEP, STEP)
            if source.signals.value("initial.valid"):
                break
        handed, *taken = (
            np.reshape(instance.read(COVARIANCE), (12, 12))
            for instance in (source.alignment, *(sink.instance for sink in sinks))
        )
    sigma = np.sqrt(np.diag(handed))
    assert (sigma > 0).all()
    assert len(taken) == 3
    for covariance in taken:
        np.testing.assert_allclose(
            covariance / np.outer(sigma, sigma), handed / np.outer(sigma, sigma), rtol=0, atol=1e-9
        )


@pytest.mark.parametrize("seed", [1, 2])
def test_errors_keep_within_four_sigma(fmus: Fmus, seed: int) -> None:
    """From a heading wrong by 150 deg, through hand-over and turn; one normal error in 16000 is beyond."""
    settings = {"duration": 500.0, "evaluation.start": 300.0, "recording_period": 1.0}
    run = sim_scenarios.run("align_then_navigate", seed=seed, set=settings, fmus=fmus)
    assert judge(run).ok, judge(run)
    assert float(run["hand_over_time"]) < 300
    navigating = recording.under_way(run)
    for error, sigma in (
        ("attitude_error", "misalignment_sigma"),
        ("velocity_error", "velocity_sigma"),
        ("position_error", "position_sigma"),
    ):
        size = np.abs(navigating[error].values)
        assert (size < 4 * navigating[sigma].values).all(), error
    assert abs(float(run["heading_error"][-1])) < 4 * float(run["heading_sigma"][-1]) < np.radians(0.5)


def test_the_report_tells_of_the_hand_over(soon: xr.Dataset, tmp_path: Path) -> None:
    text = report_run(soon, tmp_path).read_text(encoding="utf-8")
    assert "Alignment handed over" in text
    assert "Parameters of the alignment" in text
    assert "alignment: converged at" in text
    names = {path.stem for path in tmp_path.glob("*.png")}
    assert names == {"hand_over", "navigation", "states", "innovations", "nis", "corrections"}


def test_the_data_set_survives_a_file(soon: xr.Dataset, tmp_path: Path) -> None:
    recording.save(soon, tmp_path / "run.nc")
    assert recording.load(tmp_path / "run.nc").identical(soon)


def test_one_alignment_is_handed_over_to_all_that_are_compared(fmus: Fmus, tmp_path: Path) -> None:
    runs = sim_scenarios.compare("align_then_navigate", set=SOON, fmus=fmus)
    assert list(runs["filter"].values) == ["loose", "invariant", "tight"]
    np.testing.assert_array_equal(runs["hand_over_time"].values, np.full(3, 6.0))
    assert runs["alignment.heading_error"].dims == ("time",)
    assert "at 6.0 s" in report_comparison(runs, tmp_path).read_text(encoding="utf-8")
    assert (tmp_path / "comparison.png").is_file()


# ------------------------------------------------------------------ an alignment that does not converge


def test_what_never_converged_has_not_navigated(never: xr.Dataset, tmp_path: Path) -> None:
    verdict = judge(never)
    assert not verdict.ok
    assert "Not navigated: the alignment has not converged; it is aligning at the end" in verdict.sentence()
    assert np.isnan(float(never["hand_over_time"]))
    assert np.isnan(never["heading_error"].values).all()
    assert never.sizes["fix"] == 0
    json.dumps(verdict.to_json(), allow_nan=False)
    assert verdict.sentence() in report_run(never, tmp_path).read_text(encoding="utf-8")
    assert [path.stem for path in tmp_path.glob("*.png")] == ["hand_over"]


def test_the_commands_say_so_too(tmp_path: Path) -> None:
    settings = [part for key, value in NEVER.items() for part in ("--set", f"{key}={value}")]
    for command in ("run", "compare"):
        arguments = [command, "align_then_navigate", "--output", str(tmp_path / command), *settings]
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 1, result.output
        assert re.search(r"Alignment handed over +never", result.stdout)


@pytest.fixture
def bench(fmus: Fmus) -> Bench:
    return Bench(1.0, Master.auto, fmus)


def test_in_a_campaign_it_counts_as_a_failure(bench: Bench, fmus: Fmus) -> None:
    for settings, state in ((SOON, State.finished), (NEVER, State.failed)):
        (case,) = cases(load_plan("align_then_navigate", set=settings, filters=("loose",)), fmus)
        outcome = bench.run(case, 3, provenance.attributes(case.scenario, fmus))
        assert outcome.state == {"loose": state}
        assert ("loose: the alignment has not converged" in outcome.failure) == (state is State.failed)
        assert all(np.isfinite(values["horizontal_rmse"]) for values in outcome.kept.values())
        assert all(values["hand_over_time"] == 6.0 for values in outcome.kept.values())
