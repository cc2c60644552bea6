"""Dependencies point one way: those of the C++ layers (fmu_src/CMakeLists.txt), of scenarios, of studies."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "fmu_src"
MAY_INCLUDE = {
    "contract": {"contract"},
    "elementary": {"elementary"},
    "inertial": {"inertial", "elementary"},
    "estimation": {"estimation", "elementary"},
    "error_models": {"error_models", "estimation", "inertial", "elementary"},
    "aiding": {"aiding", "estimation", "inertial", "elementary"},
    "filter": {"filter", "error_models", "aiding", "estimation", "inertial", "elementary", "contract"},
    "plant": {"plant", "inertial", "elementary"},
    "components": {
        "components",
        "filter",
        "error_models",
        "aiding",
        "estimation",
        "plant",
        "inertial",
        "elementary",
        "contract",
    },
    "fmi": {"fmi", "components", "contract"},
    "runner": {"runner"},
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


OF_THE_LIBRARY = re.compile(
    r"std::(?:a?(?:sin|cos|tan)h?|atan2|exp[m12]*|log(?:1p|2|10)?|pow|cbrt|hypot|[lt]gamma|erfc?)\("
    r"|\.(?:sin|cos|tan|exp|log|pow|cube|slerp|angularDistance|eulerAngles)\("
    r"|\b(?:AngleAxis|Rotation2D)"
)
"""Functions of the C library, and of Eigen, whose last bit depends on the processor."""


@pytest.mark.parametrize("layer", sorted(MAY_INCLUDE))
def test_elementary_functions_are_our_own(layer: str) -> None:
    """So that the same seed has the same bits everywhere."""
    offences = {
        path.name: found
        for path in sorted((SOURCES / layer).rglob("*.[ch]pp"))
        if (found := OF_THE_LIBRARY.findall(path.read_text(encoding="utf-8")))
    }
    assert offences == {}


def test_a_function_of_the_library_is_found() -> None:
    for text in (
        "std::atan2(y, x)",
        "std::expm1(x)",
        "S.array().log().sum()",
        "std::pow(x, 2)",
        "a.slerp(t, b)",
    ):
        assert OF_THE_LIBRARY.search(text), text
    for text in ("std::abs(x)", "exponential(x)", "log.event(x)", "std::exp2f"):
        assert not OF_THE_LIBRARY.search(text), text


def test_no_source_is_included() -> None:
    """What the linter, which reads the sources of a target as one, is told to let pass."""
    files = sorted(SOURCES.rglob("*.[ch]pp"))
    assert files
    including = [
        path.name for path in files if re.search(r'#include .*\.cpp[">]', path.read_text(encoding="utf-8"))
    ]
    assert including == []


def test_an_include_against_the_direction_is_found() -> None:
    assert forbidden("inertial", '#include "plant/ship.hpp"\n#include "inertial/earth.hpp"\n') == {"plant"}
    assert forbidden("components", '#include "fmi/instance.hpp"\n#include <vector>\n') == {"fmi"}


@pytest.mark.parametrize("layer", sorted(MAY_INCLUDE.keys() - {"fmi"}))
def test_only_the_fmi_layer_knows_fmi(layer: str) -> None:
    for path in (SOURCES / layer).rglob("*.[ch]pp"):
        assert "fmi2" not in path.read_text(encoding="utf-8").lower(), path.name


PACKAGE = ROOT / "sim_scenarios"
ORDERS = {
    "scenario": ["entries", "tables", "sentences", "settings", "loading"],
    "studies": [
        *("quantities", "measured", "expectations", "draws", "plan", "case", "unfaulted", "cases"),
        *(
            "store",
            "packing",
            "runs",
            "cluster",
            "execution",
            "ensemble",
            "campaign",
            "statistics",
            "table",
            "regret",
            "findings",
        ),
        *("pictures", "page"),
    ],
}
"""Modules of a package: each imports only those before it."""
MODULES = [(package, module) for package, order in ORDERS.items() for module in order]
ABOVE_STUDIES = {"__init__.py", "cli", "papers", "studies"}
"""What may import studies."""


def imported(text: str, package: str) -> set[str]:
    """What a module imports from a package: its modules, and what the package itself offers, by name.

    The package as a whole is found by the name of the outermost one.
    """
    within, dotted = ".".join(filter(None, ("sim_scenarios", package))), set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            dotted |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            dotted |= {f"{node.module}.{name.name}" for name in node.names}
    inside = [name for name in dotted if f"{name}.".startswith(f"{within}.")]
    return {name.removeprefix(f"{within}.").partition(".")[0] for name in inside}


def source(*parts: str) -> str:
    return PACKAGE.joinpath(*parts).with_suffix(".py").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", ORDERS)
def test_every_module_has_its_place(package: str) -> None:
    assert {path.stem for path in (PACKAGE / package).glob("*.py")} == {"__init__", *ORDERS[package]}


@pytest.mark.parametrize(("package", "module"), MODULES)
def test_a_module_imports_those_before_it(package: str, module: str) -> None:
    order = ORDERS[package]
    assert imported(source(package, module), package) <= set(order[: order.index(module)])


def test_what_studies_stand_on_does_not_know_them() -> None:
    below = [p for p in PACKAGE.rglob("*.py") if p.relative_to(PACKAGE).parts[0] not in ABOVE_STUDIES]
    assert below
    assert [path for path in below if imported(path.read_text(encoding="utf-8"), "studies")] == []


def test_what_a_scenario_stands_on_does_not_know_it() -> None:
    texts = [source("scenario", module) for module in ORDERS["scenario"]]
    below = {name.partition(".")[0] for text in texts for name in imported(text, "")} - {"scenario"}
    assert {"fmus", "toml", "vehicles"} <= below
    files = [path for name in below for path in (*PACKAGE.glob(f"{name}.py"), *PACKAGE.glob(f"{name}/*.py"))]
    assert [path for path in files if imported(path.read_text(encoding="utf-8"), "scenario")] == []


def test_an_import_against_the_order_is_found() -> None:
    assert imported("from sim_scenarios.studies import page, store", "studies") == {"page", "store"}
    assert imported("def f():\n    from sim_scenarios.studies.plan import Plan", "studies") == {"plan"}
    assert imported("from sim_scenarios.scenario import load_scenario", "scenario") == {"load_scenario"}
    assert imported("from sim_scenarios.scenarios import it", "scenario") == set()
    assert imported("import sim_scenarios.studies.page as it", "studies") == {"page"}
    assert imported("import sim_scenarios.studies", "studies") == {"sim_scenarios"}
    assert imported("from sim_scenarios import studies", "studies") == {"sim_scenarios"}
    assert imported("import sim_scenarios.studies.page", "") == {"studies"}
    both = "from sim_scenarios import fmus\nfrom sim_scenarios.toml import read"
    assert imported(both, "") == {"fmus", "toml"}
