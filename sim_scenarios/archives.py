"""Zip archives (FMU, SSP) that have the same bytes whenever they have the same content."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from sim_scenarios.errors import InputError

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state
_NEVER = re.compile(r"[\x00-\x1f\x7f\\:]")  # control characters, and what Windows takes for a path


def write_archive(
    archive: Path, members: Mapping[str, str | bytes | Path], compression: int = zipfile.ZIP_DEFLATED
) -> None:
    """Write an archive of texts, bytes and files, by the names that they have in it.

    A member that would lie outside the folder into which the archive is unpacked is refused.
    """
    for name in members:
        _check_member(name)
    archive.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(archive, "w", compression) as content:
        for name, member in sorted(members.items()):
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.compress_type = compression
            entry.create_system = 3  # Unix: the permissions below are understood
            entry.external_attr = 0o644 << 16
            content.writestr(entry, member.read_bytes() if isinstance(member, Path) else member)


def with_members(archive: Path, copy: Path, members: Mapping[str, str]) -> None:
    """Copy an archive and add members."""
    with zipfile.ZipFile(archive) as content:
        given = {entry.filename: content.read(entry) for entry in content.infolist() if not entry.is_dir()}
    write_archive(copy, {**given, **members})


def _check_member(name: str) -> None:
    parts = name.split("/")
    if _NEVER.search(name) or PurePosixPath(name).is_absolute() or {"", ".", ".."} & set(parts):
        raise InputError(f"{name!a} must not be a member of an archive: it may lie outside of it")
