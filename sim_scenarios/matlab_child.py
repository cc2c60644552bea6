"""What reads a MATLAB file, as a program of its own: the file comes on the standard input.

The arguments are where its owner finds modules. On the standard output are its tables, as an archive of
numpy: their names, then the tables.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Mapping
from io import BytesIO
from typing import Any, Final

_DEPTH: Final = 4
"""Structures inside of structures that are looked into."""


def main() -> None:
    """Read and answer; what is wrong with the file is the last line on the standard error."""
    sys.path = sys.argv[1:]
    import numpy as np
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


def _arrays(variables: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    """Tables of numbers among variables and the fields of structures, with their names."""
    for name, value in variables.items():
        if getattr(value, "ndim", 0) == 2 and value.dtype.kind == "f" and len(value) > 1:
            yield name, value.astype(float)
        elif hasattr(value, "_fieldnames") and depth:
            yield from _arrays({field: getattr(value, field) for field in value._fieldnames}, depth - 1)


if __name__ == "__main__":
    main()
