"""The version of the package, as it is installed, and as its files are."""

import hashlib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

PACKAGE: Final = "sim_scenarios"


def product_version() -> str | None:
    """Version; None of a checkout that is not installed."""
    try:
        return version("truenorth")
    except PackageNotFoundError:
        return None


def sources() -> str:
    """Hash of the Python sources of the package: of how a run is made, and of what a figure is."""
    folder, digest = Path(__file__).parent, hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(f"{path.relative_to(folder).as_posix()}\n".encode() + path.read_bytes())
    return f"sha256:{digest.hexdigest()}"
