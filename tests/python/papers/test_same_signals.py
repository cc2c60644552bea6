"""The product's figures of a scenario against those of a dense filter on the very same signals.

What an RMSE is depends on the trajectory and the draws; two filters that hold the same equations agree on one
run of both. The other filter, `dense_loose`, is written from the equations and shares nothing with the FMUs.
"""

from __future__ import annotations

from contextlib import ExitStack

import numpy as np
import pytest
import xarray as xr
from dense_loose import AdaptiveFactor, Array, Corrector, DenseLoose, GuardedIgg, Told, standard

from sim_scenarios import attitude, connection, provenance, simulation
from sim_scenarios.attitude import wrap
from sim_scenarios.cosimulation import FmuSource, Table
from sim_scenarios.earth import displacement
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Port
from sim_scenarios.metrics.navigation import judge
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.timeline import within

SCENARIO = "flight_accelerometer_fault"
COMPARED: dict[str, dict[str, object]] = {
    "EKF": {"predictor": "linearised"},
    "UKF": {"predictor": "unscented"},
    "adaptive factor": {"corrector": "adaptive_factor"},
    "IGG with guard": {"corrector": "igg"},
}
PARTS: dict[str, dict[str, object]] = {
    "positions alone": {"gnss.measures_velocity": False},
    "velocities alone": {"gnss.measures_position": False},
    "no height": {"gnss.measures_position[3]": False},
    "no velocity east": {"gnss.measures_velocity[1]": False},
    "sigmas of each": {
        "gnss.reports_sigma": True,
        "gnss.noise_scale.sine.amplitude": 0.8,
        "gnss.noise_scale.sine.period": 70.0,
        "gnss.noise_scale.sine.begin": 0.0,
        "gnss.noise_scale.sine.end": 600.0,
    },
}
PLACE = ("longitude", "latitude", "height")
ANGLES = ("roll", "pitch", "heading")
AXES = (1, 2, 3)
SENSED = (
    "imu.time",
    *(f"imu.delta_{kind}[{i}]" for kind in ("angle", "velocity") for i in AXES),
    "gnss.sample",
    *(f"gnss.{name}" for name in PLACE),
    *(f"gnss.velocity[{i}]" for i in AXES),
    *(f"gnss.fix_{kind}_sigma[{i}]" for kind in ("position", "velocity") for i in AXES),
)


class Tap:
    """A source whose signals are recorded at every step."""

    alignment = None

    def __init__(self, source: FmuSource, rows: int) -> None:
        self.instance, self.signals = source.instance, source.signals
        self._source = source
        self.table = Table(Port(source.instance, SENSED), rows)
        self.table.append()

    def advance(self, time: float, step: float) -> None:
        self._source.advance(time, step)
        self.table.append()


def run(scenario: Scenario, fmus: Fmus) -> tuple[xr.Dataset, dict[str, Array]]:
    """Data set of the product's filters, and the signals that they were given."""
    with ExitStack() as stack:
        source, sinks = connection.connect(scenario, fmus, scenario.filters(), stack)
        assert isinstance(source, FmuSource)
        tap = Tap(source, round(scenario.duration / scenario.communication_step) + 1)
        recorded = connection.record(scenario, fmus, tap, sinks)
    data = simulation.dataset(recorded, scenario, fmus, list(scenario.filters()))
    data.attrs = provenance.attributes(scenario, fmus)
    return data, tap.table.columns()


def told(scenario: Scenario) -> Told:
    """What the scenario tells its filters."""
    value = scenario.filter
    of_start = ("tilt", "heading", "velocity", "position", "height", "gyro_bias", "accelerometer_bias")
    return Told(
        **{name: value[f"prior.{name}_sigma"] for name in of_start},
        **{name: value[f"process.{name}"] for name in ("angle_random_walk", "velocity_random_walk")},
        **{f"fix_{name}": value[f"measurement.{name}_sigma"] for name in ("position", "height", "velocity")},
    )


def as_compared(scenario: Scenario) -> list[Corrector]:
    """Those of COMPARED; the model is linear."""
    adaptive = AdaptiveFactor(told(scenario).widest())
    return [standard, standard, adaptive, GuardedIgg(adaptive)]


