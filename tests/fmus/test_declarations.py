"""The TOML declarations: what they say arrives in the FMU; what they may not say is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from calls import Fmu
from conftest import ROOT
from declaration import DeclarationError, read
from fmi2 import Fmi2

EXPERIMENT = """name = "Thing"
description = "A thing"
[default_experiment]
stop_time = 10.0
step_size = 0.1
[enumeration.Colour]
description = "A colour"
items = [ { name = "red", description = "Red" }, { name = "green", description = "Green" } ]
"""


def variable(**keys: str) -> str:
    """A sound variable, with some keys replaced by other TOML text; an empty text leaves the key out."""
    sound = {
        "name": '"a.b"',
        "causality": '"parameter"',
        "type": '"Real"',
        "unit": '"m"',
        "start": "1.0",
        "description": '"What it is"',
    }
    lines = [f"{key} = {value}" for key, value in {**sound, **keys}.items() if value]
    return "\n".join(["[[variable]]", *lines, ""])


def reason(folder: Path, *variables: str, head: str = EXPERIMENT) -> str:
    path = folder / "Thing.toml"
    path.write_text(head + "".join(variables))
    try:
        read(path)
    except DeclarationError as error:
        return str(error)
    return "accepted"


SOUND = {
    "scalar": variable(),
    "display unit": variable(unit='"rad"', display_unit='"deg"'),
    "vector": variable(size="3", start="[1.0, 2.0, 3.0]"),
    "broadcast": variable(size="3"),
    "matrix": variable(size="[2, 3]", start="[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]"),
    "integer": variable(type='"Integer"', unit="", start="3", min="0"),
    "boolean": variable(type='"Boolean"', unit="", start="true"),
    "enumeration": variable(type='"Colour"', unit="", start='"green"'),
    "output": variable(causality='"output"', start=""),
}

BAD = {
    "no unit": (variable(unit=""), "variable 'a.b': unit: every Real needs one"),
    "unknown unit": (
        variable(unit='"furlong"'),
        "variable 'a.b': unit: 'furlong' is unknown; known are 1, s,",
    ),
    "unknown display unit": (variable(display_unit='"deg"'), "display_unit: 'deg' is unknown; for m: mm, km"),
    "unit of an integer": (variable(type='"Integer"', start="1"), "unit: only a Real may have it"),
    "unknown type": (
        variable(type='"Colours"', unit=""),
        "type: 'Colours' is unknown; known are Real, Integer",
    ),
    "unknown causality": (
        variable(causality='"local"'),
        "variable 'a.b': causality: Input should be 'parameter'",
    ),
    "unknown key": (variable(units='"m"'), "variable 'a.b': units: Extra inputs are not permitted"),
    "no start": (variable(start=""), "start: every parameter needs one"),
    "start of an output": (variable(causality='"output"'), "start: an output is calculated and has none"),
    "start out of range": (variable(min="2.0"), "start: 1.0 must be at least 2.0"),
    "start at an exclusive limit": (variable(above="1.0"), "start: 1.0 must be greater than 1.0"),
    "start not finite": (variable(start="nan"), "start: nan must be a finite number"),
    "start of the wrong type": (variable(start='"x"'), "start: 'x' must be a number, of type Real"),
    "fraction for an integer": (
        variable(type='"Integer"', unit="", start="1.5"),
        "must be a number, of type Integer",
    ),
    "too large an integer": (
        variable(type='"Integer"', unit="", start="3000000000"),
        "must fit into 32 bits",
    ),
    "start of another size": (
        variable(size="3", start="[1.0, 2.0]"),
        "start: the list must have the size [3]",
    ),
    "unknown item": (variable(type='"Colour"', unit="", start='"blue"'), "'blue' is not an item of Colour"),
    "two lower limits": (variable(min="0.0", above="0.0"), "min, above: give one of the two"),
    "capitals": (variable(name='"a.B"'), "name: 'B' must be lower-case words joined by underscores"),
    "C++ word": (variable(name='"a.default"'), "name: 'default' is a reserved word in C++"),
    "long name": (variable(name=f'"{"a" * 61}"', size="3"), "name: 64 characters, at most 63 are portable"),
    "leaf and group": (variable() + variable(name='"a.b.c"'), "'a.b' is a variable and cannot be a group"),
    "declared twice": (variable() * 2, "variable 'a.b': declared twice"),
    "group named like an enumeration": (variable(name='"colour.x"'), "would have one C++ name"),
    "depends on nothing": (
        variable(causality='"output"', start="", depends='["x.*"]'),
        "'x.*' matches no parameter",
    ),
}


@pytest.mark.parametrize("case", SOUND)
def test_sound(tmp_path: Path, case: str) -> None:
    assert reason(tmp_path, SOUND[case]) == "accepted"


@pytest.mark.parametrize("case", BAD)
def test_bad(tmp_path: Path, case: str) -> None:
    text, sentence = BAD[case]
    answer = reason(tmp_path, text)
    assert answer.startswith("Thing.toml: ")
    assert sentence in answer


def test_bad_heads(tmp_path: Path) -> None:
    assert "default_experiment: step_size" in reason(
        tmp_path, variable(), head=EXPERIMENT.replace("step_size = 0.1", "step_size = 0.0")
    )
    assert "name = 'Other': must be that of the file" in reason(
        tmp_path, variable(), head=EXPERIMENT.replace('"Thing"', '"Other"')
    )
    assert "Thing.toml: " in reason(tmp_path, head="name = ")


def test_the_fmu_says_what_the_declaration_says(fmu: Fmu) -> None:
    """Numbers arrive with all their bits."""
    declaration = read(ROOT / "modelDescription" / f"{fmu.name}.toml")
    spelling = Fmi2(declaration)
    assert list(fmu.variables) == [scalar.name for scalar in declaration.scalars]
    for scalar in declaration.scalars:
        described = fmu.variables[scalar.name]
        assert described.valueReference == scalar.reference
        assert described.start == spelling.start(scalar)
        if scalar.variable.type == "Real" and scalar.variable.start is not None:
            assert float(described.start) == scalar.variable.starts[scalar.position]
