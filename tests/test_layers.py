"""The dependencies of the C++ layers point one way (fmu_src/CMakeLists.txt)."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "fmu_src"
MAY_INCLUDE = {
    "contract": {"contract"},
    "inertial": {"inertial"},
    "estimation": {"estimation"},
    "error_models": {"error_models", "estimation", "inertial"},
    "aiding": {"aiding", "estimation", "inertial"},
    "filter": {"filter", "error_models", "aiding", "estimation", "inertial", "contract"},
    "plant": {"plant", "inertial"},
    "components": {
        "components",
        "filter",
        "error_models",
        "aiding",
        "estimation",
        "plant",
        "inertial",
        "contract",
    },
    "fmi": {"fmi", "components", "contract"},
}
INCLUDE = re.compile(r'^\s*#include "(?P<layer>\w+)/', re.MULTILINE)


def forbidden(layer: str, text: str) -> set[str]:
    """Layers that `text`, a file of `layer`, includes and must not; generated headers belong to no layer."""
    included = {match["layer"] for match in INCLUDE.finditer(text)}
    return (included & MAY_INCLUDE.keys()) - MAY_INCLUDE[layer]


def test_every_folder_is_a_known_layer() -> None:
    assert {path.name for path in SOURCES.iterdir() if path.is_dir()} == MAY_INCLUDE.keys()


@pytest.mark.parametrize("layer", MAY_INCLUDE)
def test_includes_point_one_way(layer: str) -> None:
    files = sorted((SOURCES / layer).rglob("*.[ch]pp"))
    assert files
    offences = {
        path.name: wrong for path in files if (wrong := forbidden(layer, path.read_text(encoding="utf-8")))
    }
    assert offences == {}


def test_an_include_against_the_direction_is_found() -> None:
    assert forbidden("inertial", '#include "plant/ship.hpp"\n#include "inertial/earth.hpp"\n') == {"plant"}
    assert forbidden("components", '#include "fmi/instance.hpp"\n#include <vector>\n') == {"fmi"}


@pytest.mark.parametrize("layer", sorted(MAY_INCLUDE.keys() - {"fmi"}))
def test_only_the_fmi_layer_knows_fmi(layer: str) -> None:
    for path in (SOURCES / layer).rglob("*.[ch]pp"):
        assert "fmi2" not in path.read_text(encoding="utf-8").lower(), path.name
