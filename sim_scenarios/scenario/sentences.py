"""What is wrong with an entry, in a sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from sim_scenarios.fmus import did_you_mean
from sim_scenarios.scenario.tables import Scenario


def sentence(where: Path | str, error: Any) -> str:
    """What pydantic finds wrong with a scenario, under the name of its file and of the entry in it."""
    table, *rest = error["loc"] or ("",)
    key = ".".join(str(part) for part in ("compare" if table == "rivals" else table, *rest))
    cause = error.get("ctx", {}).get("error")
    if error["type"] == "extra_forbidden":
        reason = f"there is no such entry{did_you_mean(str(error['loc'][-1]), _entries(error['loc'][:-1]))}"
    else:
        reason = str(cause) if cause else f"{error['msg'][0].lower()}{error['msg'][1:]}"
    return ": ".join(part for part in (str(where), key, reason) if part)


def _entries(location: tuple[str | int, ...]) -> list[str]:
    """Names of the entries that the table at a location may have."""
    model: type[BaseModel] = Scenario
    for key in location:
        annotation = model.model_fields[str(key)].annotation
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return []
        model = annotation
    return list(model.model_fields)
