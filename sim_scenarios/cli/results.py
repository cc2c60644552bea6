"""The folder of a result: chosen and tested before the work begins, filled when it is done."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Final

from sim_scenarios.errors import InputError
from sim_scenarios.folders import filled

if TYPE_CHECKING:
    import xarray as xr

DEFAULT: Final = Path("truenorth-results")


@dataclass(frozen=True)
class Results:
    """Where the results of a command go.

    A folder that the user names is used as it is, and what it holds is replaced; without one, each result
    gets a new folder below `truenorth-results`.

    Attributes
    ----------
    output : Path or None
        What the user named.
    """

    output: Path | None

    def __post_init__(self) -> None:
        """Refuse a folder that cannot be written, before any work is done."""
        folder = self.output or DEFAULT
        existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        if not existing.is_dir():
            raise InputError(f"--output {folder}: {existing} is not a folder")
        if not os.access(existing, os.W_OK | os.X_OK):
            raise InputError(f"--output {folder}: {existing} cannot be written")

    def folder(self, name: str) -> Path:
        """Where a result of this name goes."""
        return self.output or _unused(DEFAULT / name)

    def write(
        self, data: xr.Dataset, report: Callable[[xr.Dataset, Path], Path], name: str
    ) -> dict[str, str]:
        """Write report and recording; their paths."""
        from sim_scenarios import recording  # slow: xarray

        folder = self.folder(name)
        with storing(folder), filled(folder) as draft:
            page = report(data, draft)
            recording.save(data, draft / "recording.nc")
        return {"report": str(folder / page.name), "recording": str(folder / "recording.nc")}


@contextmanager
def storing(folder: Path, kept: str = "") -> Iterator[None]:
    """Say in a sentence what keeps results from being stored, and what is kept nevertheless."""
    try:
        yield
    except OSError as error:
        raise InputError(f"--output {folder}: {error.strerror or error}{kept}") from None


def _unused(folder: Path) -> Path:
    """The folder, or with the first number behind its name that makes it a new one."""
    if not folder.exists():
        return folder
    numbered = (folder.with_name(f"{folder.name}-{number}") for number in count(2))
    return next(candidate for candidate in numbered if not candidate.exists())
