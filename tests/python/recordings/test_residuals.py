"""What a recording at rest holds besides its mean; where recordings that do not come along are looked for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from plant_signals import IMU_COLUMNS

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.folder import recording_named
from sim_scenarios.recordings.residuals import residuals


@pytest.fixture
def shaken(tmp_path: Path) -> tuple[Path, pd.DataFrame]:
    """Sixty seconds at rest, tilting slowly, with noise that is known."""
    time = 0.01 * np.arange(1, 6001)
    rng = np.random.default_rng(8)
    noise = pd.DataFrame(1e-4 * rng.standard_normal((6000, 6)), columns=list(IMU_COLUMNS))
    table = noise.copy()
    table["delta_angle_x"] += 1e-6
    table["delta_velocity_x"] += 0.098 * np.sin(1e-4 * time)
    table["delta_velocity_z"] += 0.098
    table.insert(0, "time", time)
    path = tmp_path / "shaken.csv"
    table.to_csv(path, index=False)
    return path, noise


def test_residuals_are_the_noise_without_bias_and_gravity(shaken: tuple[Path, pd.DataFrame]) -> None:
    path, noise = shaken
    found = residuals(path, period=0.01, span=20.0)
    assert list(found) == list(IMU_COLUMNS.values())
    for column, name in IMU_COLUMNS.items():
        # What the mean over 2000 samples takes along is 1e-4 / 2000^0.5, four times that at worst.
        np.testing.assert_allclose(found[name][1000:-1000], noise[column][1000:-1000], atol=1e-5)


def test_residuals_need_the_samples_of_the_plant(shaken: tuple[Path, pd.DataFrame]) -> None:
    with pytest.raises(InputError, match=r"a sample every 0\.01 s, where 0\.02 s are needed"):
        residuals(shaken[0], period=0.02, span=20.0)


def test_recordings_are_looked_for_in_the_folder_that_is_named(
    shaken: tuple[Path, pd.DataFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = shaken
    monkeypatch.setenv("TRUENORTH_RECORDINGS", str(path.parent))
    assert recording_named(path.name) == path
    assert recording_named("nothing.csv") is None
    monkeypatch.chdir(path.parent)
    monkeypatch.delenv("TRUENORTH_RECORDINGS")
    assert recording_named(path.name) is None
