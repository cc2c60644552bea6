"""The folder of a result: chosen and tested before the work begins, filled when it is done."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
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

    @contextmanager
    def folder(self, name: str) -> Iterator[Path]:
        """Where a result of this name goes; a new folder that nothing comes into is gone at the end."""
        if self.output:
            yield self.output
            return
        claimed = _claimed(DEFAULT / name)
        try:
            yield claimed
        finally:
            with suppress(OSError):  # it is not empty
                claimed.rmdir()

    def write(
        self, data: xr.Dataset, report: Callable[[xr.Dataset, Path], Path], name: str
    ) -> dict[str, str]:
        """Write report and recording; their paths."""
        from sim_scenarios import recording  # slow: xarray

        with self.folder(name) as folder, storing(folder), filled(folder, anew=True) as draft:
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


def _claimed(folder: Path) -> Path:
    """The folder, or with the first number behind its name that makes it a new one.

    It is made, and so of several commands that ask at once none gets that of another.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    candidate, number = folder, 1
    while True:
        try:
            candidate.mkdir()
        except FileExistsError:  # noqa: PERF203
            number += 1
            candidate = folder.with_name(f"{folder.name}-{number}")
        else:
            return candidate
