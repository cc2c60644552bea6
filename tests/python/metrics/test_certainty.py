"""Wrongly sure, on made-up runs whose figures are known to the row."""

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.metrics import certainty

ROWS = 100
PERIOD = 0.5
VECTOR = ("time", "axis3")


@pytest.fixture
def run() -> xr.Dataset:
    """A filter that is sure from row 10 on, with errors of half a sigma; the height velocity is no state."""
    return xr.Dataset(
        {
            "heading_error": ("time", np.full(ROWS, 0.5e-3)),
            "heading_sigma": ("time", np.full(ROWS, 1e-3)),
            "velocity_error": (VECTOR, np.tile([0.05, -0.05, 9.0], (ROWS, 1))),
            "velocity_sigma": (VECTOR, np.tile([0.1, 0.1, 0.0], (ROWS, 1))),
            "position_error": (VECTOR, np.full((ROWS, 3), 1.0)),
            "position_sigma": (VECTOR, np.full((ROWS, 3), 2.0)),
            "converged": ("time", np.arange(ROWS) >= 10),
        },
        coords={"time": PERIOD * np.arange(ROWS)},
    )


def test_a_filter_that_is_right_is_not_wrongly_sure(run: xr.Dataset) -> None:
    found = certainty.of_run(run)
    assert (found.sure, found.wrongly, found.longest) == (90 * PERIOD, 0, 0)
    assert found.headline() == {}


def test_every_wrong_row_counts_once(run: xr.Dataset) -> None:
    run["heading_error"][5:17] = -3.1e-3  # 5 rows of it not sure
    run["velocity_error"][15:19, 1] = 0.31
    run["position_error"][50, 2] = -6.1
    found = certainty.of_run(run)
    assert found.wrongly == (7 + 2 + 1) * PERIOD
    assert found.longest == 9 * PERIOD
    assert found.wrongly_in == {"heading": 7 * PERIOD, "velocity": 4 * PERIOD, "position": 1 * PERIOD}
    said = found.headline()["Wrongly sure"]
    assert said.startswith("5.0 s of 45.0 s, longest 4.5 s: heading, velocity, position")
    assert found.figures() == {
        "sure_for_s": 45.0,
        "wrongly_sure_for_s": 5.0,
        "longest_wrongly_sure_s": 4.5,
    }


def test_three_sigma_are_not_beyond(run: xr.Dataset) -> None:
    run["position_error"][:] = 6.0
    assert certainty.of_run(run).wrongly == 0


def test_a_heading_goes_round(run: xr.Dataset) -> None:
    run["heading_error"][20:] += 2 * np.pi
    assert certainty.of_run(run).wrongly == 0


@pytest.mark.parametrize("name", ["velocity_error", "velocity_sigma"])
def test_what_is_no_number_is_beyond_any_sigma(run: xr.Dataset, name: str) -> None:
    run[name][40:43, 0] = np.nan
    assert certainty.of_run(run).wrongly == 3 * PERIOD


def test_a_filter_without_sigma_of_position_is_not_held_to_it(run: xr.Dataset) -> None:
    run["position_error"][:] = 1e6
    assert certainty.of_run(run.drop_vars("position_sigma")).wrongly == 0
    assert set(certainty.deviations(run.drop_vars("position_sigma"))) == {"heading", "velocity"}


def test_a_deviation_is_that_of_the_worst_component(run: xr.Dataset) -> None:
    run["velocity_error"][30] = [0.1, -0.2, 9.0]
    run["position_sigma"][30] = 0.0
    found = certainty.deviations(run)
    assert found["velocity"][[29, 30]] == pytest.approx([0.5, 2.0])
    assert found["position"][29] == pytest.approx(0.5)
    assert np.isnan(found["position"][30])


@pytest.mark.parametrize(
    ("pattern", "longest"), [("", 0), ("0", 0), ("1", 1), ("110111", 3), ("0111", 3), ("1111001", 4)]
)
def test_the_longest_stretch(pattern: str, longest: int) -> None:
    assert certainty.longest_stretch(np.array([c == "1" for c in pattern], dtype=bool)) == longest


def test_a_consistent_filter_is_beyond_as_often_as_three_sigma_allow(run: xr.Dataset) -> None:
    rng = np.random.default_rng(4)
    rows = 40_000
    long = run.isel(time=np.zeros(rows, dtype=int)).assign_coords(time=PERIOD * np.arange(rows))
    long["converged"][:] = True
    long["heading_error"] = 1e-3 * xr.DataArray(rng.standard_normal(rows), dims="time")
    found = certainty.of_run(long)
    expected, deviation = 0.0026998 * rows, np.sqrt(0.0026998 * rows)
    assert abs(found.wrongly / PERIOD - expected) < 4 * deviation
