"""What a TOML declaration may say, what it may include, and the sentences for what it may not."""

from __future__ import annotations

from pathlib import Path

import pytest
from declaration import Declaration, DeclarationError
from generate import code, settings
from reading import read, read_settings

HERE = Path(__file__).parents[2] / "modelDescription"

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
    "vector of several units": variable(size="2", unit='["m", "m/s"]'),
    "integer": variable(type='"Integer"', unit="", start="3", min="0"),
    "boolean": variable(type='"Boolean"', unit="", start="true"),
    "enumeration": variable(type='"Colour"', unit="", start='"green"'),
    "output": variable(causality='"output"', start=""),
    "input that is read at the start": variable(causality='"input"', at_start="true"),
    "input that need not be given": variable(causality='"input"', start="nan", size="3"),
}

BAD = {
    "no unit": (variable(unit=""), "variable 'a.b': unit: every Real needs one"),
    "unknown unit": (
        variable(unit='"furlong"'),
        "variable 'a.b': unit: 'furlong' is unknown; known are 1, s,",
    ),
    "too few units": (variable(size="3", unit='["m", "m/s"]'), "unit: a list must have one unit for each"),
    "units of a scalar": (variable(unit='["m", "m/s"]'), "unit: a list must have one unit for each element"),
    "unknown unit of an element": (
        variable(size="2", unit='["m", "furlong"]'),
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
    "start of an input not finite": (
        variable(causality='"input"', start="inf"),
        "start: inf must be a finite number",
    ),
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
    "parameter that is read at the start": (variable(at_start="true"), "at_start: only an input may have it"),
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


def including(folder: Path, part: str, more: str = "", own: str = "") -> Path:
    """A declaration that includes `part`."""
    (folder / "shared").mkdir()
    (folder / "shared" / "part.toml").write_text(part)
    head = EXPERIMENT.replace("[default_experiment]", 'include = ["shared/part.toml"]\n[default_experiment]')
    path = folder / "Thing.toml"
    path.write_text(head + more + (own or variable(name='"own"')))
    return path


def included(folder: Path, part: str, more: str = "", own: str = "") -> Declaration:
    return read(including(folder, part, more, own))


def refused(folder: Path, part: str, more: str = "", own: str = "") -> str:
    with pytest.raises(DeclarationError) as error:
        included(folder, part, more, own)
    return str(error.value)


SHADE = """[enumeration.Shade]
description = "A shade"
items = [ { name = "dark", description = "Dark" } ]
"""


def test_what_is_included_comes_first(tmp_path: Path) -> None:
    part = SHADE + variable(name='"shade"', type='"Shade"', unit="", start='"dark"') + variable(size="2")
    declaration = included(tmp_path, part, own=variable(name='"c"', type='"Shade"', unit="", start='"dark"'))
    assert [scalar.name for scalar in declaration.scalars] == ["shade", "a.b[1]", "a.b[2]", "c"]
    assert list(declaration.enumeration) == ["Shade", "Colour"]


def test_an_included_variable_can_be_adapted(tmp_path: Path) -> None:
    more = '[override."a.b"]\nstart = 7.0\ndescription = "Other"\n'
    declaration = included(tmp_path, variable() + variable(name='"a.c"'), more)
    first, second, _ = declaration.variable
    assert (first.start, first.description, first.unit) == (7.0, "Other", "m")
    assert (second.start, second.description) == (1.0, "What it is")


@pytest.mark.parametrize(
    ("part", "more", "own", "sentence"),
    [
        (variable(unit=""), "", "", "shared/part.toml: variable 'a.b': unit: every Real needs one"),
        ("name = ", "", "", "shared/part.toml: Invalid value"),
        (EXPERIMENT + variable(), "", "", "shared/part.toml: name: Extra inputs are not permitted"),
        (variable(min="2.0"), "", "", "shared/part.toml: variable 'a.b': start: 1.0 must be at least 2.0"),
        (variable(), "", variable(), "Thing.toml: variable 'a.b': declared twice (in shared/part.toml)"),
        (SHADE.replace("Shade", "Colour") + variable(), "", "", "Thing.toml: enumeration 'Colour': declared"),
        (
            variable(),
            "[override.x]\nstart = 1.0\n",
            "",
            "Thing.toml: override 'x': no included file declares",
        ),
        (variable(), '[override."a.b"]\nname = "c"\n', "", "override 'a.b': must be a table of keys other"),
        (
            variable(),
            '[override."a.b"]\nunit = "furlong"\n',
            "",
            "variable 'a.b': unit: 'furlong' is unknown",
        ),
    ],
)
def test_bad_includes(tmp_path: Path, part: str, more: str, own: str, sentence: str) -> None:
    assert sentence in refused(tmp_path, part, more, own)


IN_SETTINGS = 'settings = ["paint"]\n' + SHADE
PAINT = variable(name='"paint.coats"') + variable(
    name='"paint.shade"', type='"Shade"', unit="", start='"dark"', causality='"tunable"'
)


def test_groups_in_settings_are_structs_of_all_components(tmp_path: Path) -> None:
    """Each with the starts of the file; a component tells where it starts otherwise."""
    more = '[override."paint.coats"]\nstart = 7.0\n'
    glow = variable(name='"paint.glow"', causality='"output"', start="")
    declaration = included(tmp_path, IN_SETTINGS + PAINT + glow, more)
    assert declaration.shared_enumerations == ["Shade"]
    assert list(declaration.own_enumerations) == ["Colour"]
    text = code(declaration)["variables.hpp"]
    assert '#include "settings/part.hpp"' in text
    assert "using settings::Shade;" in text
    assert "enum class Shade" not in text
    assert "settings::Paint paint{.coats = 7.0};" in text
    header = settings(read_settings(tmp_path / "shared" / "part.toml"), "part.toml")
    assert "enum class Shade : int" in header
    assert "double coats = 1.0;" in header
    assert "Shade shade = Shade::dark;" in header
    assert "glow" not in header


@pytest.mark.parametrize(
    ("part", "own", "sentence"),
    [
        (IN_SETTINGS + variable(), "", "shared/part.toml: settings: no parameter of the file is in"),
        (
            IN_SETTINGS + PAINT.replace("Shade", "Colour"),
            "",
            "shared/part.toml: variable 'paint.shade': type: 'Colour' must be of this file",
        ),
        (
            IN_SETTINGS + PAINT + variable(name='"paint.a.b"'),
            "",
            "'paint.a.b': settings have no groups",
        ),
        (
            IN_SETTINGS + PAINT,
            variable(name='"paint.gloss"'),
            "Thing.toml: variable 'paint.gloss': the group 'paint' is in the settings of shared/part.toml",
        ),
    ],
)
def test_bad_settings(tmp_path: Path, part: str, own: str, sentence: str) -> None:
    assert sentence in refused(tmp_path, part, own=own)


@pytest.mark.parametrize("key", ["settings = []", "shared = {}"])
def test_a_component_has_no_settings_of_its_own(tmp_path: Path, key: str) -> None:
    head = EXPERIMENT.replace("[default_experiment]", f"{key}\n[default_experiment]")
    assert "only an included file may have settings" in reason(tmp_path, variable(), head=head)


def test_of_another_component_the_outputs_alone(tmp_path: Path) -> None:
    """With the enumerations that they have, and in the words of their own declaration or of this one."""
    shade = variable(name='"shade"', causality='"output"', type='"Shade"', unit="", start="")
    hue = SHADE.replace("Shade", "Hue")
    path = including(tmp_path, SHADE + hue + variable() + shade + variable(name='"a.c"', causality='"input"'))
    path.write_text(path.read_text().replace("include =", "outputs_of ="))
    declaration = read(path)
    assert [variable.name for variable in declaration.variable] == ["shade", "own"]
    assert list(declaration.enumeration) == ["Shade", "Colour"]
    path.write_text(path.read_text().replace("part.toml", "other.toml"))
    with pytest.raises(DeclarationError, match=r"outputs_of: there is no file 'shared/other.toml'"):
        read(path)


def test_a_missing_include(tmp_path: Path) -> None:
    path = including(tmp_path, variable())
    path.write_text(path.read_text().replace("part.toml", "other.toml"))
    with pytest.raises(DeclarationError, match=r"Thing.toml: include: there is no file 'shared/other.toml'"):
        read(path)
    path.write_text(path.read_text().replace('["shared/other.toml"]', '"shared/part.toml"'))
    with pytest.raises(DeclarationError, match=r"Thing.toml: include: must be a list of file names"):
        read(path)


@pytest.mark.parametrize("path", sorted(HERE.glob("*.toml")), ids=lambda path: path.stem)
def test_the_declarations_of_the_project_are_sound(path: Path) -> None:
    assert read(path).name == path.stem


def test_units_by_element(tmp_path: Path) -> None:
    own = variable(name='"own"', size="4", unit='["m", "m", "m/s", "m"]')
    declaration = included(tmp_path, variable(), own=own)
    assert declaration.variable[1].units == ["m", "m", "m/s", "m"]
    assert declaration.variable[1].unit_text == "m (1 to 2), m/s (3 to 3), m (4 to 4)"
    assert list(declaration.units()) == ["m", "m/s"]
