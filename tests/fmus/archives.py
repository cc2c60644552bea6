"""The FMUs in build/fmus (or in $TRUENORTH_FMUS), and what all tests of them share."""

from __future__ import annotations

import math
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
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(signals.content(Feed(columns["imu.time"], columns), None))


def plain_csv(samples: Sequence[dict[str, Number]], path: Path) -> Path:
    """A recording of a plant's outputs as a CSV file, a fix in the row in which it comes."""
    columns = {"time": ("imu.time", 1.0)}
    for kind in ("angle", "velocity"):
        columns |= {f"delta_{kind}_{x}": (f"imu.delta_{kind}[{i}]", 1.0) for i, x in enumerate("xyz", 1)}
    degree = math.degrees(1.0)
    fix = {
        **{
            f"gnss_velocity_{to}": (f"gnss.velocity[{i}]", 1.0)
            for i, to in enumerate(("east", "north", "up"), 1)
        },
        "gnss_latitude": ("gnss.latitude", degree),
        "gnss_longitude": ("gnss.longitude", degree),
        "gnss_height": ("gnss.height", 1.0),
    }
    lines, count = [",".join([*columns, *fix])], 0
    for sample in samples:
        row = [repr(sample[name] * factor) for name, factor in columns.values()]
        new = sample["gnss.sample"] != count
        row += [repr(sample[name] * factor) if new else "" for name, factor in fix.values()]
        lines.append(",".join(row))
        count = sample["gnss.sample"]
    path.write_text("\n".join([*lines, ""]))
    return path


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
