"""What a folder or an FMU holds, with the SHA-256 of each file; `sha256sum --check` reads the list, too."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

NAME = "SHA256SUMS"
_LINE = re.compile(r"([0-9a-f]{64})  ([^\n\0]+)")


def listed(files: Mapping[str, bytes]) -> str:
    """The list of files by their names."""
    return "".join(f"{hashlib.sha256(files[name]).hexdigest()}  {name}\n" for name in sorted(files))


def with_list(files: Mapping[str, bytes], folder: str) -> dict[str, bytes]:
    """Files together with their list, which lies in a folder among them."""
    return {**files, f"{folder}/{NAME}": listed(files).encode()}


def differences(files: Mapping[str, bytes], checksums: bytes) -> list[str]:
    """How files are not those of a list, a sentence each."""
    try:
        lines = checksums.decode("ascii").split("\n")
    except UnicodeDecodeError:
        return [f"{NAME} is damaged"]
    matches = [_LINE.fullmatch(line) for line in lines[:-1]]
    if lines[-1] or not all(matches):
        return [f"{NAME} is damaged"]
    expected = {match[2]: match[1] for match in matches if match}
    found = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    return [
        *(f"{name} is missing" for name in expected.keys() - found.keys()),
        *(f"{name} was not exported" for name in found.keys() - expected.keys()),
        *(f"{name} has changed" for name in expected.keys() & found.keys() if expected[name] != found[name]),
    ]


def of_folder(folder: Path) -> dict[str, bytes]:
    """Files below a folder by their names, the list itself left out."""
    return {
        name: path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and (name := path.relative_to(folder).as_posix()) != NAME
    }