def dense_run(
    scenario: Scenario, data: xr.Dataset, signals: dict[str, Array], correctors: list[Corrector]
) -> dict[str, Array]:
    """What the dense filters have after each fix, arrays of the shape (fixes, filters, ...)."""

    def vectors(name: str) -> Array:
        return np.column_stack([signals[f"{name}[{i}]"] for i in AXES])

    start = data.isel(filter=0, time=0)
    dense = DenseLoose(
        told(scenario),
        correctors,
        attitude.dcm(*(float(start[f"nav.{angle}"]) for angle in ANGLES)),
        start["nav.velocity"].values,
        np.array([float(start[f"nav.{name}"]) for name in PLACE]),
    )
    angle, gained = vectors("imu.delta_angle"), vectors("imu.delta_velocity")
    position, velocity = (
        np.column_stack([signals[f"gnss.{name}"] for name in PLACE]),
        vectors("gnss.velocity"),
    )
    sigma = np.hstack((vectors("gnss.fix_position_sigma"), vectors("gnss.fix_velocity_sigma")))
    dt = np.diff(signals["imu.time"])
    assert dt == pytest.approx(scenario.communication_step)
    attitudes, velocities, positions = [], [], []
    done = 0
    for row in np.flatnonzero(np.diff(signals["gnss.sample"], prepend=0)).tolist():
        sensed = slice(done + 1, row + 1)
        dense.advance(angle[sensed], gained[sensed], scenario.communication_step)
        dense.correct(position[row], velocity[row], sigma[row])
        attitudes.append(dense.C.copy())
        velocities.append(dense.v.copy())
        positions.append(dense.p[:, [1, 0, 2]])
        done = row
    return {"C_bn": np.array(attitudes), "velocity": np.array(velocities), "position": np.array(positions)}


def figures(scenario: Scenario, truth: xr.Dataset, found: dict[str, Array]) -> dict[str, Array]:
    """RMSE of the dense filters over the window, shape (filters,), by the names of `NavigationVerdict`."""
    C_bn = attitude.dcm(*(truth[f"truth.{angle}"].values for angle in ANGLES))[:, None]
    turn = attitude.misalignment_angles(found["C_bn"] @ np.swapaxes(C_bn, -1, -2))
    position = displacement(found["position"], places(truth, "truth")[:, None])
    heading = np.arctan2(found["C_bn"][..., 0, 1], found["C_bn"][..., 1, 1])
    errors = {
        "horizontal": position[..., :2],
        "vertical": position[..., 2:],
        "velocity": found["velocity"] - truth["truth.velocity"].values[:, None],
        "tilt": turn[..., :2],
        "yaw": wrap(heading - truth["truth.heading"].values[:, None])[..., None],
    }
    start, stop = scenario.evaluation.start, scenario.evaluation.stop
    inside = {name: within(truth["time"].values, error, start, stop) for name, error in errors.items()}
    return {name: np.sqrt(np.sum(error**2, axis=-1).mean(axis=0)) for name, error in inside.items()}


def places(data: xr.Dataset, frame: str) -> Array:
    """Latitude, longitude, height, shape (..., 3)."""
    return np.stack([data[f"{frame}.{name}"].values for name in ("latitude", "longitude", "height")], axis=-1)


@pytest.mark.parametrize("seed", [1, 2])
def test_every_figure_is_that_of_a_dense_filter(seed: int, fmus: Fmus) -> None:
    """Within 1 %, and every position on the way within 5 cm, of errors of up to 160 m."""
    scenario = load_scenario(SCENARIO, fmus, seed=seed, settings={"duration": 600.0}, compare=COMPARED)
    assert not scenario.filter["gate.enabled"], "the dense filter has no gate"
    data, signals = run(scenario, fmus)
    found = dense_run(scenario, data, signals, as_compared(scenario))
    at_fixes = data.sel(time=data["fix_time"].values, method="nearest", tolerance=1e-6)
    dense = figures(scenario, at_fixes, found)
    for i, label in enumerate(COMPARED):
        verdict = judge(data.sel(filter=label))
        for figure, rmse in dense.items():
            assert getattr(verdict, figure) == pytest.approx(rmse[i], rel=0.01), (label, figure)
        apart = displacement(places(at_fixes.sel(filter=label), "nav"), found["position"][:, i])
        assert np.abs(apart).max() < 0.05, label


@pytest.mark.parametrize("part", PARTS)
def test_fixes_that_do_not_have_everything_are_used_as_a_dense_filter_does(part: str, fmus: Fmus) -> None:
    """A component that is absent, and sigmas that change from fix to fix; within 1 % and 5 cm as above."""
    settings = {"duration": 300.0, "evaluation.start": 100.0, "evaluation.stop": 300.0, **PARTS[part]}
    filters = {"EKF": {"predictor": "linearised", "corrector": "standard", "gate.enabled": False}}
    scenario = load_scenario("flight_nominal", fmus, seed=1, settings=settings, compare=filters)
    data, signals = run(scenario, fmus)
    found = dense_run(scenario, data, signals, [standard])
    at_fixes = data.sel(time=data["fix_time"].values, method="nearest", tolerance=1e-6)
    assert at_fixes.sizes["time"] == 300
    verdict = judge(data.sel(filter="EKF"))
    for figure, rmse in figures(scenario, at_fixes, found).items():
        assert getattr(verdict, figure) == pytest.approx(rmse[0], rel=0.01), figure
    apart = displacement(places(at_fixes.sel(filter="EKF"), "nav"), found["position"][:, 0])
    assert np.abs(apart).max() < 0.05
