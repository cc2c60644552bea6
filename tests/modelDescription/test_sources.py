"""The files that a compilation reads."""

from __future__ import annotations

from pathlib import Path

from sources import closure

FILES = {
    "own/main.cpp": '#include "parts/one.hpp"\n#include <vector>\n',
    "own/parts/one.hpp": "#pragma once\n#if ELSEWHERE\n  #  include <Library/All>\n#endif\n",
    "own/parts/one.cpp": '#include "parts/one.hpp"\n',
    "own/parts/alone.hpp": "",
    "installed/Library/All": '#include "src/Deep.h"\n',
    "installed/Library/src/Deep.h": '#include "../plugins/Near.h"\n#include "../All"\n',
    "installed/Library/plugins/Near.h": "",
    "installed/vector": "of another library",
}


def test_everything_that_is_included_and_nothing_else(tmp_path: Path) -> None:
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    found = closure(["main.cpp"], [tmp_path / "own"], [tmp_path / "installed" / "Library"])
    assert {name: path.relative_to(tmp_path).as_posix() for name, path in found.items()} == {
        "main.cpp": "own/main.cpp",
        "parts/one.hpp": "own/parts/one.hpp",
        "parts/one.cpp": "own/parts/one.cpp",
        "Library/All": "installed/Library/All",
        "Library/src/Deep.h": "installed/Library/src/Deep.h",
        "Library/plugins/Near.h": "installed/Library/plugins/Near.h",
    }
