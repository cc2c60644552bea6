"""Where an export comes from, and what is in it: provenance and a software bill of materials."""

from __future__ import annotations

import hashlib
import json
import platform
import re
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sim_scenarios.archives import read_archive
from sim_scenarios.exchange.system import System
from sim_scenarios.version import product_version

FOLDER = "extra/org.truenorth"
"""Of the evidence in an FMU."""
_COMPILERS = re.compile(rb"GCC: \([ -~]+\) [\d.]+|clang version [ -~]+|Linker: LLD [\d.]+")
_LIBRARIES = {
    "Eigen": (
        "MPL-2.0",
        "sources/Eigen/src/Core/util/Macros.h",
        r"#define EIGEN_(?:WORLD|MAJOR|MINOR)_VERSION (\d+)",
    ),
    "cereal": ("BSD-3-Clause", "sources/cereal/cereal.hpp", None),
    "FMI headers": ("BSD-2-Clause", "sources/fmi2Functions.h", r'#define fmi2Version "([\d.]+)"'),
}
"""Libraries in the FMUs by name: licence, a file of theirs in the sources, and how it tells the version,
which cereal does nowhere in what an FMU needs of it.
"""


def provenance(system: System, settings: Mapping[str, object]) -> str:
    """What an export was made from and by, as JSON."""
    return _json(
        {
            "product": "TrueNorth",
            "version": product_version(),
            "commit": _commit(),
            "recording" if system.recorded else "scenario": system.name,
            "settings": dict(settings),
            "communication_step": system.step,
            "stop_time": system.stop,
            "python": platform.python_version(),
            "numpy": np.__version__,
            "machine": f"{platform.system()} {platform.machine()}",
            "fmus": {component.fmu.name: _fmu(component.fmu.path) for component in system.components},
            "parameters": {component.name: dict(component.values) for component in system.components},
        }
    )


def bill_of_materials(system: System) -> str:
    """Software bill of materials of the FMUs, CycloneDX 1.5."""
    sources = read_archive(system.plant.fmu.path)
    libraries = [
        {"type": "library", "name": name, **_version(sources[file], rule),
         "licenses": [{"license": {"id": licence}}]}
        for name, (licence, file, rule) in _LIBRARIES.items()
        if file in sources
    ]  # fmt: skip
    fmus = [
        {"type": "library", "bom-ref": c.fmu.name, "name": c.fmu.name, "version": str(c.fmu.model.version),
         "hashes": [{"alg": "SHA-256", "content": _sha256(c.fmu.path)}],
         "licenses": [{"license": {"id": "BSD-3-Clause"}}]}
        for c in system.components
    ]  # fmt: skip
    subject = {"type": "application", "name": f"TrueNorth export of {system.name}",
               "version": product_version() or "unknown"}  # fmt: skip
    return _json(
        {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "metadata": {"component": subject},
         "components": [*fmus, *libraries]}
    )  # fmt: skip


def _fmu(path: Path) -> dict[str, object]:
    """Origin of an FMU as it was built, before the values of the export came in."""
    with zipfile.ZipFile(path) as content:
        binaries = [name for name in content.namelist() if name.startswith("binaries/")]
        compilers = {name: _compilers(content.read(name)) for name in binaries}
    return {"sha256": _sha256(path), "compilers": compilers}


def _compilers(binary: bytes) -> list[str]:
    """What a binary says of who compiled and linked it."""
    return sorted({found.decode("ascii") for found in _COMPILERS.findall(binary)})


def _version(source: bytes, rule: str | None) -> dict[str, str]:
    """Version that a source file tells; nothing where it does not."""
    found = re.findall(rule, source.decode()) if rule else []
    return {"version": ".".join(found)} if found else {}


def _commit() -> str | None:
    """Commit of the checkout that this package runs from, with `-dirty` if it has changes; None without."""
    checkout = Path(__file__).parents[2]
    if not (checkout / ".git").exists():
        return None
    try:
        found = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=40", "--match="],
            cwd=checkout, capture_output=True, text=True, check=False,
        )  # fmt: skip
    except OSError:
        return None
    return found.stdout.strip() or None


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _json(content: Mapping[str, object]) -> str:
    return json.dumps(content, indent=2) + "\n"
