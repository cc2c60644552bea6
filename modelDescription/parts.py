"""What of others is in an FMU or in the wheel, for their bills of materials."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sources import closure

from sim_scenarios import materials, toml
from sim_scenarios.materials import Part


@dataclass(frozen=True)
class Library:
    """A library of headers: how the names of its files begin, and which of them tells its version how."""

    name: str
    licence: str
    begin: str
    file: str
    version: str


LIBRARIES = (
    Library("Eigen", "MPL-2.0 AND Apache-2.0", "Eigen/", "Eigen/src/Core/util/Macros.h",
            r"define EIGEN_(?:WORLD|MAJOR|MINOR)_VERSION (\d+)"),
    Library("cereal", "BSD-3-Clause", "cereal/", "cereal/version.hpp",
            r"define CEREAL_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)"),
    Library("RapidJSON", "MIT", "cereal/external/rapidjson/", "cereal/external/rapidjson/rapidjson.h",
            r"define RAPIDJSON_(?:MAJOR|MINOR|PATCH)_VERSION (\d+)"),
    Library("RapidXML", "BSL-1.0 OR MIT", "cereal/external/rapidxml/",
            "cereal/external/rapidxml/rapidxml.hpp", r"Version (\d[\d.]*\d)"),
    Library("FMI 2 headers", "BSD-2-Clause", "fmi2", "fmi2Functions.h", r'define fmi2Version "([\d.]+)"'),
    Library("FMI 3 headers", "BSD-2-Clause", "fmi3", "fmi3Functions.h", r'define fmi3Version "([\d.]+)"'),
)  # fmt: skip

_GCC, _LLVM = "GPL-3.0-or-later WITH GCC-exception-3.1", "Apache-2.0 WITH LLVM-exception"
RUNTIMES = {
    "libstdc++": _GCC, "libgcc": _GCC,
    "libc++": _LLVM, "libc++abi": _LLVM, "libunwind": _LLVM, "compiler-rt": _LLVM,
    "mingw-w64": "public domain",
}  # fmt: skip
"""Licences of what compilers link in of their own."""


def bill_of_fmu(
    description: Path,
    sources: Iterable[str],
    folders: Sequence[Path],
    libraries: Sequence[Path],
    runtime: Mapping[str, str],
) -> str:
    """Bill of materials of a binary.

    Parameters
    ----------
    description : Path
        modelDescription.xml.
    sources : iterable of str
        What it is compiled from, by the names for `#include`.
    folders, libraries : sequence of Path
        Where these are found, as for `closure`.
    runtime : mapping of str to str
        Versions of what the compiler links in of its own, empty where they are not known.
    """
    known = {one.begin.rstrip("/") for one in LIBRARIES}
    if unknown := sorted({folder.name for folder in libraries} - known):
        raise SystemExit(f"{', '.join(unknown)}: must have a line in LIBRARIES of parts.py")
    root, names = ET.parse(description).getroot(), list(sources)
    subject = materials.part(
        root.attrib["modelName"], root.attrib["license"], root.attrib["version"], group="TrueNorth"
    )
    inside = [
        materials.part(one.name, one.licence, _version(one, folders, libraries))
        for one in LIBRARIES
        if any(name.startswith(one.begin) for name in names)
    ]
    linked = [materials.part(name, RUNTIMES[name], version) for name, version in runtime.items()]
    return materials.bill(subject, [*inside, *linked])


def bill_of_wheel(project: Path, fmus: Mapping[str, Path], libraries: Mapping[str, Path]) -> str:
    """Bill of materials of the wheel: FMUs, what is in them, libraries, and the packages that it asks for.

    Parameters
    ----------
    project : Path
        pyproject.toml.
    fmus, libraries : mapping of str to Path
        By the names that they have in the wheel; libraries have none but our own code, by the first licence.
    """
    about = toml.read(project)["project"]
    subject = materials.part(about["name"], about["license"], about["version"], type="application")
    extras = {name: asked for name, asked in about["optional-dependencies"].items() if name != "dev"}
    optional = [one for asked in extras.values() for one in asked]
    packages = [*_packages(about["dependencies"], "required"), *_packages(optional, "optional")]
    own = [
        materials.part(
            path.stem,
            about["license"].partition(" AND ")[0],
            about["version"],
            **{"bom-ref": name, "hashes": [materials.digest(path)]},
        )
        for name, path in libraries.items()
    ]
    return materials.bill(subject, [*materials.of_fmus(fmus), *own, *packages])


def _version(library: Library, folders: Sequence[Path], libraries: Sequence[Path]) -> str:
    """What the headers of a library say of its version."""
    found = closure([library.file], folders, libraries)[library.file].read_text(encoding="utf-8")
    return ".".join(re.findall(library.version, found))


def _packages(requirements: Iterable[str], scope: str) -> Iterator[Part]:
    """Packages of Python, which are not in the wheel, with the versions that may be installed."""
    asked: dict[str, list[str]] = {}
    for requirement in requirements:
        asked.setdefault(re.split(r"[^\w.-]", requirement)[0], []).append(requirement)
    for name, lines in asked.items():
        properties = [{"name": "truenorth:requirement", "value": line} for line in lines]
        yield {"type": "library", "name": name, "scope": scope, "purl": f"pkg:pypi/{name.lower()}",
               "properties": properties}  # fmt: skip
