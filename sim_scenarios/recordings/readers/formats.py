"""The formats that are read, and which of them a file has."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Final

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.recordings.readers.contents import Contents

FORMATS: Final = {
    "rtklib": "rtklib",
    "ubx": "ubx",
    "novatel": "novatel",
    "nmea": "nmea",
    "ros": "ros",
    "ulog": "ulog",
    "netcdf": "netcdf",
    "psins": "psins",
    "kf_gins": "kf_gins",
    "csv": "plain",
}
"""Readers by name, in the order in which a file is asked: those that know their own first.

A receiver of u-blox or NovAtel writes NMEA between its own messages, so both are asked before it.
"""

TEXTS: Final = (".csv", ".tsv", ".txt", ".dat")
"""Endings of files that are text with columns, if nothing else."""


def read(path: Path, name: str | None = None) -> Contents:
    """Tables of a file, in a format or in that which it is found to have.

    Raises
    ------
    InputError
        If there is no such file or format, the file is not in it, or a package is missing that its reader
        needs.
    """
    _check(path)
    contents: Contents = _reader(path, name or recognised(path)).read(path)
    return contents


def recognised(path: Path) -> str:
    """Name of the format of a file.

    Raises
    ------
    InputError
        If there is no such file, or no reader takes it.
    """
    _check(path)
    for name in FORMATS:
        if _reader(path, name).recognises(path):
            return name
    if path.name.casefold().removesuffix(".gz").endswith(TEXTS):
        return "csv"  # whose reader says what it lacks
    if path.is_dir():
        raise InputError(f"{path}: is a folder, and no ROS 2 bag, which has a metadata.yaml")
    if path.suffix == ".toml":
        raise InputError(f"{path}: is a description; `truenorth replay` takes it")
    raise InputError(f"{path}: is in none of the formats {', '.join(FORMATS)}")


def _check(path: Path) -> None:
    """Refuse what is not there, and a pipe, for whose end one would wait."""
    if not path.exists():
        raise InputError(f"there is no recording {path}")
    if not (path.is_file() or path.is_dir()):
        raise InputError(f"{path}: must be a file or a folder")


def _reader(path: Path, name: str) -> ModuleType:
    if name not in FORMATS:
        raise InputError(
            f"{path}: format = '{name}': must be one of {', '.join(FORMATS)}"
            f"{did_you_mean(name, list(FORMATS))}"
        )
    return import_module(f"sim_scenarios.recordings.readers.{FORMATS[name]}")
