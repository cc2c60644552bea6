"""A tool that loads and unloads an FMU for every run loses no memory."""

from __future__ import annotations

import _ctypes
import ctypes
import sys
from pathlib import Path

import pytest
from archives import FMUS

from sim_scenarios.fmus import Fmu

TIMES = 200
PER_TIME = 8_000
"""What the system may keep of each [bytes]; with the pool for exceptions of libstdc++ it is 73 kB."""


def resident() -> int:
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * 4096


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of Linux are /proc and dlclose")
@pytest.mark.parametrize("name", ["TruthPlant", "AlignmentFilter", "NavigationFilter", "Playback"])
def test_memory_is_given_back(name: str) -> None:
    fmu = Fmu(FMUS / f"{name}.fmu")
    library = str(fmu.library)

    def load() -> None:
        _ctypes.dlclose(ctypes.CDLL(library)._handle)

    for _ in range(20):
        load()
    before = resident()
    for _ in range(TIMES):
        load()
    assert resident() - before < TIMES * PER_TIME
