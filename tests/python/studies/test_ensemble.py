"""Many runs together: their figures on errors made up for it, and runs in a pool of processes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_up import run_with

import sim_scenarios
from sim_scenarios import simulation
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import figures, judge
from sim_scenarios.metrics.figures import FIGURES
from sim_scenarios.provenance import attributes
from sim_scenarios.recording import of_filter
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master
from sim_scenarios.studies import ensemble as ensembles
from sim_scenarios.studies import execution
from sim_scenarios.studies.ensemble import ESTIMATED_NOISE, Ensemble, ensemble, gathered, outputs, thinned
from sim_scenarios.units import ARCMIN

SHORT = {"duration": 40.0, "evaluation.start": 20.0}


def test_a_figure_is_taken_over_its_window_in_its_unit() -> None:
    headings = np.array([[60.0, 8, 1, 1, 7], [60.0, 8, 1, 1, 1]]) * ARCMIN
    how = {"window": (2.0, 4.0), "limit": 5.1 * ARCMIN, "position": [3.0, 4.0, 7.0]}
    runs = Ensemble(
        {
            label: [run_with(np.arange(5.0), heading=size * heading, **how) for heading in headings]
            for label, size in (("a", 1), ("b", 2))
        }
    )
    assert runs.figure("heading", "a") == pytest.approx(np.sqrt((5 + 49) / 6))
    assert runs.figure("heading", "a", window=(1.0, 1.0)) == pytest.approx(8)
    assert runs.figure("heading", "b", over="a") == pytest.approx(2)
    assert runs.figure("horizontal", "a") == pytest.approx(5)
    assert runs.of_each("heading", "a") == pytest.approx([np.sqrt(17), 1.0])
    assert runs.figure("settling", "a") == 2.0  # of the whole run, whatever the window
    with pytest.raises(InputError, match=r"nothing is recorded between 7 s and 9 s"):
        runs.figure("heading", "a", window=(7.0, 9.0))


@pytest.mark.parametrize("error", ["heading", "attitude", "velocity", "position"])
def test_the_largest_difference_of_two_filters_is_that_of_any_error(error: str) -> None:
    """In any run, at any time; in SI units."""
    one, other = (np.zeros((3, 1 if error == "heading" else 3)) for _ in range(2))
    other[1, 0] = 1e-6
    made = [[run_with(np.arange(3.0), **{error: e.squeeze()}) for e in (one, last)] for last in (one, other)]
    runs = Ensemble(dict(zip(("a", "b"), made, strict=True)))
    assert runs.largest_difference("a", "a") == 0
    assert runs.largest_difference("a", "b") == pytest.approx(1e-6)


def test_what_is_kept_of_a_run_makes_the_figures_of_the_whole_run(outliers: xr.Dataset) -> None:
    """All of them, of every filter, to the last bit."""
    window = figures.window(outliers)
    for label, (run,) in gathered([thinned(outliers)]).filters.items():
        whole = of_filter(outliers, label)
        for name, figure in FIGURES.items():
            assert np.array_equal(figure.of(run, window), figure.of(whole, window), equal_nan=True), name


def test_for_figures_of_other_packages_all_is_kept_that_they_may_be_made_of(
    outliers: xr.Dataset, register: Callable[[dict[str, str]], None]
) -> None:
    """Beside what they need that no figure of ours does, but still no covariance."""
    assert "nav.height" not in thinned(outliers)
    register({"peak": "own_figures:heading_peak"})
    kept = thinned(outliers)
    there = {"nav.height", "truth.gyro_bias", "robust.gamma_effective", "used_fixes"}
    assert there <= {*map(str, outliers.data_vars)}
    assert there <= {*map(str, kept.data_vars)}
    assert "covariance" not in kept


@pytest.mark.parametrize(
    ("scenario", "label", "settings"),
    [
        ("swaying_ship", "UKF", SHORT),
        ("flight_varying_noise", "VB, rho 0.99", SHORT),  # estimated sigmas
        ("flight_loose_tight", "tight", SHORT),
    ],
)
def test_the_compiled_loop_makes_the_errors_of_the_python_master(
    fmus: Fmus, scenario: str, label: str, settings: dict[str, object]
) -> None:
    loaded = load_scenario(scenario, fmus, seed=5, settings=settings)
    filters = {label: loaded.filters()[label]}
    python = simulation.thin(loaded, fmus, filters, outputs(), master=Master.python)
    loop = simulation.thin(loaded, fmus, filters, outputs())
    for run in (python, loop):
        run.attrs = attributes(loaded, fmus)
    made = thinned(loop)
    xr.testing.assert_equal(made, thinned(python))
    assert np.isfinite(made["nees"]).all()
    assert (made[ESTIMATED_NOISE] > 0).any()


@pytest.fixture(scope="module")
def pooled(fmus: Fmus) -> Ensemble:  # noqa: ARG001  (there must be FMUs)
    shares: list[float] = []
    with execution.workers(2, None) as workers:
        runs = ensemble(workers, "swaying_ship", [3, 4, 5], ["UKF", "EKF"], SHORT, shares.append)
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    return runs


def test_runs_of_a_pool_are_those_of_a_comparison(pooled: Ensemble, fmus: Fmus) -> None:
    alone = sim_scenarios.compare("swaying_ship", seed=4, set=SHORT, fmus=fmus)
    assert list(pooled.filters) == ["UKF", "EKF"]
    assert pooled.count == 3
    for label, runs in pooled.filters.items():
        verdict = judge(alone.sel(filter=label))
        each = pooled.of_each("heading", label)
        assert each[1] == verdict.figures()["heading_rmse_arcmin"]
        assert len(set(each)) == 3
        for error in ("velocity_error", "attitude_error"):
            np.testing.assert_array_equal(runs[1][error], alone[error].sel(filter=label))


def test_a_filter_that_is_not_compared_is_refused(fmus: Fmus) -> None:  # noqa: ARG001
    refused = pytest.raises(InputError, match=r"no filter 'UFK'; did you mean 'UKF'\?")
    with execution.workers(1, None) as workers, refused:
        ensemble(workers, "swaying_ship", [1], ["UFK"], SHORT)


def test_gathered_keeps_the_order_of_the_runs(fmus: Fmus) -> None:
    runs = [
        thinned(sim_scenarios.compare("overconfident_prior", seed=s, set=SHORT, fmus=fmus)) for s in (2, 1)
    ]
    together = gathered(runs)
    for one, run in zip(together.filters["UKF"], runs, strict=True):
        xr.testing.assert_equal(one, run.sel(filter="UKF", drop=True))


def test_a_worker_with_other_fmus_is_refused(fmus: Fmus, tmp_path: Path) -> None:  # noqa: ARG001
    others = {"TruthPlant": "of yesterday"}
    with execution.workers(1, None) as workers, pytest.raises(InputError, match="a worker has other FMUs"):
        ensemble(workers, "swaying_ship", [1], ["UKF"], SHORT, kept=tmp_path, versions=others)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"", b"CDF", b"something else", None])
def test_a_kept_run_that_is_damaged_is_done_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: bytes | None
) -> None:
    """And once only; a run that is whole is not done at all."""
    done: list[int] = []

    def run(_: object, seed: int, *__: object) -> xr.Dataset:
        done.append(seed)
        return xr.Dataset({"errors": ("time", np.arange(1000.0))})

    monkeypatch.setattr(ensembles, "_run", run)
    monkeypatch.setattr(ensembles, "thinned", lambda made: made)
    arguments = ([7], "waves", ["UKF"], {}, tmp_path, None, None)
    (first,) = ensembles._runs(*arguments)
    whole = ensembles.run_file(tmp_path, 7).read_bytes()
    ensembles.run_file(tmp_path, 7).write_bytes(whole[: len(whole) // 2] if content is None else content)
    for _ in range(2):
        (again,) = ensembles._runs(*arguments)
        xr.testing.assert_identical(again, first)
    assert done == [7, 7]
    assert ensembles.run_file(tmp_path, 7).read_bytes() == whole
