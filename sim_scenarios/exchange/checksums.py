"""What a folder or an FMU holds, with the SHA-256 of each file; `sha256sum --check` reads the list, too."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO, Final

from sim_scenarios.archives import of_members
from sim_scenarios.exchange.signature import Sign

NAME = "SHA256SUMS"
SIGNATURE = f"{NAME}.sig"
"""Of the list, beside it; it is not listed."""
_PIECE: Final = 2**20  # bytes that are read at a time
_LINE = re.compile(r"([0-9a-f]{64})  ([^\n\0]+)")


def listed(files: Mapping[str, bytes]) -> str:
    """The list of files by their names."""
    return "".join(f"{hashlib.sha256(files[name]).hexdigest()}  {name}\n" for name in sorted(files))


def with_list(files: Mapping[str, bytes], folder: str = "", sign: Sign | None = None) -> dict[str, bytes]:
    """Files together with their list, which lies in a folder among them, and perhaps its signature."""
    place, content = f"{folder}/" if folder else "", listed(files).encode()
    signature = {f"{place}{SIGNATURE}": sign(content)} if sign else {}
    return {**files, f"{place}{NAME}": content, **signature}


def of_archive(archive: Path) -> dict[str, str]:
    """SHA-256 of the members of an archive by their names, which are read piece by piece."""
    return of_members(archive, _digest)


def of_folder(folder: Path) -> dict[str, str]:
    """SHA-256 of the files below a folder by their names, the list itself and its signature left out.

    A link, an empty folder or what else no export has is named as well, with a sum that no file has.
    """
    own = (folder / NAME, folder / SIGNATURE)
    return {
        path.relative_to(folder).as_posix(): _digest_of(path)
        for path in _leaves(folder)
        if path not in own or path.is_symlink() or not path.is_file()
    }


def differences(found: Mapping[str, str], checksums: bytes) -> list[str]:
    """How files, of which the SHA-256 are given by name, are not those of a list, a sentence each."""
    if (expected := _expected(checksums)) is None:
        return [f"{NAME} is damaged"]
    return [
        *(f"{name} is missing" for name in expected.keys() - found.keys()),
        *(f"{name} was not exported" for name in found.keys() - expected.keys()),
        *(f"{name} has changed" for name in expected.keys() & found.keys() if expected[name] != found[name]),
    ]


def unchanged(folder: Path) -> list[str]:
    """Names of the files of a folder that are as the list in it says, and of the list's signature.

    There are none where there is no list.
    """
    own = folder / NAME
    expected = (_expected(own.read_bytes()) if own.is_file() else None) or {}
    names = {path.relative_to(folder).as_posix(): path for path in _leaves(folder)} if expected else {}
    same = [name for name, path in names.items() if name in expected and _digest_of(path) == expected[name]]
    return [*same, SIGNATURE] if SIGNATURE in names else same


def _expected(checksums: bytes) -> dict[str, str] | None:
    """SHA-256 of the files of a list by their names, if it is one as `listed` writes it."""
    try:
        lines = checksums.decode("ascii").split("\n")
    except UnicodeDecodeError:
        return None
    matches = [match for line in lines[:-1] if (match := _LINE.fullmatch(line))]
    expected = {match[2]: match[1] for match in matches}
    whole = not lines[-1] and len(matches) == len(lines) - 1
    return expected if whole and [match[2] for match in matches] == sorted(expected) else None


def _leaves(folder: Path) -> Iterator[Path]:
    """All that lies below a folder but the folders that hold something; a link is not followed."""
    for path in sorted(folder.iterdir()):
        if path.is_dir() and not path.is_symlink() and any(path.iterdir()):
            yield from _leaves(path)
        else:
            yield path


def _digest_of(path: Path) -> str:
    """SHA-256 of a file, or nothing of what is none."""
    if path.is_symlink() or not path.is_file():
        return ""
    with path.open("rb") as file:
        return _digest(file)


def _digest(file: IO[bytes]) -> str:
    digest = hashlib.sha256()
    while piece := file.read(_PIECE):
        digest.update(piece)
    return digest.hexdigest()
