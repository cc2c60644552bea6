"""Zip archives (FMU, SSP) that have the same bytes whenever they have the same content."""

from __future__ import annotations

import io
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO, Final, TypeVar

from sim_scenarios.errors import InputError

T = TypeVar("T")

LARGEST: Final = 2**31
"""Bytes that a whole archive may have, and all its members unpacked."""

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state
_NEVER = re.compile(r"[\x00-\x1f\x7f\\:]")  # control characters, and what Windows takes for a path
_LOCAL_HEADER = 30  # bytes, the name left out
_UNICODE_NAME = 0x800  # the one flag of a member that is written
_PIECE = 2**20  # bytes that are unpacked at a time
_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_UNREADABLE: Final = (  # what `zipfile` raises when the bytes are those of no archive
    zipfile.BadZipFile,
    zlib.error,
    ValueError,
    RuntimeError,
    EOFError,
    OverflowError,
)


def as_bytes(content: str | bytes) -> bytes:
    """Content of a file; texts are UTF-8."""
    return content.encode() if isinstance(content, str) else content


def archive_bytes(members: Mapping[str, str | bytes], compression: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive of texts and bytes, by the names that they have in it.

    A member that would lie outside the folder into which the archive is unpacked is refused, and more than
    LARGEST bytes.
    """
    for name in members:
        _check_member(name)
    size = sum(len(as_bytes(member)) for member in members.values())
    if size > LARGEST:
        raise InputError(f"{len(members)} members of an archive have {size} bytes: must be at most {LARGEST}")
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


def read_archive(archive: Path, wanted: Callable[[str], bool] = lambda _: True) -> dict[str, bytes]:
    """Members by their names, all or those with a wanted name; folders are none.

    Raises
    ------
    InputError
        The file is damaged, names a member twice, packs or marks one as none is that is written here, or
        says of itself that unpacked it has more than LARGEST bytes; nothing of that is unpacked.
    """
    return of_members(archive, lambda member: member.read(), wanted)


def of_members(
    archive: Path, look: Callable[[IO[bytes]], T], wanted: Callable[[str], bool] = lambda _: True
) -> dict[str, T]:
    """What `look` makes of each member, by name; otherwise as `read_archive`."""
    found = {}
    with _opened(archive) as content:
        for entry in content.infolist():
            if not entry.is_dir() and wanted(entry.filename):
                with content.open(entry) as member:
                    found[entry.filename] = look(member)
    return found


def is_as_written(archive: Path) -> bool:
    """Whether an archive has, beside the content of its members, no byte that `write_archive` does not write.

    What the members hold is left to their checksums.
    """
    content, same = archive.read_bytes(), []
    directory, position = b"", 0
    with _opened(archive) as opened:
        entries = opened.infolist()
        for found in entries:
            entry = _entry(found.filename, zipfile.ZIP_DEFLATED)
            entry.CRC, entry.compress_size, entry.file_size = found.CRC, found.compress_size, found.file_size
            header = entry.FileHeader(zip64=False)
            directory += _directory_header(header, position, entry)
            begin, position = position + len(header), position + len(header) + entry.compress_size
            same.append(content[begin - len(header) : begin] == header)
            same.append(_is_one_stream(content[begin:position], entry.file_size))
    names, count = [entry.filename for entry in entries], len(entries)
    same.append(names == sorted(names) and all(map(_may_be_member, names)))
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, count, count, len(directory), position, 0)
    return all(same) and content[position:] == directory + end


def _is_one_stream(packed: bytes, size: int) -> bool:
    """Whether bytes are one compressed content of a size, with nothing after its end."""
    stream, unpacked = zlib.decompressobj(-zlib.MAX_WBITS), 0
    while not stream.eof and (part := stream.decompress(packed, _PIECE)):
        packed, unpacked = stream.unconsumed_tail, unpacked + len(part)
    return stream.eof and not stream.unused_data and unpacked == size


@contextmanager
def _opened(archive: Path) -> Iterator[zipfile.ZipFile]:
    """An archive whose members are such as are written here; what is wrong with it becomes an InputError."""
    if (size := archive.stat().st_size) > LARGEST:
        raise InputError(f"{archive.name} has {size} bytes: must be at most {LARGEST}")
    whole = io.BytesIO(archive.read_bytes())
    try:
        with zipfile.ZipFile(whole) as content:
            names = set()
            for entry in content.infolist():
                if entry.filename in names:
                    raise zipfile.BadZipFile(f"{entry.filename!a} is in it twice")
                names.add(entry.filename)
                if entry.flag_bits & ~_UNICODE_NAME or entry.compress_type not in _PACKED:
                    raise zipfile.BadZipFile(
                        f"{entry.filename!a} has the flags {entry.flag_bits:#x} and the compression "
                        f"{entry.compress_type}: must be 0 or {_UNICODE_NAME:#x}, and 0 or 8"
                    )
            size = sum(entry.file_size for entry in content.infolist())
            if size > LARGEST:
                raise zipfile.BadZipFile(f"unpacked it has {size} bytes: must be at most {LARGEST}")
            yield content
    except _UNREADABLE as error:
        raise InputError(f"{archive.name} is damaged: {str(error) or type(error).__name__}") from error


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
    if not _may_be_member(name):
        raise InputError(f"{name!a} must not be a member of an archive: it may lie outside of it")


def _may_be_member(name: str) -> bool:
    """Whether a member of this name lies in the folder into which an archive is unpacked."""
    parts = name.split("/")
    return not (_NEVER.search(name) or PurePosixPath(name).is_absolute() or {"", ".", ".."} & set(parts))
