"""The folder of recordings that do not come with the package."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

RECORDINGS: Final = "TRUENORTH_RECORDINGS"
"""Environment variable that names it."""


def recording_named(name: str) -> Path | None:
    """A recording that does not come with the package, if its folder is named and holds it."""
    folder = os.environ.get(RECORDINGS)
    path = Path(folder or "", name)
    return path if folder and path.is_file() else None
