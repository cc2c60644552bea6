"""The verdict on navigation, and the page that shows it, on made-up runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from statuses import BAD, FLAGS

from sim_scenarios.attitude import skew
from sim_scenarios.metrics import judge
from sim_scenarios.metrics.navigation import NavigationVerdict
from sim_scenarios.metrics.statistics import nees_of
from sim_scenarios.report import report_comparison, report_run
from sim_scenarios.units import ARCMIN, DEGREE

TIME = np.arange(1001.0)
WINDOW = (100.0, 1000.0)
CHANNELS = 24
SIGMA = {"misalignment": 0.4 * ARCMIN, "velocity": 0.05, "position": 3.0}
CORRELATION = 0.6  # of velocity and misalignment about the same axis


def consistent(seed: int = 1, status: int = 3) -> xr.Dataset:
    """Errors drawn from the covariance that the filter claims, worse by far before the window; 5 to 12
    satellites that come and go, two channels each; a model without biases.
    """
    rng = np.random.default_rng(seed)
    settled = np.where(WINDOW[0] > TIME, 20.0, 1.0)[:, None]
    time_and_axis, fix_and_channel = ("time", "axis3"), ("fix", f"axis{CHANNELS}")
    errors = {name: sigma * rng.standard_normal((len(TIME), 3)) for name, sigma in SIGMA.items()}
    common = errors["misalignment"] * SIGMA["velocity"] / SIGMA["misalignment"]
    errors["velocity"] = CORRELATION * common + np.sqrt(1 - CORRELATION**2) * errors["velocity"]
    satellites = rng.integers(5, 13, len(TIME) - 1)
    measured = np.tile(np.arange(CHANNELS // 2) < satellites[:, None], 2)
    innovation = np.where(measured, rng.standard_normal(measured.shape), 0.0)
    covariance = np.zeros((len(TIME), 12, 12))
    covariance[:, range(6), range(6)] = np.repeat([SIGMA["misalignment"], SIGMA["velocity"]], 3) ** 2
    for i in range(3):
        covariance[:, i, 3 + i] = covariance[:, 3 + i, i] = (
            CORRELATION * SIGMA["misalignment"] * SIGMA["velocity"]
        )
    data = {
        "attitude_error": (time_and_axis, settled * errors["misalignment"]),
        "heading_error": ("time", (settled * errors["misalignment"])[:, 2]),
        "velocity_error": (time_and_axis, settled * errors["velocity"]),
        "position_error": (time_and_axis, settled * errors["position"]),
        **{
            f"{name}_sigma": (time_and_axis, settled * np.full((len(TIME), 3), sigma))
            for name, sigma in SIGMA.items()
        },
        "heading_sigma": ("time", settled[:, 0] * SIGMA["misalignment"]),
        "covariance": (("time", "row12", "column12"), covariance),
        "status": ("time", np.full(len(TIME), status), FLAGS),
        "converged": ("time", np.full(len(TIME), status == 3)),
        "innovation": (fix_and_channel, innovation),
        "innovation_sigma": (fix_and_channel, measured.astype(float)),
        "measurement_weight": (fix_and_channel, measured.astype(float)),
        "nis": ("fix", np.sum(innovation**2, axis=1)),
        "fix_used": ("fix", np.ones(len(TIME) - 1, dtype=bool)),
        "rejected_fixes": ("fix", np.zeros(len(TIME) - 1, dtype=int)),
    }
    return xr.Dataset(
        data,
        coords={"time": TIME, "fix_time": ("fix", TIME[1:])},
        attrs={
            "scenario": "made_up",
            "description": "",
            "filter_fmu": "NavigationFilter",
            "evaluation.start": WINDOW[0],
            "evaluation.stop": WINDOW[1],
            "evaluation.heading_limit": 0.5 * DEGREE,
            "evaluation.horizontal_limit": 10.0,
            "filters": json.dumps({}),
        },
    )


def verdict_on(run: xr.Dataset) -> NavigationVerdict:
    verdict = judge(run)
    assert isinstance(verdict, NavigationVerdict)
    return verdict


def test_errors_are_root_mean_squares_over_the_window() -> None:
    """To 5 sigma of a root mean square of 901 draws."""
    verdict = verdict_on(consistent())
    tolerance = 5 / np.sqrt(2 * 901)
    assert verdict.horizontal == pytest.approx(np.sqrt(2) * SIGMA["position"], rel=tolerance)
    assert verdict.vertical == pytest.approx(SIGMA["position"], rel=tolerance)
    assert verdict.velocity == pytest.approx(np.sqrt(3) * SIGMA["velocity"], rel=tolerance)
    assert verdict.tilt == pytest.approx(np.sqrt(2) * SIGMA["misalignment"], rel=tolerance)
    assert verdict.yaw == pytest.approx(SIGMA["misalignment"], rel=tolerance)
    assert verdict.horizontal_sigma == pytest.approx(np.sqrt(2) * SIGMA["position"])


def test_every_component_of_the_position_has_its_own_root_mean_square() -> None:
    run = consistent()
    east, north, up = 3.0, 4.0, 7.0
    offset = np.tile([east, north, up], (len(TIME), 1))
    verdict = verdict_on(run.assign(position_error=(("time", "axis3"), offset)))
    assert (verdict.horizontal, verdict.vertical) == pytest.approx((5.0, up))


def test_consistency() -> None:
    run = consistent()
    verdict = verdict_on(run)
    assert verdict.nis.consistent
    assert verdict.nees == pytest.approx(1, abs=5 * np.sqrt(2 / (6 * 901)))
    trusting = verdict_on(run.assign(covariance=run["covariance"] / 4, nis=4 * run["nis"]))
    assert verdict.nees is not None
    assert trusting.nees == pytest.approx(4 * verdict.nees)
    assert not trusting.nis.consistent


def test_nees_takes_correlations_into_account() -> None:
    """Attitude and velocity errors mixed by an invertible matrix, the covariance with them."""
    run = consistent()
    mix = np.eye(6)
    mix[3:, :3] = 50 * skew(np.array([1.0, 2.0, 3.0])) + 30 * np.eye(3)
    error = np.concatenate((run["attitude_error"], run["velocity_error"]), axis=1) @ mix.T
    covariance = run["covariance"].values.copy()
    covariance[:, :6, :6] = mix @ covariance[:, :6, :6] @ mix.T
    mixed = run.assign(
        attitude_error=(("time", "axis3"), error[:, :3]),
        velocity_error=(("time", "axis3"), error[:, 3:]),
        covariance=(("time", "row12", "column12"), covariance),
    )
    assert verdict_on(mixed).nees == pytest.approx(verdict_on(run).nees)


def test_nees_counts_biases_as_what_is_left_of_them() -> None:
    """True minus estimated, mixed with the velocity error: the other sign would not cancel."""
    run = consistent()
    count = run.sizes["time"]
    rng = np.random.default_rng(5)
    left, velocity = rng.standard_normal((2, count, 3))
    covariance = run["covariance"].values.copy()
    covariance[:, :3, 3:6] = covariance[:, 3:6, :3] = 0.0
    covariance[:, 6:, 6:] = np.eye(6)  # the accelerometer biases are no states: correlated with nothing
    covariance[:, 3:6, 3:6] = (1 + 0.5**2) * np.eye(3)
    covariance[:, 3:6, 6:9] = covariance[:, 6:9, 3:6] = 0.5 * np.eye(3)
    true = rng.standard_normal((count, 3))
    known = run.assign(
        velocity_error=(("time", "axis3"), velocity + 0.5 * left),
        covariance=(("time", "row12", "column12"), covariance),
        **{
            "truth.gyro_bias": (("time", "axis3"), true),
            "gyro_bias": (("time", "axis3"), true - left),
            "truth.accelerometer_bias": (("time", "axis3"), 9 * rng.standard_normal((count, 3))),
            "accelerometer_bias": (("time", "axis3"), np.zeros((count, 3))),
        },
    )
    assert verdict_on(known).nees == pytest.approx(1, abs=5 * np.sqrt(2 / (6 * 901)))
    assert nees_of(known).shape == (count,)
    certain = known.assign(covariance=0 * known["covariance"])
    assert np.isnan(nees_of(certain)).all()
    tight = known.assign(clock_bias_sigma=("time", np.ones(count)))  # knows a part of its gyro biases
    assert np.isnan(nees_of(tight)).all()  # and nothing else is correlated here


def test_headings_wrap() -> None:
    run = consistent()
    turned = run.assign(heading_error=run["heading_error"] - 2 * np.pi)
    assert verdict_on(turned).yaw == pytest.approx(verdict_on(run).yaw)


def test_a_filter_worse_than_a_fix_has_not_navigated() -> None:
    run = consistent()
    assert judge(run).ok
    lost = run.assign(position_error=10 * run["position_error"])
    assert not judge(lost).ok
    assert (judge(lost).to_json()["within_limit"], judge(run).to_json()["navigated"]) == (False, True)
    assert "beyond the limit of 10.00 m" in judge(lost).sentence()


@pytest.mark.parametrize(("status", "word"), BAD)
def test_a_filter_that_cannot_be_relied_on_has_not_navigated(status: int, word: str) -> None:
    verdict = judge(consistent(status=status))
    assert not verdict.ok
    assert f"the filter is {word} at the end" in verdict.sentence()
    assert (verdict.to_json()["within_limit"], verdict.to_json()["navigated"]) == (True, False)
    assert verdict.row()["within\nlimit"] == f"yes, {word}"


def test_what_the_filter_does_not_put_out_is_no_figure() -> None:
    verdict = verdict_on(consistent().drop_vars(["covariance", "position_sigma"]))
    assert verdict.nees is verdict.horizontal_sigma is None
    assert "Mean NEES / states" not in verdict.headline()
    assert json.loads(json.dumps(verdict.to_json()))["nees_per_state"] is None


def test_the_page_of_a_run(tmp_path: Path) -> None:
    run = consistent()
    text = report_run(run, tmp_path).read_text(encoding="utf-8")
    assert judge(run).sentence() in text
    drawn = {path.stem for path in tmp_path.glob("*.png")}
    assert drawn == {"navigation", "states", "innovations", "nis", "corrections"}


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("kind", ["NavigationFilter", "mine.fmu"])
def test_a_filter_that_puts_out_no_number_has_a_page(tmp_path: Path, value: float, kind: str) -> None:
    """From some time on, in every quantity; as one that navigates, and as one of somebody else's."""
    run = consistent()
    for name in (name for name in run.data_vars if run[name].dtype == float):
        run[name].values[500:] = value
    run["innovation"].attrs["units"] = "m"
    run.attrs["filter_fmu"] = kind
    page = report_run(run, tmp_path / "run").read_text(encoding="utf-8")
    assert judge(run).sentence() in page
    filters = xr.DataArray(["one", "other"], dims="filter", name="filter")
    runs = xr.concat([run, run], dim=filters, combine_attrs="override")
    assert report_comparison(runs, tmp_path / "comparison").is_file()


def test_pictures_of_what_is_absent_are_left_out(tmp_path: Path) -> None:
    report_run(consistent().isel(fix=slice(0, 0)), tmp_path)
    assert {path.stem for path in tmp_path.glob("*.png")} == {"navigation", "states"}


def test_the_page_of_a_comparison(tmp_path: Path) -> None:
    filters = xr.DataArray(["loose", "tight"], dims="filter", name="filter")
    runs = xr.concat([consistent(1), consistent(2)], dim=filters, combine_attrs="override")
    text = report_comparison(runs, tmp_path).read_text(encoding="utf-8")
    assert "2 of 2 filters navigated" in text
    for label, seed in (("loose", 1), ("tight", 2)):
        row = judge(consistent(seed)).row()
        assert f'<th scope="row">{label}</th>' + "".join(f"<td>{cell}</td>" for cell in row.values()) in text
    assert (tmp_path / "comparison.png").is_file()
