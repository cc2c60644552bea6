"""TOML files of people: scenarios, campaigns, papers; and values as they stand in them."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from sim_scenarios.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

DEEPEST: Final = 10
"""Tables and lists within each other; nothing that is read has more than four."""

LARGEST: Final = 500_000
"""Bytes of a file."""

_PART: Final = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')"""
_DEEP_KEY: Final = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*\.[ \t]*{_PART}){{{DEEPEST},}}", re.ASCII)
"""A dotted key with too many parts. The parser keeps all beginnings of it: 200 kB of key fill a memory."""


def read(path: Path) -> dict[str, Any]:
    """Content of a file; a byte order mark, as some editors write it, is passed over."""
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise InputError(f"{path}: must be a file")  # no pipe, for whose end one would wait
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(content) > LARGEST:
        raise InputError(f"{path}: must have at most {LARGEST} bytes")
    try:
        text = content.decode("utf-8-sig")
        if _DEEP_KEY.search(text):
            raise RecursionError
        table: dict[str, Any] = tomllib.loads(text)
    except RecursionError:
        raise InputError(_too_deep(path)) from None
    except ValueError as error:  # of TOML, of UTF-8, of numbers with thousands of digits
        raise InputError(f"{path}: not valid TOML: {error}") from None
    if _depth(table) > DEEPEST:
        raise InputError(_too_deep(path))
    return table


def value(text: str) -> object:
    """A value as it stands in a file; a bare text needs no quotes."""
    try:
        read_value: object = tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text.strip()
    return text.strip() if _depth(read_value) > DEEPEST else read_value


def comment(text: str) -> str:
    """A line of a file that says a text, whatever the text is."""
    return "# " + "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def written(content: object) -> str:
    """A value as it is written into a file: text, numbers, truth, lists, and tables with plain names."""
    if isinstance(content, Mapping):
        return f"{{ {', '.join(f'{key} = {written(inner)}' for key, inner in content.items())} }}"
    return json.dumps(content, ensure_ascii=False).replace("\x7f", "\\u007f")  # which JSON may leave as it is


def dotted(table: object, prefix: str = "") -> Iterator[tuple[str, object]]:
    """Entries of nested tables under their dotted names."""
    if not isinstance(table, Mapping):
        raise InputError(f"'{table}' is not a table")
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from dotted(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def exists(path: Path) -> bool:
    """Whether there is a file; a path that no system takes (too long, with NUL) is that of none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _depth(content: object) -> int:
    """How many tables and lists lie within each other, counted without recursion."""
    deepest, waiting = 0, [(content, 1)]
    while waiting:
        within, depth = waiting.pop()
        inner = within.values() if isinstance(within, dict) else within if isinstance(within, list) else None
        if inner is not None:
            deepest = max(deepest, depth)
            waiting += [(one, depth + 1) for one in inner]
    return deepest


def _too_deep(path: Path) -> str:
    return f"{path}: must not have more than {DEEPEST} tables and lists within each other"
