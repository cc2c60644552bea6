"""What a component is compiled from, found by following the includes.

A header whose code stands in a file beside it (`earth.hpp`, `earth.cpp`) brings that file with it, and a
header `loose.hpp` what is instantiated for it (`instances/loose_*.cpp` of any folder). Conditions around an
include are not looked at: other platforms take other branches.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*[<"]([^>"\n]+)[>"]', re.MULTILINE)


def closure(names: Iterable[str], folders: Sequence[Path], libraries: Sequence[Path] = ()) -> dict[str, Path]:
    """Files that a compilation reads, by the names that they have for `#include`.

    Parameters
    ----------
    names : iterable of str
        Where to begin.
    folders : sequence of Path
        Include folders.
    libraries : sequence of Path
        Folders of libraries that are included as `<folder/header>`.

    Returns
    -------
    dict of str to Path
        What is in none of the folders belongs to the compiler and is left out.
    """
    found: dict[str, Path] = {}
    todo = list(names)
    while todo:
        name = todo.pop()
        path = _find(name, folders, libraries)
        if name in found or path is None:
            continue
        found[name] = path
        if name.endswith(".hpp"):
            todo.append(name.removesuffix(".hpp") + ".cpp")
            todo += _instances(Path(name).stem, folders)
        for included in _INCLUDE.findall(path.read_text(encoding="utf-8", errors="replace")):
            todo += [posixpath.normpath(posixpath.join(posixpath.dirname(name), included)), included]
    return found


def _instances(stem: str, folders: Sequence[Path]) -> Iterator[str]:
    """Source files that instantiate the templates of a header for one model."""
    for folder in folders:
        for path in sorted(folder.glob(f"*/instances/{stem}_*.cpp")):
            yield path.relative_to(folder).as_posix()


def _find(name: str, folders: Sequence[Path], libraries: Sequence[Path]) -> Path | None:
    return next((path for path in _candidates(name, folders, libraries) if path.is_file()), None)


def _candidates(name: str, folders: Sequence[Path], libraries: Sequence[Path]) -> Iterator[Path]:
    yield from (folder / name for folder in folders)
    first, _, rest = name.partition("/")
    yield from (library / rest for library in libraries if library.name == first)
