"""`truenorth import`: what its reader has mended is never lost."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.recordings import drafting


def test_a_description_survives_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    description = tmp_path / "recording.toml"
    description.write_text("mended by hand", encoding="utf-8")

    def full(path: Path, text: str, **_: object) -> int:
        path.write_bytes(text[:3].encode())
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(drafting, "draft", lambda *_: ("drafted anew", []))
    monkeypatch.setattr(Path, "write_text", full)
    result = CliRunner().invoke(app, ["import", "imu.csv", "--force", "-o", str(description)])
    assert result.exit_code == 2
    assert "No space left" in result.stderr
    assert description.read_text(encoding="utf-8") == "mended by hand"
    assert list(tmp_path.iterdir()) == [description]
