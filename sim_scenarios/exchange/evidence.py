"""Where an export comes from, and what is in it: provenance and a software bill of materials."""

from __future__ import annotations

import json
import platform
import re
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sim_scenarios import materials
from sim_scenarios.exchange.system import System
from sim_scenarios.version import product_version

FOLDER = materials.FOLDER
"""Of the evidence in an FMU."""
_COMPILERS = re.compile(rb"GCC: \([ -~]+\) [\d.]+|clang version [ -~]+|Linker: LLD [\d.]+")


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
    """Software bill of materials: the FMUs as they were built, and what is in them."""
    subject = {"type": "application", "name": f"TrueNorth export of {system.name}",
               "version": product_version() or "unknown"}  # fmt: skip
    return materials.bill(subject, materials.of_fmus({c.fmu.name: c.fmu.path for c in system.components}))


def _fmu(path: Path) -> dict[str, object]:
    """Origin of an FMU as it was built, before the values of the export came in."""
    with zipfile.ZipFile(path) as content:
        binaries = [name for name in content.namelist() if name.startswith("binaries/")]
        compilers = {name: _compilers(content.read(name)) for name in binaries}
    return {"sha256": materials.sha256(path), "compilers": compilers}


def _compilers(binary: bytes) -> list[str]:
    """What a binary says of who compiled and linked it."""
    return sorted({found.decode("ascii") for found in _COMPILERS.findall(binary)})


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


def _json(content: Mapping[str, object]) -> str:
    return json.dumps(content, indent=2) + "\n"
