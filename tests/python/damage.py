"""Files cut short and with bytes turned over, as disks and lines leave them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers.contents import Contents

CASES = 200


def refusals(read: Callable[[Path], Contents], path: Path, cases: int = CASES) -> list[str]:
    """Read damaged copies of a file; every one must be read or refused in a sentence that names it.

    Half of them are cut short, in half of them one to four bits are turned over.

    Returns
    -------
    list of str
        The sentences.
    """
    whole = path.read_bytes()
    random = np.random.default_rng(1709)
    copy = path.with_name(f"damaged_{path.name}")
    said = []
    for case in range(cases):
        content = bytearray(whole)
        if case % 2:
            del content[random.integers(len(whole)) :]
        else:
            for place in random.integers(len(whole), size=random.integers(1, 5)):
                content[place] ^= 1 << random.integers(8)
        copy.write_bytes(content)
        try:
            assert isinstance(read(copy), Contents)
        except InputError as error:
            said.append(str(error))
    assert all(str(copy) in sentence for sentence in said)
    return said
