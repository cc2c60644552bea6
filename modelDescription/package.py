"""Zip an FMU so that the same content always gives the same bytes.

package.py <Name>.fmu <name in the archive>=<file> ...
"""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

EARLIEST = (1980, 1, 1, 0, 0, 0)
"""The first date that a zip archive can state."""


def package(archive: Path, members: dict[str, Path]) -> None:
    """Write the archive, members in alphabetical order, without dates and owners."""
    archive.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as fmu:
        for name, file in sorted(members.items()):
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix: the permissions below are understood
            entry.external_attr = 0o644 << 16
            fmu.writestr(entry, file.read_bytes())


if __name__ == "__main__":
    package(Path(sys.argv[1]), {name: Path(file) for name, file in (a.split("=", 1) for a in sys.argv[2:])})
