"""Bytes of files, compressed or not."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import files

CONTENT = bytes(range(256)) * 100


@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_whole_and_beginning(tmp_path: Path, pack: type[bytes]) -> None:
    path = tmp_path / "file"
    path.write_bytes(pack(CONTENT))
    assert files.whole(path) == CONTENT
    assert files.beginning(path) == CONTENT[: files.BEGINNING]


def test_damaged_compression(tmp_path: Path) -> None:
    path = tmp_path / "file.gz"
    path.write_bytes(gzip.compress(CONTENT)[:-20])
    with pytest.raises(InputError, match=r"file\.gz: cannot be read: "):
        files.whole(path)
    path.write_bytes(b"\x1f\x8bnothing")
    assert files.beginning(path) == b""


def test_what_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        files.whole(tmp_path)
    with pytest.raises(InputError, match="there is no recording"):
        files.whole(tmp_path / "none")
    assert files.beginning(tmp_path) == b""
    assert files.beginning(tmp_path / "none") == b""
