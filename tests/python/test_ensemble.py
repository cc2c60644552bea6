"""Figures of many runs: their arithmetic on errors made up for it, and runs in a pool of processes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import ensemble as ensembles
from sim_scenarios.ensemble import (
    COLUMNS,
    FIGURES,
    FIX_OUTPUTS,
    HEADING,
    HORIZONTAL,
    NEES,
    NIS,
    NOISE,
    OUTPUTS,
    POSITION,
    TILT_EAST,
    VELOCITY,
    Ensemble,
    Errors,
    at_end,
    ensemble,
    errors_of_run,
    failures,
    gathered,
    largest,
    mean,
    mean_rmse,
    median_settling,
    rmse,
    settling,
)
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import judge
from sim_scenarios.processes import processes
from sim_scenarios.runner import Runner, why_no_container
from sim_scenarios.scenario import load_scenario
from sim_scenarios.simulation import attributes
from sim_scenarios.units import ARCMIN

SHORT = {"duration": 40.0, "evaluation.start": 20.0}


def errors(values: object, limit: float = 1.0) -> Errors:
    array = np.asarray(values, dtype=float)
    return Errors(np.arange(array.shape[1], dtype=float), array, limit)


def test_statistics_of_two_runs() -> None:
    two = errors([[[3.0, 4.0], [0.0, 0.0]], [[0.0, -6.0], [8.0, 0.0]]])
    assert rmse(two) == pytest.approx(np.sqrt((25 + 0 + 36 + 64) / 4))
    assert mean_rmse(two) == pytest.approx((np.sqrt(12.5) + np.sqrt(50)) / 2)
    assert largest(two) == pytest.approx((4 + 8) / 2)
    assert at_end(two) == pytest.approx((0 + 8) / 2)
    assert mean(errors([[[1.0], [np.nan], [2.0]]])) == pytest.approx(1.5)


def test_settling_is_of_the_root_mean_square_over_runs() -> None:
    runs = [[5.0, 1.0, 1.0, 0.0], [5.0, 1.0, 0.5, 0.0]]
    one = errors(np.array(runs)[:, :, None], limit=0.9)
    assert settling(one) == 2.0  # the first run alone settles at 3 s, the second at 2 s
    assert [settling(run) for run in one.runs()] == [3.0, 2.0]
    assert settling(errors([[[2.0], [2.0]]])) == float("inf")


def test_the_median_run_settles_and_a_failed_one_is_counted() -> None:
    runs = [[5.0, 1.0, 0.0], [5.0, 0.5, 0.0], [5.0, 5.0, 5.0]]
    three = errors(np.array(runs)[:, :, None], limit=0.9)
    assert median_settling(three) == 2.0  # of 2 s, 1 s and never
    assert failures(three) == 3  # the first two by the 5.0 that they begin with
    assert failures(three.part(0, (1.0, 2.0))) == 1


def test_a_run_has_failed_whose_root_mean_square_is_beyond_twice_the_limit() -> None:
    runs = errors(np.array([[1.99, 1.99], [2.01, 2.01], [0.0, 3.0]])[:, :, None], limit=1.0)
    assert failures(runs) == 2  # 3 / 2^0.5 = 2.12


def test_every_component_of_the_position_has_its_own_figure() -> None:
    values = np.zeros((2, 3, COLUMNS))
    values[:, :, POSITION] = [3.0, 4.0, 7.0]
    runs = Ensemble({"a": errors(values)}, {"evaluation.start": 0.0, "evaluation.stop": 2.0})
    assert [runs.figure(name, "a") for name in ("horizontal", "vertical")] == pytest.approx([5.0, 7.0])


def test_a_figure_is_taken_over_its_window_in_its_unit() -> None:
    values = np.zeros((2, 5, COLUMNS))
    values[:, :, HEADING] = np.array([[60.0, 8, 1, 1, 7], [60.0, 8, 1, 1, 1]]) * ARCMIN
    values[:, :, HORIZONTAL] = [3.0, 4.0]
    runs = Ensemble(
        {"a": errors(values, limit=5 * ARCMIN), "b": errors(2 * values, limit=5 * ARCMIN)},
        {"evaluation.start": 2.0, "evaluation.stop": 4.0},
    )
    assert runs.figure("heading", "a") == pytest.approx(np.sqrt((5 + 49) / 6))
    assert runs.figure("heading", "a", window=(1.0, 1.0)) == pytest.approx(8)
    assert runs.figure("heading", "b", over="a") == pytest.approx(2)
    assert runs.figure("horizontal", "a") == pytest.approx(5)
    assert FIGURES["heading"].of_each(runs.filters["a"], runs.window) == pytest.approx([np.sqrt(17), 1.0])
    assert runs.figure("settling", "a") == 2.0  # of the whole run, whatever the window
    with pytest.raises(InputError, match=r"nothing is recorded between 7 s and 9 s"):
        runs.figure("heading", "a", window=(7.0, 9.0))


@pytest.mark.parametrize(
    ("scenario", "label", "settings"),
    [
        ("swaying_ship", "UKF", SHORT),
        ("flight_varying_noise", "VB, rho 0.99", SHORT),  # estimated sigmas
        ("flight_loose_tight", "tight", SHORT),
    ],
)
def test_the_container_makes_the_errors_of_the_python_master(
    fmus: Fmus, scenario: str, label: str, settings: dict[str, object]
) -> None:
    loaded = load_scenario(scenario, fmus, seed=5, settings=settings)
    runner, filters = Runner(OUTPUTS, FIX_OUTPUTS, fmus=fmus), {label: loaded.filters()[label]}
    if not runner.uses_container(loaded):
        pytest.skip(str(why_no_container(loaded, fmus)))
    master, container = (runner.simulated(loaded, filters, container=by) for by in (False, True))
    for run in (master, container):
        run.attrs = attributes(loaded, fmus)
    made = errors_of_run(container)["errors"].values
    np.testing.assert_array_equal(made, errors_of_run(master)["errors"].values)
    assert np.isfinite(made[:, :, NEES]).all()
    assert np.isfinite(made[:, :, NOISE]).any()  # at fixes


@pytest.fixture(scope="module")
def pooled(fmus: Fmus) -> Ensemble:  # noqa: ARG001  (there must be FMUs)
    shares: list[float] = []
    with processes(2) as pool:
        runs = ensemble(pool, "swaying_ship", [3, 4, 5], ["UKF", "EKF"], SHORT, shares.append)
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    return runs


def test_runs_of_a_pool_are_those_of_a_comparison(pooled: Ensemble, fmus: Fmus) -> None:
    alone = sim_scenarios.compare("swaying_ship", seed=4, set=SHORT, fmus=fmus)
    assert list(pooled.filters) == ["UKF", "EKF"]
    assert pooled.count == 3
    for label, runs in pooled.filters.items():
        verdict = judge(alone.sel(filter=label))
        each = FIGURES["heading"].of_each(runs, pooled.window)
        assert each[1] == pytest.approx(verdict.figures()["heading_rmse_arcmin"], rel=1e-12)
        assert len(set(each)) == 3
        np.testing.assert_array_equal(
            runs.values[1, :, VELOCITY], alone["velocity_error"].sel(filter=label).values
        )
        np.testing.assert_allclose(
            runs.values[1, :, TILT_EAST],
            alone["attitude_error"].sel(filter=label).values[:, 0],
            rtol=0,
            atol=1e-15,  # of wrapping
        )


def test_nis_stands_where_a_fix_was_used(pooled: Ensemble, fmus: Fmus) -> None:
    run = sim_scenarios.compare("swaying_ship", seed=3, set=SHORT, fmus=fmus)
    column = pooled.filters["UKF"].values[0, :, NIS]
    used = run["fix_used"].sel(filter="UKF").values
    assert np.isfinite(column).sum() == used.sum()
    assert np.nansum(column) == pytest.approx(run["nis"].sel(filter="UKF").values[used].sum() / 2)
    at = pooled.filters["UKF"].time[np.isfinite(column)]
    np.testing.assert_allclose(at, run["fix_time"].values[used], atol=0.05)


def test_a_filter_that_is_not_compared_is_refused(fmus: Fmus) -> None:  # noqa: ARG001
    with processes(1) as pool, pytest.raises(InputError, match=r"no filter 'UFK'; did you mean 'UKF'\?"):
        ensemble(pool, "swaying_ship", [1], ["UFK"], SHORT)


def test_gathered_keeps_the_order_of_the_runs(fmus: Fmus) -> None:
    runs = [
        errors_of_run(sim_scenarios.compare("overconfident_prior", seed=s, set=SHORT, fmus=fmus))
        for s in (2, 1)
    ]
    together = gathered(runs)
    for i, run in enumerate(runs):
        np.testing.assert_array_equal(
            together.filters["UKF"].values[i], run["errors"].sel(filter="UKF").values
        )


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
    monkeypatch.setattr(ensembles, "errors_of_run", lambda made: made)
    arguments = ("waves", [7], ["UKF"], {}, tmp_path, None)
    (first,) = ensembles._runs(*arguments)
    whole = ensembles.run_file(tmp_path, 7).read_bytes()
    ensembles.run_file(tmp_path, 7).write_bytes(whole[: len(whole) // 2] if content is None else content)
    for _ in range(2):
        (again,) = ensembles._runs(*arguments)
        xr.testing.assert_identical(again, first)
    assert done == [7, 7]
    assert ensembles.run_file(tmp_path, 7).read_bytes() == whole
