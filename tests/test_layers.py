"""The dependencies of the C++ layers point one way (fmu_src/CMakeLists.txt), and so do those of studies."""

from __future__ import annotations

import ast
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


PACKAGE = ROOT / "sim_scenarios"
STUDIES = "sim_scenarios.studies"
ORDER = [
    *("quantities", "measured", "expectations", "draws", "plan", "store", "runs", "execution", "ensemble"),
    *("campaign", "statistics", "table", "regret", "pictures", "page"),
]
"""Modules of studies: each imports only those before it."""
ABOVE = {"__init__.py", "cli", "papers", "studies"}
"""What may import studies."""


def imported(text: str) -> set[str]:
    """Modules of studies that a module imports."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == STUDIES:
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{STUDIES}."):
            found.add(str(node.module).removeprefix(f"{STUDIES}."))
    return found


def test_every_module_of_studies_has_its_place() -> None:
    assert {path.stem for path in (PACKAGE / "studies").glob("*.py")} == {"__init__", *ORDER}


@pytest.mark.parametrize("module", ORDER)
def test_a_module_of_studies_imports_those_before_it(module: str) -> None:
    found = imported((PACKAGE / "studies" / f"{module}.py").read_text(encoding="utf-8"))
    assert found <= set(ORDER[: ORDER.index(module)])


def test_what_studies_stand_on_does_not_know_them() -> None:
    below = [p for p in PACKAGE.rglob("*.py") if p.relative_to(PACKAGE).parts[0] not in ABOVE]
    assert below
    assert [path for path in below if imported(path.read_text(encoding="utf-8"))] == []


def test_an_import_against_the_order_is_found() -> None:
    assert imported("from sim_scenarios.studies import page, store") == {"page", "store"}
    assert imported("def f():\n    from sim_scenarios.studies.plan import Plan") == {"plan"}
