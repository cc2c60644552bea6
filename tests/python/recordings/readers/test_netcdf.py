"""A run's own file as a reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from damage import refusals

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import netcdf
from sim_scenarios.recordings.readers.contents import Clock

ANGLES = ("truth.roll", "truth.pitch", "truth.heading")
PLACE = ("truth.latitude", "truth.longitude", "truth.height")


def test_the_truth_of_a_simulation_is_bit_equal(ship: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "recording.nc"
    sim_scenarios.save(ship, path)
    assert netcdf.recognises(path)
    contents = netcdf.read(path)
    assert contents.clock is Clock.OWN
    assert contents.reference is not None
    truth = contents.reference
    np.testing.assert_array_equal(truth.time, ship["time"])
    np.testing.assert_array_equal(truth.attitude.T, [ship[name] for name in ANGLES])
    np.testing.assert_array_equal(truth.position.T, [ship[name] for name in PLACE])
    np.testing.assert_array_equal(truth.velocity, ship["truth.velocity"])


def test_a_run_keeps_no_imu(ship: xr.Dataset, tmp_path: Path) -> None:
    """If it ever does, this reader should give it."""
    assert not [name for name in ship if str(name).startswith("imu.delta")]
    sim_scenarios.save(ship, tmp_path / "recording.nc")
    contents = netcdf.read(tmp_path / "recording.nc")
    assert contents.imu is None
    [remark] = contents.remarks
    assert "recording.nc: a run keeps no samples of its IMU" in remark


def small() -> xr.Dataset:
    values = {name: ("time", np.arange(5.0)) for name in (*ANGLES, *PLACE)}
    velocity = (("time", "axis3"), np.ones((5, 3)))
    return xr.Dataset({**values, "truth.velocity": velocity}, {"time": np.arange(5.0)})


def test_a_replay_has_no_truth(tmp_path: Path) -> None:
    path = tmp_path / "recording.nc"
    sim_scenarios.save(small().drop_vars("truth.roll"), path)
    with pytest.raises(InputError, match=r"recording.nc: has no truth.roll: .*reference, and nothing else"):
        netcdf.read(path)


def test_recognised(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("time,gyro\n")
    assert not netcdf.recognises(tmp_path / "other")
    assert not netcdf.recognises(tmp_path / "there is none")
    with pytest.raises(InputError, match="there is no recording"):
        netcdf.read(tmp_path / "there is none")


def test_damaged_files(tmp_path: Path) -> None:
    sim_scenarios.save(small(), tmp_path / "recording.nc")
    assert len(refusals(netcdf.read, tmp_path / "recording.nc")) > 50
