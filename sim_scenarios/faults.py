"""Faults that the plant injects into its sensors (`fault.*`): whether there is one, and when it ends."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from sim_scenarios.fmus import Fmu, Number

BEGINNING: Final = "fault."
"""Beginning of the names of the plant's parameters that make faults."""

ONCE: Final = ("not_a_number", "spike", "count_jump", "repeated", "reordered")
"""Kinds that happen once if they have no duration; the others then last for ever."""

_KIND: Final = re.compile(rf"{re.escape(BEGINNING)}\w+\.kind")


def concerns(setting: str) -> bool:
    """Whether a setting of a scenario makes a fault."""
    return setting.removeprefix("plant.").startswith(BEGINNING)


def without(plant: Mapping[str, Number]) -> dict[str, Number]:
    """Parameters of a plant without those of its faults."""
    return {name: value for name, value in plant.items() if not name.startswith(BEGINNING)}


def end(plant: Mapping[str, Number], fmu: Fmu) -> float | None:
    """When the last fault of a plant ends [s]; infinite if one does not, None if there is none."""
    ends = [_end(name, plant, fmu) for name in fmu.variables if _KIND.fullmatch(name)]
    return max((time for time in ends if time is not None), default=None)


def _end(name: str, plant: Mapping[str, Number], fmu: Fmu) -> float | None:
    def value(parameter: str) -> Number:
        return plant.get(parameter, fmu.start(parameter))

    sensor = name.removesuffix("kind")
    items = {number: item for item, number in fmu.variables[name].items.items()}
    kind = items[int(value(name))]
    if kind == "none":
        return None
    begin, duration = (float(value(f"{sensor}{what}")) for what in ("begin", "duration"))
    return begin + duration if duration > 0 or kind in ONCE else math.inf
