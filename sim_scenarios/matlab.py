"""Tables of MATLAB files (up to version 7), read by a process of its own.

scipy's reader trusts the types that a file names: a damaged one ends the process that reads it. Here that
is not the caller's.
"""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from sim_scenarios.errors import InputError

_DEPTH: Final = 4
"""Structures inside of structures that are looked into."""
_NEWER: Final = b"MATLAB 7.3"
_CHILD: Final = f"import sys; sys.path = sys.argv[1:]; from {__name__} import _answer; _answer()"
"""What the process runs: it finds modules where its owner does, and nowhere else."""


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
        If it cannot be read.
    """
    if content.startswith(_NEWER):
        raise InputError(f"{path}: is a MATLAB file of version 7.3; save it with -v7")
    child = subprocess.run(
        [sys.executable, "-I", "-c", _CHILD, *sys.path], input=content, capture_output=True, check=False
    )
    if child.returncode:
        said = child.stderr.decode(errors="replace").strip().splitlines()
        reason = said[-1] if said else "it is damaged"
        raise InputError(f"{path}: cannot be read as a MATLAB file: {reason}")
    with np.load(BytesIO(child.stdout)) as arrays:
        names, *found = arrays.values()
    return list(zip(names.tolist(), found, strict=True))


def _answer() -> None:
    """Read the file that comes on the standard input; write names and tables to the standard output."""
    from scipy.io import loadmat

    warnings.simplefilter("ignore")  # names that stand twice
    try:
        variables = loadmat(BytesIO(sys.stdin.buffer.read()), struct_as_record=False, squeeze_me=True)
    except Exception as error:  # of damaged bytes scipy makes whatever they say
        sys.exit(f"{error}" or type(error).__name__)
    found = list(_arrays(variables, _DEPTH))
    answer = BytesIO()
    np.savez(answer, np.array([name for name, _ in found], np.str_), *(array for _, array in found))
    sys.stdout.buffer.write(answer.getbuffer())


def _arrays(variables: Mapping[str, Any], depth: int) -> Iterator[tuple[str, NDArray[np.float64]]]:
    for name, value in variables.items():
        if isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind == "f" and len(value) > 1:
            yield name, value.astype(np.float64)
        elif hasattr(value, "_fieldnames") and depth:
            yield from _arrays({field: getattr(value, field) for field in value._fieldnames}, depth - 1)
