"""The ship of `swaying_ship` in waves: its rates in closed form, and what a plant measures and knows."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim_scenarios.connection import TRUTH, driver, start_plant
from sim_scenarios.cosimulation import Columns, FmuSource, Table
from sim_scenarios.fmus import Fmus
from sim_scenarios.instance import Port
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

DURATION = 60.0
SETTINGS = {"duration": DURATION, "evaluation.start": 30.0}
SWAY = np.array([8, 6, 5]) * DEGREE, 2 * np.pi / np.array([8, 10, 6]), np.array([0.3, 1.1, 2.0])
WAVE = np.array([0.3, 0.5, 0.4]), 2 * np.pi / np.array([7, 9, 8]), np.array([0.0, 1.0, 0.5])
"""Amplitude, angular frequency, phase: of roll, pitch, yaw to the left; of the velocity east, north, up."""

DELTA_ANGLE, DELTA_VELOCITY = (
    [f"imu.delta_{what}[{i}]" for i in (1, 2, 3)] for what in ("angle", "velocity")
)
COUNTS = ["imu.sample", "gnss.sample", "external.rejected"]
FIX = ["gnss.latitude", "gnss.longitude", "gnss.height"]


def sailing(fmus: Fmus, **settings: Any) -> Scenario:
    """The ship by itself, or moved by what the settings say."""
    waves = {} if settings else {"motion.wave.velocity": WAVE[0].tolist()}
    return load_scenario("swaying_ship", fmus, seed=3, settings={**SETTINGS, **waves, **settings})


def put_out(scenario: Scenario, fmus: Fmus) -> Columns:
    """What the plant of a scenario puts out at the beginning and after every step."""
    names = [*TRUTH, "imu.time", *COUNTS, *FIX, *DELTA_ANGLE, *DELTA_VELOCITY]
    step, steps = scenario.communication_step, round(scenario.duration / scenario.communication_step)
    with ExitStack() as stack:
        plant = start_plant(scenario, fmus, stack)
        source, table = FmuSource(plant, names, driver(scenario, plant)), Table(Port(plant, names), steps + 1)
        table.append()
        for index in range(steps):
            source.advance(index * step, step)
            table.append()
        return table.columns()


def acceleration(time: Array) -> Array:
    """Derivative of the velocity (east, north, up), shape (n, 3)."""
    amplitude, frequency, phase = WAVE
    derivative: Array = amplitude * frequency * np.cos(frequency * time[:, None] + phase)
    return derivative


def body_rate(time: Array) -> Array:
    """Relative to east, north, up; right, forward, up; shape (n, 3)."""
    amplitude, frequency, phase = SWAY
    angle = frequency * time[:, None] + phase
    roll, pitch, _ = (amplitude * np.sin(angle)).T
    roll_rate, pitch_rate, left = (amplitude * frequency * np.cos(angle)).T
    up = np.cos(pitch) * left
    return np.column_stack(
        (
            np.cos(roll) * pitch_rate - np.sin(roll) * up,
            roll_rate + np.sin(pitch) * left,
            np.sin(roll) * pitch_rate + np.cos(roll) * up,
        )
    )


def columns(truth: Columns, time: Array) -> dict[str, Array]:
    """All columns that a trajectory may have."""
    axes = ("east", "north", "up")
    return {
        "time": time,
        **{name: truth[f"truth.{name}"] / DEGREE for name in ("latitude", "longitude")},
        "height": truth["truth.height"],
        **{name: truth[f"truth.{name}"] / DEGREE for name in ("roll", "pitch", "heading")},
        **{f"velocity_{axis}": truth[f"truth.velocity[{i}]"] for i, axis in enumerate(axes, 1)},
        **{f"acceleration_{axis}": column for axis, column in zip(axes, acceleration(time).T, strict=True)},
        **{
            f"rate_{axis}": column / DEGREE
            for axis, column in zip(("right", "forward", "up"), body_rate(time).T, strict=True)
        },
    }


def written(table: dict[str, Array], path: Path, every: int = 1, without: tuple[str, ...] = ()) -> Path:
    """A trajectory with each n-th row, without columns of certain beginnings."""
    kept = {name: values[::every] for name, values in table.items() if not name.startswith(without)}
    pd.DataFrame(kept).to_csv(path, index=False, float_format="%.17g")
    return path
