"""Packages that are not installed."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import ros, ubx, ulog


@pytest.mark.parametrize(
    ("reader", "module", "package"),
    [
        (ubx, "pyubx2", "pyubx2"),
        (ros, "rosbags.highlevel", "rosbags"),
        (ulog, "pyulog", "pyulog"),
    ],
)
def test_a_reader_says_which_package_it_needs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, reader: ModuleType, module: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    path = tmp_path / "recording"
    path.write_bytes(b"")
    assert reader.recognises(path) is False
    with pytest.raises(
        InputError, match=rf"needs the package {package}: pip install truenorth\[recordings\]"
    ):
        reader.read(path)
