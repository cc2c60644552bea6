"""The FMUs in build/fmus (or in $TRUENORTH_FMUS), and what all tests of them share."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from calls import Fmu, Number

from sim_scenarios.exchange import signals
from sim_scenarios.recordings.feed import Feed

ROOT = Path(__file__).parents[2]
FMUS = Path(os.environ.get("TRUENORTH_FMUS", ROOT / "build" / "fmus"))
ARCHIVES = sorted(FMUS.glob("*.fmu"))
FILTERS = [archive.stem for archive in ARCHIVES if archive.stem.endswith("Filter")]

STEP = 0.01
SAMPLES = 2000


def give_recording(folder: Path, samples: Sequence[dict[str, Number]]) -> None:
    """What an unpacked Playback puts out, at the steps of STEP: names and values of a plant's outputs."""
    first = samples[0]
    rows = [{**first, "imu.sample": first["imu.sample"] - 1, "imu.time": first["imu.time"] - STEP}, *samples]
    columns = {name: np.array([row[name] for row in rows]) for name in first}
    file = folder / signals.FILE
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(signals.content(Feed(columns["imu.time"], columns), None))


def variants(fmu: Fmu) -> list[dict[str, Number]]:
    """Parameters that choose each error model of a filter, or each fault of the plant, in turn; else none."""
    if "error_model" in fmu.variables:
        return [{"error_model": model, **requirements(fmu, model)} for model in choices(fmu, "error_model")]
    faults: list[dict[str, Number]] = [
        {
            f"fault.{sensor}.kind": kind,
            f"fault.{sensor}.begin": SAMPLES * STEP / 4,
            f"fault.{sensor}.duration": SAMPLES * STEP / 2,
            f"fault.{sensor}.size": 1.0,
        }
        for sensor in ("imu", "gnss")
        if f"fault.{sensor}.kind" in fmu.variables
        for kind in choices(fmu, f"fault.{sensor}.kind")
    ]
    return faults or [{}]


def choices(fmu: Fmu, name: str) -> range:
    """Numbers of the items of an enumeration."""
    return range(1, len(fmu.variables[name].declaredType.items) + 1)


def requirements(fmu: Fmu, model: int) -> dict[str, Number]:
    """What an error model asks of the other parameters: the Euler models, a stationary base."""
    name = fmu.variables["error_model"].declaredType.items[model - 1].name
    return {"initial.velocity[2]": 0.0} if name.startswith("euler") else {}
