"""FMUs of several platforms become one."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from package import join

from sim_scenarios.archives import write_archive


def platform(folder: Path, name: str, description: str) -> Path:
    archive = folder / f"{name}.fmu"
    write_archive(archive, {"modelDescription.xml": description, f"binaries/{name}/x": name})
    return archive


def test_the_binaries_of_all(tmp_path: Path) -> None:
    join(tmp_path / "all.fmu", [platform(tmp_path, name, "same") for name in ("linux64", "win64")])
    with zipfile.ZipFile(tmp_path / "all.fmu") as content:
        members = {name: content.read(name) for name in content.namelist()}
    assert members == {
        "modelDescription.xml": b"same",
        "binaries/linux64/x": b"linux64",
        "binaries/win64/x": b"win64",
    }


def test_another_build_is_refused(tmp_path: Path) -> None:
    fmus = [platform(tmp_path, "linux64", "same"), platform(tmp_path, "win64", "other")]
    with pytest.raises(SystemExit, match=r"win64\.fmu: modelDescription\.xml is not as in the others"):
        join(tmp_path / "all.fmu", fmus)
    assert not (tmp_path / "all.fmu").exists()
