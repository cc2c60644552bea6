"""KF-GINS text, by its README."""

from __future__ import annotations

from pathlib import Path

from sim_scenarios.recordings.tables import Array


def written(path: Path, table: Array) -> Path:
    """A file of rows of numbers, with all their digits."""
    path.write_text("\n".join(" ".join(repr(float(x)) for x in row) for row in table) + " \n")
    return path
