"""Replays smoothed: a tactical IMU in flight that turns while it has no fixes, and its truth."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from plant_signals import sensed, told_as_in

from sim_scenarios.attitude import dcm
from sim_scenarios.bounds import Trajectory, cramer_rao
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.statistics import chi_square_interval, nees_of, rms
from sim_scenarios.recordings import comparison, smoothing
from sim_scenarios.recordings.outages import Outages
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.tables import HeightTable, Recording
from sim_scenarios.scenario import load_scenario
from sim_scenarios.scenario_bound import knowledge
from sim_scenarios.units import DEGREE

SCENARIO, LENGTH = "gnss_outage_turn", 240.0
DARK = Outages(60.0, 100.0)  # from 40 s and from 140 s on, each with a turn in it
TURNS = {
    "motion.segment.duration": [50.0, 30.0, 70.0, 30.0, *[0.0] * 12],
    "motion.segment.turn_angle": [0.0, 90 * DEGREE, 0.0, -60 * DEGREE, *[0.0] * 12],
}
OFTEN = {"filter.interval": 0.1}
"""Predictions as often as rows, so that each row has a covariance of its own time."""


@pytest.fixture(scope="module")
def fmus() -> Fmus:
    return Fmus()


def flown(fmus: Fmus, seed: int) -> Recording:
    return sensed(fmus, SCENARIO, LENGTH, seed, TURNS)


@pytest.fixture(scope="module")
def flight(fmus: Fmus) -> Recording:
    return flown(fmus, 21)


def navigated(fmus: Fmus, recording: Recording, seed: int = 21, **more: object) -> xr.Dataset:
    """With what the filter of the scenario is told, and its start."""
    told = {**told_as_in(SCENARIO, fmus, seed), **OFTEN}
    told |= more.pop("set", {})  # type: ignore[arg-type]
    conditions = {"filter": "navigation", "evaluate_after": 10.0, "smooth": True, **more}
    heading = Start(heading=float(told["initial.heading"]))
    return replay(recording, heading, set=told, fmus=fmus, **conditions)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def run(fmus: Fmus, flight: Recording) -> xr.Dataset:
    return navigated(fmus, flight, outages=DARK)


@pytest.fixture(scope="module")
def best(run: xr.Dataset) -> xr.Dataset:
    return smoothing.solution(run)


def horizontal(run: xr.Dataset) -> np.ndarray:
    error: np.ndarray = np.linalg.norm(run["position_error"].values[:, :2], axis=1)
    return error


def test_the_filter_does_what_it_does_without(fmus: Fmus, flight: Recording, run: xr.Dataset) -> None:
    alone = navigated(fmus, flight, outages=DARK, smooth=False)
    assert not smoothing.is_smoothed(alone)
    assert alone.identical(run.drop_vars([name for name in run if str(name).startswith(smoothing.PREFIX)]))


def test_the_covariances_of_the_filter_are_one(run: xr.Dataset) -> None:
    """That of the position, with that of the other states, is one matrix with no negative eigenvalue."""
    rest, of_position = run["covariance"].values, run["position_covariance"].values
    whole = np.block([[rest, np.swapaxes(of_position[:, :, :12], 1, 2)], [of_position]])
    np.testing.assert_allclose(
        np.diagonal(whole, axis1=1, axis2=2)[:, 12:], run["position_sigma"].values ** 2
    )
    size = np.sqrt(np.diagonal(whole, axis1=1, axis2=2))
    correlation = whole / (size[:, :, None] * size[:, None])
    np.testing.assert_allclose(correlation, np.swapaxes(correlation, 1, 2), atol=1e-12)
    assert np.linalg.eigvalsh(correlation).min() > -1e-9
    assert np.abs(correlation[1:, 12, :12]).max() > 0.5


def test_it_is_surer_than_the_filter_everywhere(run: xr.Dataset, best: xr.Dataset) -> None:
    for name in ("misalignment", "velocity", "position", "gyro_bias", "accelerometer_bias"):
        assert (best[f"{name}_sigma"].values <= run[f"{name}_sigma"].values * (1 + 1e-9)).all(), name


def test_it_is_nearer_to_the_truth(run: xr.Dataset, best: xr.Dataset) -> None:
    filtered, smoothed = (comparison.against_reference(one) for one in (run, best))
    assert filtered is not None
    assert smoothed is not None
    for name in ("horizontal", "vertical", "velocity", "tilt", "heading"):
        assert getattr(smoothed, name) < 0.8 * getattr(filtered, name), name


@pytest.mark.parametrize("begin", [40.0, 140.0])
def test_an_outage_loses_most_of_its_error(run: xr.Dataset, best: xr.Dataset, begin: float) -> None:
    dark = (run["time"].values > begin) & (run["time"].values < begin + 60)
    assert horizontal(best)[dark].max() < 0.3 * horizontal(run)[dark].max()
    sigma = (one["position_sigma"].values[dark].max() for one in (best, run))
    assert next(sigma) < 0.3 * next(sigma)


def test_the_end_is_the_filter(run: xr.Dataset, best: xr.Dataset) -> None:
    for name in ("heading", "latitude", "velocity", "height"):
        np.testing.assert_allclose(best[f"nav.{name}"][-1], run[f"nav.{name}"][-1], rtol=1e-12)
    np.testing.assert_allclose(best["position_sigma"][-1], run["position_sigma"][-1], rtol=1e-2)
    np.testing.assert_allclose(best["heading_sigma"][-1], run["heading_sigma"][-1], rtol=1e-2)


def test_another_model_finds_the_same(fmus: Fmus, flight: Recording, best: xr.Dataset) -> None:
    """The invariant model has another covariance in between, and the same information."""
    invariant = {"error_model": "invariant", "predictor": "linearised"}
    other = smoothing.solution(navigated(fmus, flight, outages=DARK, set=invariant))
    apart = horizontal(best.assign(position_error=best["position_error"] - other["position_error"]))[1:]
    assert apart.max() < 0.2 * np.linalg.norm(best["position_sigma"].values[:, :2], axis=1).max()
    np.testing.assert_allclose(other["position_sigma"], best["position_sigma"], rtol=0.05)


def test_an_attitude_that_is_hardly_known_is_left_as_it_was(fmus: Fmus, flight: Recording) -> None:
    told = {"prior.heading_sigma": 40 * DEGREE, "convergence.heading_sigma": DEGREE}
    run = navigated(fmus, flight, set=told)
    best = smoothing.solution(run)
    known = run["misalignment_sigma"].values.max(axis=1) < smoothing.WIDE
    assert 10 < np.count_nonzero(~known) < np.count_nonzero(known)
    np.testing.assert_allclose(
        best["nav.heading"].values[~known], run["nav.heading"].values[~known], rtol=1e-12
    )
    assert (best["heading_sigma"].values[known] <= run["heading_sigma"].values[known] * 1.01).all()
    (said,) = [text for text in json.loads(run.attrs["messages"]) if text.startswith("Smoothing")]
    assert "not known to 20 deg" in said


def test_a_way_back_is_not_carried_back(fmus: Fmus, flight: Recording) -> None:
    """From 120 s on the receiver is 3 km north: the filter believes it at last, the smoother not before."""
    moved = np.where(flight.gnss.time > 120.0, 3000 / 6.37e6, 0.0)
    astray = flight.gnss.position + np.column_stack((moved, 0 * moved, 0 * moved))
    misled = replace(flight, gnss=replace(flight.gnss, position=astray))
    run = navigated(fmus, misled, set={"gate.enabled": True})
    best = smoothing.solution(run)
    assert horizontal(run)[-1] > 1000
    before = (run["time"].values > 0) & (run["time"].values < 120)
    assert horizontal(best)[before].max() < 20
    (said,) = [text for text in json.loads(run.attrs["messages"]) if text.startswith("Smoothing")]
    assert "a fix contradicted the prediction" in said


@pytest.mark.parametrize(
    ("task", "settings", "sentence"),
    [
        ("alignment", {}, "smoothing: AlignmentFilter does not navigate; choose the filter navigation"),
        ("navigation", {"error_model": "full_state"}, "error_model = full_state: cannot be smoothed"),
        ("navigation", {"corrector": "h_infinity"}, "corrector = h_infinity: cannot be smoothed"),
        ("navigation", {"standstill.velocity_sigma": 0.1}, "standstill.velocity_sigma corrects the filter"),
    ],
)
def test_what_cannot_be_smoothed_is_refused(
    fmus: Fmus, flight: Recording, task: str, settings: dict[str, object], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        replay(flight, Start(heading=0.0), filter=task, smooth=True, set=settings, fmus=fmus)


def test_other_aids_are_refused(fmus: Fmus, flight: Recording) -> None:
    ten = np.arange(10.0)
    aided = replace(flight, height_aid=HeightTable(ten, 1000 + 0 * ten, 1 + 0 * ten))
    with pytest.raises(InputError, match="height_aid corrects the filter besides"):
        replay(aided, Start(heading=0.0), filter="navigation", smooth=True, fmus=fmus)


def test_it_is_as_sure_as_can_be(fmus: Fmus, flight: Recording) -> None:
    """The Cramer-Rao bound along the true motion, smoothed as well, of all states at every fix."""
    best = smoothing.solution(navigated(fmus, flight))
    truth = flight.reference
    motion = Trajectory(
        truth.time, dcm(*truth.attitude.T), truth.velocity, truth.position[:, 0], truth.position[:, 2]
    )[::10]
    known = replace(
        knowledge(load_scenario(SCENARIO, fmus), fmus.plant, fmus["NavigationFilter"]), position_sigma=10.0
    )
    bound = cramer_rao(motion, known, smoothed=True)
    rows = np.searchsorted(best["time"].values, bound.time - 1e-6)
    names = ("misalignment", "velocity", "gyro_bias", "accelerometer_bias", "position")
    sigma = np.hstack([best[f"{name}_sigma"].values[rows] for name in names])
    until = slice(1, 200)  # the truth ends before the last fix
    np.testing.assert_allclose(sigma[until], bound.sigma[until], rtol=0.02)
    filtered = cramer_rao(motion, known)
    assert (bound.sigma <= filtered.sigma * (1 + 1e-9)).all()
    assert rms(bound.heading_sigma) < 0.7 * rms(filtered.heading_sigma)


@pytest.mark.slow
def test_many_smoothed_flights_are_consistent(fmus: Fmus) -> None:
    """NEES of attitude and velocity, and of the position by itself: in 99 % of cases all are in theirs."""
    seeds = range(1, 41)
    instants = (5.0, 30.0, 55.0, 70.0, 85.0, 120.0, 170.0, 239.0)
    nees, place = [], []
    for seed in seeds:
        best = smoothing.solution(navigated(fmus, flown(fmus, seed), seed, outages=DARK))
        rows = np.searchsorted(best["time"].values, instants)
        nees.append(6 * nees_of(best)[rows])
        deviation = (best["position_error"].values / best["position_sigma"].values)[rows]
        place.append(np.sum(deviation**2, axis=1))
    for values, freedom in ((nees, 6), (place, 3)):
        low, high = chi_square_interval(freedom * len(seeds), 1 - 0.01 / (2 * len(instants)))
        total = np.sum(values, axis=0)
        assert ((total > low) & (total < high)).all(), total / (freedom * len(seeds))
