"""Zip archives (FMU, SSP) that have the same bytes whenever they have the same content."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state
_LOCAL_HEADER = 30  # bytes, the name left out


def as_bytes(content: str | bytes) -> bytes:
    """Content of a file; texts are UTF-8."""
    return content.encode() if isinstance(content, str) else content


def archive_bytes(members: Mapping[str, str | bytes]) -> bytes:
    """An archive of texts and bytes, by the names that they have in it."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as content:
        for name, member in sorted(members.items()):
            content.writestr(_entry(name), member)
    return target.getvalue()


def write_archive(archive: Path, members: Mapping[str, str | bytes | Path]) -> None:
    """Write an archive of texts, bytes and files, by the names that they have in it."""
    archive.parent.mkdir(parents=True, exist_ok=True)
    read = {name: part.read_bytes() if isinstance(part, Path) else part for name, part in members.items()}
    archive.write_bytes(archive_bytes(read))


def read_archive(archive: Path) -> dict[str, bytes]:
    """Members by their names."""
    with zipfile.ZipFile(archive) as content:
        return {entry.filename: content.read(entry) for entry in content.infolist()}


def is_as_written(archive: Path) -> bool:
    """Whether an archive has, beside the content of its members, no byte that `write_archive` does not write.

    What the members hold is left to their checksums.
    """
    content = archive.read_bytes()
    with zipfile.ZipFile(archive) as opened:
        entries = opened.infolist()
    headers, directory, position = [], b"", 0
    for found in entries:
        entry = _entry(found.filename)
        entry.CRC, entry.compress_size, entry.file_size = found.CRC, found.compress_size, found.file_size
        header = entry.FileHeader(zip64=False)
        headers.append(content[position : position + len(header)] == header)
        directory += _directory_header(header, position, entry)
        position += len(header) + entry.compress_size
    count = len(entries)
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, count, count, len(directory), position, 0)
    return all(headers) and content[position:] == directory + end


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.create_system = 3  # Unix: the permissions below are understood
    entry.external_attr = 0o644 << 16
    return entry


def _directory_header(header: bytes, position: int, entry: zipfile.ZipInfo) -> bytes:
    """Header in the directory at the end, which repeats that of the member."""
    maker = struct.pack("<4sBB", b"PK\1\2", entry.create_version, entry.create_system)
    place = struct.pack("<HHHLL", 0, 0, 0, entry.external_attr, position)
    return maker + header[4:_LOCAL_HEADER] + place + header[_LOCAL_HEADER:]
