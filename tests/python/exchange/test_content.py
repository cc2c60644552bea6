"""Whether what an export holds is what was written: no change passes, and none is a traceback."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim_scenarios.archives import archive_bytes, read_archive
from sim_scenarios.exchange import checksums, evidence
from sim_scenarios.exchange.verification import content_of_fmu

MEMBERS = {"modelDescription.xml": b"<fmiModelDescription/>\n", "resources/a.txt": b"seed 7\n" * 4}


def fmu_bytes() -> bytes:
    """A small archive with its list of checksums."""
    return archive_bytes(checksums.with_list(MEMBERS, evidence.FOLDER))


@pytest.fixture
def fmu(tmp_path: Path) -> Path:
    path = tmp_path / "small.fmu"
    path.write_bytes(fmu_bytes())
    return path


def test_each_flipped_bit_of_an_fmu_is_found(fmu: Path) -> None:
    """But for those that fill up the last byte of compressed data, which mean nothing."""
    whole, members = fmu.read_bytes(), read_archive(fmu)
    assert content_of_fmu(fmu) == []
    passed = 0
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        fmu.write_bytes(changed)
        if not content_of_fmu(fmu):
            assert read_archive(fmu) == members, bit
            passed += 1
    assert passed <= 7 * len(members)


def test_an_fmu_that_is_cut_short_is_found(fmu: Path) -> None:
    whole = fmu.read_bytes()
    for length in range(len(whole)):
        fmu.write_bytes(whole[:length])
        assert content_of_fmu(fmu), length
