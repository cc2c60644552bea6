"""A recording that no filter has been tuned to: never wrongly sure, and never lost."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from car_drive import BENCH, CarDrive
from wire import STATUS, Fed

from sim_scenarios.fmus import NAVIGATION_FILTER, load

FOLDER = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "car_drive")
pytestmark = pytest.mark.skipif(
    not (FOLDER / "imu.csv.gz").exists(), reason="no car_drive in the folder TRUENORTH_RECORDINGS"
)
OUTPUTS = [
    *(f"nav.{name}" for name in ("latitude", "longitude", "time")),
    *("position_sigma[1]", "position_sigma[2]", "status", "converged", "used_fixes", "rejected_fixes"),
]
EVERY = 10  # samples
PERIOD = 0.1  # s


@pytest.fixture(scope="module")
def drive() -> CarDrive:
    return CarDrive.read(FOLDER)


def driven(drive: CarDrive, **told: object) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Outputs, and how far they are off the track [m]."""
    fmu = load(NAVIGATION_FILTER)
    values: dict[str, float] = {}
    for name, value in drive.told(predictor="linearised", **told).items():
        values |= fmu.assignments(name, value)
    out, _ = Fed(fmu, drive.columns, values).run(drive.clock, OUTPUTS, every=EVERY)
    return out, drive.off(out)


@pytest.mark.parametrize("model", ["loose", "invariant"])
@pytest.mark.parametrize(
    "corrector", ["standard", "h_infinity", "igg", "adaptive_factor", "variational_bayes"]
)
def test_told_of_a_sensor_on_its_bench(model: str, corrector: str, drive: CarDrive) -> None:
    # On the road the noise is nearly ten times what the filter is told.
    out, off = driven(drive, error_model=model, corrector=corrector)
    sure = out["converged"].astype(bool)
    sigma = np.hypot(out["position_sigma[1]"], out["position_sigma[2]"])
    assert np.sum(sure & (off > 3 * np.hypot(sigma, 0.05))) * PERIOD < 1.0
    assert not np.any(sure & (off > 10.0))
    assert np.max(off) < 100.0
    assert not np.any(out["status"] == STATUS["faulted"])
    assert out["rejected_fixes"][-1] < 0.1 * out["used_fixes"][-1]


@pytest.mark.parametrize("model", ["loose", "invariant"])
def test_told_of_the_road(model: str, drive: CarDrive) -> None:
    road = {name: 8.0 * BENCH[name] for name in BENCH if name.startswith("process.")}
    settings = {"error_model": model, "gate.enabled": False, **road}
    _, off = driven(drive, **settings)
    assert np.sqrt(np.mean(off[100:] ** 2)) < 0.12  # 0.10 m, of a filter written by others
