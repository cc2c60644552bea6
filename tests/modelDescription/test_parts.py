"""Bills of materials: what is in a binary or in the wheel, in the same bytes every time."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest
from parts import bill_of_fmu, bill_of_wheel

from sim_scenarios import materials
from sim_scenarios.archives import write_archive
from sim_scenarios.errors import InputError

HEADERS = {
    "Eigen/src/Core/util/Macros.h": "#define EIGEN_WORLD_VERSION 3\n#define EIGEN_MAJOR_VERSION 4\n"
    "#define EIGEN_MINOR_VERSION 1\n",
    "cereal/version.hpp": "#define CEREAL_VERSION_MAJOR 1\n#define CEREAL_VERSION_MINOR 3\n"
    "#define CEREAL_VERSION_PATCH 2\n#define CEREAL_VERSION (CEREAL_VERSION_MAJOR * 10000)\n",
    "cereal/external/rapidjson/rapidjson.h": "#define RAPIDJSON_MAJOR_VERSION 1\n"
    "#define RAPIDJSON_MINOR_VERSION 0\n#define RAPIDJSON_PATCH_VERSION 2\n",
    "cereal/external/rapidxml/rapidxml.hpp": "// Version 1.13\n",
    "fmi3Functions.h": '#define fmi3Version "3.0"\n',
}
COMPILED = ["components/x.cpp", "Eigen/Core", "cereal/cereal.hpp", "fmi3Functions.h"]
PROJECT = """
[project]
name = "truenorth"
version = "7.1"
license = "BSD-3-Clause AND MPL-2.0"
dependencies = ["numpy>=2.1", "zarr>=2; python_version < '3.11'", "zarr>=3; python_version >= '3.11'"]

[project.optional-dependencies]
sign = ["cryptography>=42"]
dev = ["pytest>=8"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Headers of the libraries, and the description of an FMU."""
    for name, text in HEADERS.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "modelDescription.xml").write_text(
        '<fmiModelDescription modelName="Sieve" version="7.1" license="BSD-3-Clause"/>'
    )
    return tmp_path


def text(folder: Path, sources: Iterable[str] = COMPILED, runtime: Mapping[str, str] | None = None) -> str:
    return bill_of_fmu(folder / "modelDescription.xml", sources, [folder], [], runtime or {})


def by_name(bill: str) -> dict[str, Any]:
    return {part["name"]: part for part in json.loads(bill)["components"]}


def test_a_bill_names_the_product(folder: Path) -> None:
    bill = json.loads(text(folder))
    assert (bill["bomFormat"], bill["specVersion"], bill["version"]) == ("CycloneDX", "1.5", 1)
    subject = bill["metadata"]["component"]
    assert (subject["name"], subject["version"], subject["group"]) == ("Sieve", "7.1", "TrueNorth")
    assert subject["licenses"] == [{"license": {"id": "BSD-3-Clause"}}]


def test_a_bill_has_what_is_compiled_in_with_its_version(folder: Path) -> None:
    versions = {name: part["version"] for name, part in by_name(text(folder)).items()}
    assert versions == {"Eigen": "3.4.1", "cereal": "1.3.2", "FMI 3 headers": "3.0"}


@pytest.mark.parametrize(
    ("header", "name", "version", "licence"),
    [
        ("rapidjson/document.h", "RapidJSON", "1.0.2", {"license": {"id": "MIT"}}),
        ("rapidxml/rapidxml.hpp", "RapidXML", "1.13", {"expression": "BSL-1.0 OR MIT"}),
    ],
)
def test_what_cereal_brings_is_in_it_when_it_is_compiled_in(
    folder: Path, header: str, name: str, version: str, licence: dict[str, object]
) -> None:
    part = by_name(text(folder, [*COMPILED, f"cereal/external/{header}"]))[name]
    assert part == {"type": "library", "name": name, "version": version, "licenses": [licence]}


def test_a_library_of_which_nothing_is_known_is_refused(folder: Path) -> None:
    with pytest.raises(SystemExit, match=r"boost: must have a line in LIBRARIES of parts\.py"):
        bill_of_fmu(folder / "modelDescription.xml", COMPILED, [folder], [folder / "boost"], {})


def test_what_the_compiler_links_in_has_a_licence(folder: Path) -> None:
    parts = by_name(text(folder, runtime={"libstdc++": "12.2.0", "libgcc": "", "mingw-w64": ""}))
    exception = [{"expression": "GPL-3.0-or-later WITH GCC-exception-3.1"}]
    assert parts["libstdc++"]["version"] == "12.2.0"
    assert "version" not in parts["libgcc"]
    assert parts["libstdc++"]["licenses"] == parts["libgcc"]["licenses"] == exception
    assert parts["mingw-w64"]["licenses"] == [{"license": {"name": "public domain"}}]


def test_the_same_content_gives_the_same_bytes(folder: Path) -> None:
    bill = text(folder)
    assert text(folder, reversed(COMPILED)) == bill
    assert not {"serialNumber", "timestamp"} & {*json.loads(bill), *json.loads(bill)["metadata"]}
    assert str(folder) not in bill


def fmu(folder: Path, *platforms: str) -> Path:
    bills = {
        materials.name_in_fmu(name): text(folder, runtime={f"lib{'gcc' if name[0] == 'l' else 'c++'}": "1"})
        for name in platforms
    }
    write_archive(folder / "Sieve.fmu", {"modelDescription.xml": "", **bills})
    return folder / "Sieve.fmu"


def test_the_bill_of_the_wheel_has_fmus_their_parts_and_packages(folder: Path) -> None:
    (folder / "pyproject.toml").write_text(PROJECT)
    sieve = fmu(folder, "linux64", "win64")
    library = folder / "loop.so"
    library.write_bytes(b"loop")
    bill = bill_of_wheel(folder / "pyproject.toml", {"fmus/Sieve.fmu": sieve}, {"fmus/loop.so": library})
    subject, parts = json.loads(bill)["metadata"]["component"], by_name(bill)
    assert (subject["type"], subject["name"], subject["version"]) == ("application", "truenorth", "7.1")
    assert subject["licenses"] == [{"expression": "BSD-3-Clause AND MPL-2.0"}]
    assert len(parts) == len(json.loads(bill)["components"])  # each once
    packages = {"numpy", "zarr", "cryptography"}
    assert (
        parts.keys() == {"Sieve", "Eigen", "cereal", "FMI 3 headers", "libgcc", "libc++", "loop"} | packages
    )
    assert parts["loop"]["bom-ref"] == "fmus/loop.so"
    assert parts["loop"]["hashes"] == [{"alg": "SHA-256", "content": materials.sha256(library)}]
    assert parts["loop"]["licenses"] == [{"license": {"id": "BSD-3-Clause"}}]
    assert parts["Sieve"]["bom-ref"] == "fmus/Sieve.fmu"
    assert parts["Sieve"]["hashes"] == [{"alg": "SHA-256", "content": materials.sha256(sieve)}]
    assert {parts[name]["scope"] for name in ("numpy", "zarr")} == {"required"}
    assert parts["cryptography"]["scope"] == "optional"
    asked = [one["value"] for one in parts["zarr"]["properties"]]
    assert asked == ["zarr>=2; python_version < '3.11'", "zarr>=3; python_version >= '3.11'"]


def test_an_fmu_without_a_bill_is_named(folder: Path) -> None:
    with pytest.raises(InputError, match=r"Sieve\.fmu has no bill of materials"):
        materials.of_fmus({"Sieve": fmu(folder)})
