"""The FMUs in build/fmus (or in $TRUENORTH_FMUS), and what all tests of them share."""

from __future__ import annotations

import os
from pathlib import Path

from calls import Fmu, Number

ROOT = Path(__file__).parents[2]
FMUS = Path(os.environ.get("TRUENORTH_FMUS", ROOT / "build" / "fmus"))
ARCHIVES = sorted(FMUS.glob("*.fmu"))
FILTERS = [archive.stem for archive in ARCHIVES if archive.stem.endswith("Filter")]

STEP = 0.01
SAMPLES = 2000


def variants(fmu: Fmu) -> list[dict[str, Number]]:
    """Parameters that choose each error model of a filter in turn; of any other FMU, none."""
    chooser = fmu.variables.get("error_model")
    if chooser is None:
        return [{}]
    models = range(1, len(chooser.declaredType.items) + 1)
    return [{"error_model": model, **requirements(fmu, model)} for model in models]


def requirements(fmu: Fmu, model: int) -> dict[str, Number]:
    """What an error model asks of the other parameters: the Euler models, a stationary base."""
    name = fmu.variables["error_model"].declaredType.items[model - 1].name
    return {"initial.velocity[2]": 0.0} if name.startswith("euler") else {}
