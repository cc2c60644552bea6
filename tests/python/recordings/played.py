"""The Playback FMU with a recording: what it puts out, and what a filter makes of it in FMPy."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from fmpy.ssp.simulation import simulate_ssp

from sim_scenarios.cosimulation import Table
from sim_scenarios.exchange import System, signals
from sim_scenarios.exchange.recorded import playback
from sim_scenarios.fmus import PLAYBACK, Fmus
from sim_scenarios.instance import Instance, Port
from sim_scenarios.recordings import fixes
from sim_scenarios.recordings.feed import Feed
from sim_scenarios.recordings.tables import Recording

NAVIGATION = ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity[1]", "velocity[3]")


def until(recording: Recording, seconds: float) -> Recording:
    """IMU and fixes of a recording until so long after its first sample."""
    imu, gnss, end = recording.imu, recording.gnss, recording.imu.time[0] + seconds
    early = imu.time < end
    cut = {name: getattr(imu, name)[early] for name in ("time", "delta_angle", "delta_velocity")}
    return replace(recording, imu=replace(imu, **cut), gnss=fixes.selected(gnss, gnss.time < end))


def put_out(fed: Feed, recording: Recording, fmus: Fmus, folder: Path, start: float) -> dict[str, np.ndarray]:
    """Outputs of Playback at the start and whenever its IMU has put out something, a row for each."""
    fmu = playback(fmus[PLAYBACK], folder, fed, recording.reference)
    step = signals.suitable_step(fed.time)
    steps = int(np.ceil((fed.time[-1] - fed.time[0]) / step - 1e-6))
    with closing(Instance(fmu, "playback", {})) as instance:
        instance.begin_initialisation(start, start + steps * step)
        instance.finish_initialisation()
        table = Table(Port(instance, fmu.outputs()), steps + 1)
        table.append()
        for index in range(steps):
            instance.step(start + index * step, step)
            table.append()
        assert not instance.messages
    columns = table.columns()
    new = np.diff(columns["imu.sample"], prepend=-1) > 0
    return {name: column[new] for name, column in columns.items()}


def difference_from_replay(system: System, folder: Path, run: xr.Dataset) -> float:
    """Largest difference of the navigation that FMPy makes of a system from that of a replay.

    Each row of the replay is held against the last one of FMPy with the same time of validity.
    """
    result = simulate_ssp(str(folder / f"{system.name}.ssp"), stop_time=system.stop, step_size=system.step)
    valid = result["filter.nav.time"]
    wanted = run["nav.time"].to_numpy() - float(run["time"][0])
    last = np.searchsorted(valid, wanted + 1e-7) - 1
    complete = last < len(valid) - 1  # a row has followed
    assert np.count_nonzero(complete) > len(wanted) - 3
    np.testing.assert_allclose(valid[last], wanted, rtol=0, atol=1e-7)
    worst = 0.0
    for name in NAVIGATION:
        array, _, index = name.rstrip("]").partition("[")
        values = run[f"nav.{array}"].to_numpy()
        values = values[:, int(index) - 1] if index else values
        found = result[f"filter.nav.{name}"][last]
        worst = max(worst, float(np.max(np.abs(found - values)[complete])))
    return worst
