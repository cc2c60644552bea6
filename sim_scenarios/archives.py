"""Zip archives (FMU, SSP) that have the same bytes whenever they have the same content."""

from __future__ import annotations

import io
import re
import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from sim_scenarios.errors import InputError

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state
_NEVER = re.compile(r"[\x00-\x1f\x7f\\:]")  # control characters, and what Windows takes for a path
_LOCAL_HEADER = 30  # bytes, the name left out


def as_bytes(content: str | bytes) -> bytes:
    """Content of a file; texts are UTF-8."""
    return content.encode() if isinstance(content, str) else content


def archive_bytes(members: Mapping[str, str | bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of texts and bytes, by the names that they have in it.

    A member that would lie outside the folder into which the archive is unpacked is refused.
    """
    for name in members:
        _check_member(name)
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as content:
        for name, member in sorted(members.items()):
            content.writestr(_entry(name, compression), member)
    return target.getvalue()


def write_archive(
    archive: Path, members: Mapping[str, str | bytes | Path], compression: int = zipfile.ZIP_DEFLATED
) -> None:
    """Write an archive of texts, bytes and files, as `archive_bytes` makes it."""
    read = {name: part.read_bytes() if isinstance(part, Path) else part for name, part in members.items()}
    content = archive_bytes(read, compression)
    archive.parent.mkdir(parents=True, exist_ok=True)
    archive.write_bytes(content)


def read_archive(archive: Path) -> dict[str, bytes]:
    """Members by their names; folders are none."""
    with zipfile.ZipFile(archive) as content:
        return {entry.filename: content.read(entry) for entry in content.infolist() if not entry.is_dir()}


def is_as_written(archive: Path) -> bool:
    """Whether an archive has, beside the content of its members, no byte that `write_archive` does not write.

    What the members hold is left to their checksums.
    """
    content = archive.read_bytes()
    with zipfile.ZipFile(archive) as opened:
        entries = opened.infolist()
    headers, directory, position = [], b"", 0
    for found in entries:
        entry = _entry(found.filename, zipfile.ZIP_DEFLATED)
        entry.CRC, entry.compress_size, entry.file_size = found.CRC, found.compress_size, found.file_size
        header = entry.FileHeader(zip64=False)
        headers.append(content[position : position + len(header)] == header)
        directory += _directory_header(header, position, entry)
        position += len(header) + entry.compress_size
    count = len(entries)
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, count, count, len(directory), position, 0)
    folders = any(found.is_dir() for found in entries)
    return all(headers) and not folders and content[position:] == directory + end


def _entry(name: str, compression: int) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST)
    entry.compress_type = compression
    entry.create_system = 3  # Unix: the permissions below are understood
    entry.external_attr = 0o644 << 16
    return entry


def _directory_header(header: bytes, position: int, entry: zipfile.ZipInfo) -> bytes:
    """Header in the directory at the end, which repeats that of the member."""
    maker = struct.pack("<4sBB", b"PK\1\2", entry.create_version, entry.create_system)
    place = struct.pack("<HHHLL", 0, 0, 0, entry.external_attr, position)
    return maker + header[4:_LOCAL_HEADER] + place + header[_LOCAL_HEADER:]


def _check_member(name: str) -> None:
    parts = name.split("/")
    if _NEVER.search(name) or PurePosixPath(name).is_absolute() or {"", ".", ".."} & set(parts):
        raise InputError(f"{name!a} must not be a member of an archive: it may lie outside of it")
