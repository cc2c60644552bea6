"""Names that become files: one rule for those that are given, one way for what is derived of labels.

A name may be a file or a folder on any system, a member of an archive, a word on a command line: it has
letters and digits of ASCII, dots, underscores and hyphens, and begins with neither a dot nor a hyphen. A
label is for people and may be any text of one line; `file_names` makes file names of labels.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import count
from typing import Annotated, Final

from pydantic import AfterValidator

from sim_scenarios.errors import InputError

LONGEST: Final = 100
"""Characters of a name or a label."""

_NAME: Final = re.compile(rf"[A-Za-z0-9_][A-Za-z0-9._-]{{0,{LONGEST - 1}}}")
_CONTROL: Final = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""What moves the cursor, breaks a line, turns the direction of writing, or is no character by itself."""


def checked_name(name: str) -> str:
    """A name, if it is one."""
    if _NAME.fullmatch(name):
        return name
    raise InputError(
        f"{_quoted(name)} must have letters (A to Z), digits, '.', '_' and '-' alone, at most {LONGEST}, and "
        "not begin with '.' or '-'"
    )


def checked_label(label: str) -> str:
    """A label, if it is one."""
    if not label.strip():
        raise InputError("a label must not be empty")
    if len(label) > LONGEST or _CONTROL.search(label):
        raise InputError(
            f"the label {_quoted(label)} must have at most {LONGEST} characters, and no control character"
        )
    return label


def checked_text(text: str) -> str:
    """A text of several lines, if it holds nothing but characters."""
    if found := _CONTROL.search(text.replace("\n", "").replace("\t", "")):
        raise InputError(f"has the control character {found[0]!a}")
    return text


Name = Annotated[str, AfterValidator(checked_name)]
Label = Annotated[str, AfterValidator(checked_label)]
Text = Annotated[str, AfterValidator(checked_text)]


def printable(text: str) -> str:
    """A text whose control characters, line feeds excepted, are written out: no terminal obeys them."""
    return _CONTROL.sub(lambda found: found[0] if found[0] in "\n\t" else ascii(found[0])[1:-1], text)


def file_name(label: str) -> str:
    """Name of a file for a label; two labels may have the same one."""
    word = re.sub(r"[^A-Za-z0-9._=-]+", "_", label)[:LONGEST].lstrip(".-")
    return word or "_"


def file_names(labels: Iterable[str]) -> dict[str, str]:
    """A file name for each label, no two alike, not even where case does not count."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for label in labels:
        word = file_name(label)
        numbered = (word if number == 1 else f"{word[: LONGEST - 7]}-{number}" for number in count(1))
        names[label] = next(name for name in numbered if name.casefold() not in taken)
        taken.add(names[label].casefold())
    return names


def _quoted(text: str) -> str:
    """The beginning of a text, harmless."""
    return ascii(text if len(text) <= LONGEST else f"{text[: LONGEST // 2]}...")
