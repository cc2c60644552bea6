"""What the TOML declarations say arrives in the FMU."""

from __future__ import annotations

from math import isnan

from archives import ROOT
from calls import Fmu
from fmi2 import Fmi2
from reading import read


def test_the_fmu_says_what_the_declaration_says(fmu: Fmu) -> None:
    """Numbers arrive with all their bits."""
    declaration = read(ROOT / "modelDescription" / f"{fmu.name}.toml")
    spelling = Fmi2(declaration)
    assert list(fmu.variables) == [scalar.name for scalar in declaration.scalars]
    for scalar in declaration.scalars:
        described = fmu.variables[scalar.name]
        assert described.valueReference == scalar.reference
        assert described.start == spelling.start(scalar)
        if scalar.variable.optional:
            assert isnan(float(described.start))
        elif scalar.variable.type == "Real" and scalar.variable.start is not None:
            assert float(described.start) == scalar.variable.starts[scalar.position]
