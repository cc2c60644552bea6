"""What the sensors of a scenario put out, as a recording, and as files of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from sim_scenarios import connection
from sim_scenarios.cosimulation import FmuSource, Table
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Instance, Port
from sim_scenarios.recordings.tables import (
    BodyVelocityTable,
    FixTable,
    HeadingTable,
    HeightTable,
    ImuTable,
    LeverArms,
    Recording,
    ReferenceTable,
)
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import DEGREE

AXES = ("[1]", "[2]", "[3]")
PLACE = ("latitude", "longitude", "height")
IMU_COLUMNS = {
    f"delta_{kind}_{axis}": f"imu.delta_{kind}[{i}]"
    for kind in ("angle", "velocity")
    for i, axis in enumerate("xyz", start=1)
}


def sensed(
    fmus: Fmus, scenario: str, seconds: float, seed: int = 21, settings: dict[str, object] | None = None
) -> Recording:
    """Recording of a scenario, its truth for reference."""
    loaded = load_scenario(scenario, fmus, seed=seed, settings=settings)
    step = loaded.communication_step
    names = [n for n in fmus.plant.outputs() if not n.startswith("gnss.channel")]
    instance = Instance(fmus.plant, "recorder", loaded.plant)
    instance.begin_initialisation(0.0, seconds)
    instance.finish_initialisation()
    table = Table(Port(instance, names), round(seconds / step))
    source = FmuSource(instance, names)
    clock = step * np.arange(round(seconds / step) + 1)
    for time, end in zip(clock[:-1].tolist(), clock[1:].tolist(), strict=True):
        source.advance(time, end - time)
        table.append()
    instance.close()
    columns = table.columns()

    def vector(name: str, rows: np.ndarray | slice = slice(None)) -> np.ndarray:
        return np.column_stack([columns[name + axis][rows] for axis in AXES])

    def new(sensor: str) -> np.ndarray:
        return np.flatnonzero(np.diff(columns[f"{sensor}.sample"], prepend=0) > 0)

    fixes, logs, compass, barometer = map(new, ("gnss", "body_velocity", "heading_aid", "height_aid"))
    arms = (
        tuple(loaded.plant.get(f"{sensor}.lever_arm{axis}", 0.0) for axis in AXES)
        for sensor in ("gnss", "body_velocity")
    )
    return Recording(
        name=scenario,
        imu=ImuTable(columns["imu.time"], vector("imu.delta_angle"), vector("imu.delta_velocity")),
        gnss=FixTable(
            columns["gnss.time"][fixes],
            np.column_stack([columns[f"gnss.{name}"][fixes] for name in PLACE]),
            vector("gnss.velocity", fixes),
            vector("gnss.fix_position_sigma", fixes),
            vector("gnss.fix_velocity_sigma", fixes),
        ),
        body_velocity=BodyVelocityTable(
            columns["body_velocity.time"][logs],
            vector("body_velocity.velocity", logs),
            vector("body_velocity.sigma", logs),
        )
        if len(logs)
        else None,
        heading_aid=HeadingTable(
            *(columns[f"heading_aid.{name}"][compass] for name in ("time", "heading", "sigma"))
        )
        if len(compass)
        else None,
        height_aid=HeightTable(
            *(columns[f"height_aid.{name}"][barometer] for name in ("time", "height", "sigma"))
        )
        if len(barometer)
        else None,
        reference=ReferenceTable(
            columns["imu.time"],
            np.column_stack([columns[f"truth.{name}"] for name in ("roll", "pitch", "heading")]),
            np.column_stack([columns[f"truth.{name}"] for name in PLACE]),
            vector("truth.velocity"),
        ),
        lever_arms=LeverArms(*arms),
    )


def as_table(recording: Recording) -> pd.DataFrame:
    """IMU and fixes as columns of the plain CSV form."""
    imu, gnss = recording.imu, recording.gnss
    values = np.hstack((imu.delta_angle, imu.delta_velocity))
    table = pd.DataFrame({"time": imu.time, **dict(zip(IMU_COLUMNS, values.T, strict=True))})
    rows = np.searchsorted(imu.time, gnss.time - 1e-6)
    fixes = {
        **dict(
            zip((f"gnss_velocity_{axis}" for axis in ("east", "north", "up")), gnss.velocity.T, strict=True)
        ),
        "gnss_latitude": gnss.position[:, 0] / DEGREE,
        "gnss_longitude": gnss.position[:, 1] / DEGREE,
        "gnss_height": gnss.position[:, 2],
        "gnss_time": gnss.time,
    }
    for column, column_values in fixes.items():
        table[column] = np.nan
        table.loc[rows, column] = column_values
    return table


def as_csv(recording: Recording, path: Path) -> Path:
    """The plain CSV form with all digits."""
    as_table(recording).to_csv(path, index=False, float_format="%.17g")
    return path


def told_as_in(scenario: str, fmus: Fmus, seed: int = 21) -> dict[str, object]:
    """Parameters and start that the filter of a scenario gets."""
    loaded = load_scenario(scenario, fmus, seed=seed)
    plant = Instance(fmus.plant, "plant", loaded.plant)
    plant.begin_initialisation(0.0, loaded.duration)
    plant.finish_initialisation()
    truth = dict(zip(connection.TRUTH, plant.read(connection.TRUTH), strict=True))
    plant.close()
    filter_fmu = fmus[loaded.filter_fmu]
    start = connection.initial_values(loaded, fmus.plant, truth)
    return connection.filter_values(filter_fmu, start, loaded.filter)
