"""A gate that refuses is no end: filters of the small vehicle come back from a wrong start or tuning."""

from __future__ import annotations

import numpy as np
import pytest
from generator import RATE, Drive
from wire import STATUS, Fed

from sim_scenarios.fmus import NAVIGATION_FILTER, Fmus, load

OUTPUTS = [
    *(f"nav.{name}" for name in ("latitude", "longitude", "height", "heading", "time")),
    *(f"position_sigma[{i}]" for i in (1, 2, 3)),
    *("heading_sigma", "status", "converged", "used_fixes", "rejected_fixes", "nis_mean"),
]
EVERY = 10


@pytest.fixture(scope="module")
def navigation() -> Fmus:
    return Fmus({NAVIGATION_FILTER: load(NAVIGATION_FILTER)})


@pytest.fixture(scope="module", params=[1, 2])
def drive(request: pytest.FixtureRequest) -> Drive:
    return Drive(seed=request.param)


def drives(navigation: Fmus, drive: Drive, model: str, heading_error: float = 0.0, **told: object):
    fmu = navigation[NAVIGATION_FILTER]
    values = {}
    settings = {"error_model": model, "predictor": "linearised", **told}
    for name, value in drive.told(np.deg2rad(heading_error), **settings).items():
        values |= fmu.assignments(name, value)
    out, messages = Fed(fmu, drive.columns, values).run(drive.time, OUTPUTS, every=EVERY)
    rows = np.arange(0, len(drive.time), EVERY)
    horizontal, heading = drive.errors(out, rows)
    return out, horizontal, heading, messages


def wrong(out, horizontal, heading) -> np.ndarray:
    sigma = np.hypot(out["position_sigma[1]"], out["position_sigma[2]"])
    sure = out["converged"].astype(bool)
    return sure & ((horizontal > 3 * sigma) | (np.abs(heading) > 3 * out["heading_sigma"]))


@pytest.mark.parametrize("model", ["loose", "invariant"])
@pytest.mark.parametrize("error", [0.0, 60.0, 170.0])
def test_a_heading_as_wrong_as_its_prior_is_found(model, error, drive, navigation) -> None:
    prior = np.deg2rad(max(error, 8.0))
    out, horizontal, heading, _ = drives(navigation, drive, model, error, **{"prior.heading_sigma": prior})
    late = slice(int(300 * RATE / EVERY), None)
    assert np.max(horizontal[late]) < 0.1
    assert np.degrees(np.max(np.abs(heading[late]))) < 1.0
    assert wrong(out, horizontal, heading).sum() * EVERY / RATE < 10.0


@pytest.mark.parametrize("error", [-165.0, -120.0, 100.0, 150.0, 180.0])
def test_a_heading_that_its_prior_excludes_is_found(error, drive, navigation) -> None:
    """From more than a quarter turn off the equations of the errors lead away: another heading is taken."""
    out, horizontal, heading, _ = drives(navigation, drive, "loose", error)
    late = slice(int(300 * RATE / EVERY), None)
    assert np.max(horizontal[late]) < 0.1
    assert np.degrees(np.max(np.abs(heading[late]))) < 1.0
    assert wrong(out, horizontal, heading).sum() * EVERY / RATE < 10.0


TUNINGS = [
    *(
        ("loose", name)
        for name in ("standard", "h_infinity", "igg", "adaptive_factor", "variational_bayes", "combined")
    ),
    *(("invariant", name) for name in ("standard", "h_infinity", "variational_bayes", "combined")),
]


@pytest.mark.parametrize(("model", "corrector"), TUNINGS)
def test_a_wrong_tuning_is_survived(model, corrector, drive, navigation) -> None:
    # Fixes noisier than they say, a gyro and an accelerometer that are worse than they say.
    told = {
        "measurement.velocity_sigma": drive.velocity_sigma / 3,
        "process.angle_random_walk": drive.gyro_noise / 10,
        "process.velocity_random_walk": drive.accelerometer_noise / 10,
        "corrector": corrector,
    }
    out, horizontal, heading, _ = drives(navigation, drive, model, **told)
    late = slice(int(100 * RATE / EVERY), None)
    assert np.max(horizontal[late]) < 100.0  # a gate that gives up is 43 km off; at most 52 m here
    last = horizontal[int(340 * RATE / EVERY) :]
    assert np.sqrt(np.mean(last**2)) < 10.0  # at most 3.2 m; 0.03 m without gate
    assert not (out["status"] == STATUS["faulted"]).any()
    assert wrong(out, horizontal, heading).sum() * EVERY / RATE < 10.0


@pytest.mark.parametrize(
    "corrector", ["adaptive_factor", "variational_bayes", "igg", "h_infinity", "standard"]
)
def test_without_a_gate_estimates_stay_bounded(corrector, drive, navigation) -> None:
    told = {
        "measurement.velocity_sigma": drive.velocity_sigma / 3,
        "process.angle_random_walk": drive.gyro_noise / 10,
        "process.velocity_random_walk": drive.accelerometer_noise / 10,
        "corrector": corrector,
        "gate.enabled": False,
    }
    out, horizontal, heading, _ = drives(navigation, drive, "loose", **told)
    assert np.max(horizontal) < 50.0
    assert not (out["status"] == STATUS["faulted"]).any()
    assert wrong(out, horizontal, heading).sum() * EVERY / RATE < 10.0


def test_variational_bayes_is_not_content_with_anything(drive, navigation) -> None:
    told = {
        "process.angle_random_walk": drive.gyro_noise / 10,
        "process.velocity_random_walk": drive.accelerometer_noise / 10,
        "corrector": "variational_bayes",
        "gate.enabled": False,
    }
    out, horizontal, heading, _ = drives(navigation, drive, "loose", **told)
    assert wrong(out, horizontal, heading).sum() * EVERY / RATE < 10.0
