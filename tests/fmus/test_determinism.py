"""The same sources give the same FMU: the same guid, the same bytes."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from archives import ROOT
from calls import Fmu

from sim_scenarios.archives import write_archive

ADDED = {
    "modelDescription/{name}.toml": """
[[variable]]
name = "one_more"
causality = "parameter"
type = "Boolean"
start = true
description = "One more"
"""
}


def describe(name: str, folder: Path, root: Path = ROOT) -> str:
    """Generate the description once more; the guid."""
    generator = root / "modelDescription" / "generate.py"
    declaration = root / "modelDescription" / f"{name}.toml"
    subprocess.run(
        [sys.executable, "-B", generator, "description", declaration, folder, "--version", "0"], check=True
    )
    text = (folder / name / "fmi2" / "modelDescription.xml").read_text()
    found = re.search(r'guid="({[0-9a-f-]{36}})"', text)
    assert found
    return found[1]


@pytest.fixture(scope="session")
def guid(fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Of the sources as they are."""
    return describe(fmu.name, tmp_path_factory.mktemp("described"))


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The sources, in another place."""
    for part in ("modelDescription", "fmu_src"):
        shutil.copytree(ROOT / part, tmp_path / "copy" / part)
    shutil.copy(ROOT / "LICENSE", tmp_path / "copy")
    return tmp_path / "copy"


def test_packing_again_gives_the_same_bytes(fmu: Fmu, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmu.archive) as content:
        members = {name: fmu.folder / name for name in content.namelist()}
    again = tmp_path / fmu.archive.name
    write_archive(again, dict(reversed(members.items())))
    assert again.read_bytes() == fmu.archive.read_bytes()


def test_the_guid_depends_on_the_content_alone(fmu: Fmu, guid: str, tmp_path: Path, copy: Path) -> None:
    assert describe(fmu.name, tmp_path, copy) == guid


@pytest.mark.parametrize("changed", ["fmu_src/fmi/instance.cpp", "modelDescription/{name}.toml", "LICENSE"])
def test_the_guid_changes_with_the_content(
    fmu: Fmu, guid: str, tmp_path: Path, copy: Path, changed: str
) -> None:
    with (copy / changed.format(name=fmu.name)).open("a") as file:
        file.write(ADDED.get(changed, "\n"))
    assert describe(fmu.name, tmp_path, copy) != guid


def test_the_library_carries_the_guid_of_the_description(fmu: Fmu) -> None:
    assert fmu.guid.encode() in Path(fmu.library._name).read_bytes()


@pytest.mark.slow
def test_building_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    """From scratch, in two folders; takes minutes."""
    archives = []
    for name in ("one", "two"):
        build, fmus = tmp_path / name, tmp_path / f"{name}_fmus"
        subprocess.run(
            ["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
             f"-DPython_EXECUTABLE={sys.executable}", f"-DTRUENORTH_FMU_DIRECTORY={fmus}"],
            check=True, capture_output=True,
        )  # fmt: skip
        subprocess.run(["cmake", "--build", build, "--parallel", "2", "--target", "fmus"], check=True)
        archives.append({path.relative_to(fmus): path.read_bytes() for path in fmus.rglob("*.fmu")})
    assert {Path("TruthPlant.fmu"), Path("fmi3/TruthPlant.fmu")} <= archives[0].keys()
    assert archives[0] == archives[1]
