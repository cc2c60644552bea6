"""Bytes of files, compressed with gzip or not."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path
from typing import Final

from sim_scenarios.errors import InputError

BEGINNING: Final = 16384
"""Bytes by which a format is recognised."""
_GZIP: Final = b"\x1f\x8b"


def whole(path: Path) -> bytes:
    """All bytes of a file.

    Raises
    ------
    InputError
        If there is no such file, or it cannot be read.
    """
    try:
        content = path.read_bytes()
        return gzip.decompress(content) if content.startswith(_GZIP) else content
    except FileNotFoundError:
        raise InputError(f"there is no recording {path}") from None
    except (OSError, EOFError, zlib.error) as error:  # the last two of a damaged .gz
        raise InputError(f"{path}: cannot be read: {error}") from None


def beginning(path: Path) -> bytes:
    """First bytes of a file; none where there is no file that can be read."""
    try:
        with path.open("rb") as file:
            if not file.read(len(_GZIP)).startswith(_GZIP):
                file.seek(0)
                return file.read(BEGINNING)
        with gzip.open(path) as unpacked:
            return unpacked.read(BEGINNING)
    except (OSError, EOFError, zlib.error):
        return b""
