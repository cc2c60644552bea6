"""Zip an FMU so that the same content always gives the same bytes, or join those of several platforms.

    package.py pack <Name>.fmu <name in the archive>=<file> ...
                    [--folder <include folder>] ... [--library <folder included by its name>] ...
                    [--runtime <library of the compiler>=<its version, or nothing>] ...
    package.py join <Name>.fmu <FMU of one platform> ...
    package.py bill <file> <pyproject.toml> <name in the wheel>=<FMU or library> ...

To the files given, `pack` adds those that `sources/buildDescription.xml` names and all that they include, and
the bill of materials of the binary; `bill` writes that of the wheel.
"""

from __future__ import annotations

import argparse
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import mach_o
from parts import bill_of_fmu, bill_of_wheel
from sources import closure

from sim_scenarios import materials
from sim_scenarios.archives import write_archive

BUILD = "sources/buildDescription.xml"


def pack(
    archive: Path,
    members: Mapping[str, Path],
    folders: list[Path],
    libraries: list[Path],
    runtime: Mapping[str, str],
) -> None:
    """Write an FMU from files, with its sources and its bill of materials, named for its platform."""
    listed = [str(element.get("name")) for element in ET.parse(members[BUILD]).iter("SourceFile")]
    sources = closure(listed, folders, libraries)
    if missing := set(listed) - set(sources):
        raise SystemExit(f"{members[BUILD]}: {', '.join(sorted(missing))} in none of the folders")
    (platform,) = {name.split("/")[1] for name in members if name.startswith("binaries/")}
    bill = bill_of_fmu(members["modelDescription.xml"], sources, folders, libraries, runtime)
    written = {f"sources/{name}": path for name, path in sources.items()}
    write_archive(archive, {**members, **written, materials.name_in_fmu(platform): bill})


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


def pairs(parts: Iterable[str]) -> dict[str, str]:
    """Parts `<name>=<what it stands for>` of the command line."""
    return dict(part.split("=", 1) for part in parts)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("action", choices=["pack", "join", "bill"])
    parser.add_argument("archive", type=Path)
    parser.add_argument("parts", nargs="+")
    parser.add_argument("--folder", type=Path, action="append", default=[])
    parser.add_argument("--library", type=Path, action="append", default=[])
    parser.add_argument("--runtime", action="append", default=[])
    given = parser.parse_args()
    if given.action == "join":
        join(given.archive, [Path(part) for part in given.parts])
    elif given.action == "bill":
        project, *shipped = given.parts
        files = {name: Path(file) for name, file in pairs(shipped).items()}
        fmus = {name: file for name, file in files.items() if file.suffix == ".fmu"}
        libraries = {name: file for name, file in files.items() if name not in fmus}
        bill = bill_of_wheel(Path(project), fmus, libraries)
        given.archive.write_text(bill, encoding="utf-8", newline="\n")
    else:
        members = {name: Path(file) for name, file in pairs(given.parts).items()}
        pack(given.archive, members, given.folder, given.library, pairs(given.runtime))


if __name__ == "__main__":
    main()
