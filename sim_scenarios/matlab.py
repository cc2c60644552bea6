"""Tables of MATLAB files (up to version 7), read by a process of its own.

scipy's reader trusts the types that a file names: a damaged one ends the process that reads it. Here that
is not the caller's.
"""

from __future__ import annotations

import subprocess
import sys
from io import BytesIO
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError

_NEWER: Final = b"MATLAB 7.3"
_CHILD: Final = Path(__file__).with_name("matlab_child.py")


def tables(path: Path, content: bytes) -> list[tuple[str, NDArray[np.float64]]]:
    """Tables of numbers among the variables of a file and the fields of its structures, with their names.

    Parameters
    ----------
    path : Path
        The file, for what is said of it.
    content : bytes
        What is in it.

    Raises
    ------
    InputError
        If it cannot be read, or no Python can be started to read it.
    """
    if content.startswith(_NEWER):
        raise InputError(f"{path}: is a MATLAB file of version 7.3; save it with -v7")
    if not sys.executable:
        raise InputError(f"{path}: is read by a Python of its own, and sys.executable names none")
    command = [sys.executable, "-I", str(_CHILD), *map(str, sys.path)]
    try:
        child = subprocess.run(command, input=content, capture_output=True, check=False)
    except OSError as error:
        raise InputError(f"{path}: is read by a Python of its own that cannot start: {error}") from None
    if child.returncode or not child.stdout:
        said = child.stderr.decode(errors="replace").strip().splitlines()
        reason = said[-1] if said else "it is damaged"
        raise InputError(f"{path}: cannot be read as a MATLAB file: {reason}")
    with np.load(BytesIO(child.stdout)) as arrays:
        names, *found = arrays.values()
    return list(zip(names.tolist(), found, strict=True))
