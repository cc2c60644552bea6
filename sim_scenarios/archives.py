"""Zip archives (FMU, SSP) that have the same bytes whenever they have the same content."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state


def write_archive(archive: Path, members: Mapping[str, str | bytes | Path]) -> None:
    """Write an archive of texts, bytes and files, by the names that they have in it."""
    archive.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as content:
        for name, member in sorted(members.items()):
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix: the permissions below are understood
            entry.external_attr = 0o644 << 16
            content.writestr(entry, member.read_bytes() if isinstance(member, Path) else member)


def with_members(archive: Path, copy: Path, members: Mapping[str, str]) -> None:
    """Copy an archive and add members."""
    with zipfile.ZipFile(archive) as content:
        given = {entry.filename: content.read(entry) for entry in content.infolist()}
    write_archive(copy, {**given, **members})
