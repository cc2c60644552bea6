"""Zip an FMU so that the same content always gives the same bytes, or join those of several platforms.

    package.py pack <Name>.fmu <name in the archive>=<file> ...
                    [--folder <include folder>] ... [--library <folder included by its name>] ...
    package.py join <Name>.fmu <FMU of one platform> ...

To the files given, `pack` adds those that `sources/buildDescription.xml` names and all that they include.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import mach_o
from sources import closure

from sim_scenarios.archives import write_archive

BUILD = "sources/buildDescription.xml"


def pack(archive: Path, members: dict[str, Path], folders: list[Path], libraries: list[Path]) -> None:
    """Write an FMU from files, with its sources."""
    listed = [str(element.get("name")) for element in ET.parse(members[BUILD]).iter("SourceFile")]
    sources = closure(listed, folders, libraries)
    if missing := set(listed) - set(sources):
        raise SystemExit(f"{members[BUILD]}: {', '.join(sorted(missing))} in none of the folders")
    write_archive(archive, {**members, **{f"sources/{name}": path for name, path in sources.items()}})


def join(archive: Path, fmus: list[Path]) -> None:
    """Write one FMU with the binaries of several, which must be the same in all else."""
    joined: dict[str, list[bytes]] = {}
    for fmu in fmus:
        with zipfile.ZipFile(fmu) as content:
            for name in content.namelist():
                member, known = content.read(name), joined.setdefault(name, [])
                if known and not (mach_o.is_binary(member) or member == known[0]):
                    raise SystemExit(f"{fmu}: {name} is not as in the others; build all from one checkout")
                if member not in known:
                    known.append(member)
    write_archive(
        archive, {name: mach_o.universal(parts) if parts[1:] else parts[0] for name, parts in joined.items()}
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("action", choices=["pack", "join"])
    parser.add_argument("archive", type=Path)
    parser.add_argument("parts", nargs="+")
    parser.add_argument("--folder", type=Path, action="append", default=[])
    parser.add_argument("--library", type=Path, action="append", default=[])
    given = parser.parse_args()
    if given.action == "join":
        join(given.archive, [Path(part) for part in given.parts])
    else:
        members = {name: Path(file) for name, file in (part.split("=", 1) for part in given.parts)}
        pack(given.archive, members, given.folder, given.library)


if __name__ == "__main__":
    main()
