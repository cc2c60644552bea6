"""Files cut short and with bits turned over, as disks and lines leave them.

TRUENORTH_DAMAGED_FILES says how many of each kind.
"""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from sim_scenarios.errors import InputError

CASES = int(os.environ.get("TRUENORTH_DAMAGED_FILES", "200"))


def refusals(read: Callable[[Path], object], path: Path, cases: int = CASES) -> list[str]:
    """Read damaged copies of a file: each is read, or refused in a sentence that names it, within a second
    and without a warning.

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
    read(path)  # whatever is imported first
    for case in range(cases):
        content = bytearray(whole)
        if case % 2:
            del content[random.integers(len(whole)) :]
        else:
            for place in random.integers(len(whole), size=random.integers(1, 5)):
                content[place] ^= 1 << random.integers(8)
        copy.write_bytes(content)
        start = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)  # of arithmetic with what is no number
                read(copy)
        except InputError as error:
            said.append(str(error))
        assert time.process_time() - start < 1.0, case
    assert all(str(copy) in sentence for sentence in said)
    return said
