"""Software bills of materials: CycloneDX 1.5, with the same bytes whenever they say the same."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from sim_scenarios.archives import read_archive
from sim_scenarios.errors import InputError

Part = dict[str, Any]
"""A component, as CycloneDX has it."""

FOLDER: Final = "extra/org.truenorth"
"""Of what an FMU says of itself beyond the standard."""
_OF_A_BINARY: Final = re.compile(rf"{FOLDER}/sbom\..+\.cdx\.json")
_EXPRESSION: Final = re.compile(r" (AND|OR|WITH) ")


def name_in_fmu(platform: str) -> str:
    """Where an FMU has the bill of its binary for a platform."""
    return f"{FOLDER}/sbom.{platform}.cdx.json"


def part(name: str, licence: str, version: str | None = None, **more: object) -> Part:
    """A library of a licence: an identifier or an expression of SPDX, or in words; and what else is known."""
    if _EXPRESSION.search(licence):
        said: dict[str, object] = {"expression": licence}
    else:
        said = {"license": {"name" if " " in licence else "id": licence}}
    known = {"version": version} if version else {}
    return {"type": "library", "name": name, **known, **more, "licenses": [said]}


def bill(subject: Part, parts: Iterable[Part]) -> str:
    """What is in a subject. Neither the time nor a serial number is in it: they would differ every time."""
    content = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": subject},
        "components": list(parts),
    }
    return json.dumps(content, indent=2) + "\n"


def of_fmus(fmus: Mapping[str, Path]) -> list[Part]:
    """FMUs, by the names that they get in the bill, and what by their own bills is in any of them.

    Raises
    ------
    InputError
        An FMU has no bill.
    """
    parts: list[Part] = []
    inside: list[Part] = []
    for name, path in fmus.items():
        bills = read_archive(path, lambda member: _OF_A_BINARY.fullmatch(member) is not None)
        if not bills:
            raise InputError(f"{path.name} has no bill of materials: must have one; build it again")
        for content in bills.values():
            said = json.loads(content)
            inside += [one for one in said["components"] if one not in inside]
        parts.append({**said["metadata"]["component"], "bom-ref": name, "hashes": [digest(path)]})
    return [*parts, *inside]


def digest(path: Path) -> dict[str, str]:
    """Hash of a file, as a bill has it."""
    return {"alg": "SHA-256", "content": sha256(path)}


def sha256(path: Path) -> str:
    """Hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
