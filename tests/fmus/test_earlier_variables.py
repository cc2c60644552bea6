"""Wiring and parameter sets of version 0.1 fit: no name is gone, and none means something else."""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest
from archives import FMUS

LINES = Path(__file__).with_name("variables_of_0_1.txt").read_text(encoding="utf-8").splitlines()[1:]
NAMES = sorted({line.split()[0] for line in LINES})


def described(name: str) -> set[str]:
    """Lines of an FMU as the file has them."""
    description = fmpy.read_model_description(str(FMUS / f"{name}.fmu"), validate=False)
    lines = set()
    for variable in description.modelVariables:
        declared = variable.declaredType
        kind = declared.name if variable.type == "Enumeration" else variable.type
        unit = variable.unit or getattr(declared, "unit", None) or "-"
        lines.add(
            f"{name} {variable.name} {kind} {variable.causality} {variable.variability} "
            f"{unit.replace(' ', '_')}"
        )
    for declared in description.typeDefinitions:
        if declared.type == "Enumeration":
            lines |= {f"{name} {declared.name}.{item.name} = {item.value}" for item in declared.items}
    return lines


@pytest.mark.parametrize("name", NAMES)
def test_what_0_1_had_is_there_unchanged(name: str) -> None:
    expected = {line for line in LINES if line.startswith(f"{name} ")}
    assert len(expected) > 100
    assert sorted(expected - described(name)) == []
