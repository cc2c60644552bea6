"""What the build needs: nothing unpinned, no tests for a run, a compiler that is new enough."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def output_of(*command: str) -> str:
    """Everything that a command says, whatever its exit code."""
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    return done.stdout + done.stderr


def test_what_cmake_downloads_is_pinned_by_its_hash() -> None:
    files = [ROOT / "CMakeLists.txt", *(ROOT / "fmu_src").rglob("CMakeLists.txt")]
    files += [*(ROOT / "tests").rglob("CMakeLists.txt"), *(ROOT / "cmake").glob("*.cmake")]
    downloads = [
        call
        for path in files
        for call in re.findall(r"FetchContent_Declare\([^)]*\)", path.read_text("utf-8"))
    ]
    assert downloads
    for call in downloads:
        assert re.search(r"URL_HASH SHA256=[0-9a-f]{64}\b", call), call


def test_a_run_configures_and_builds_no_tests() -> None:
    presets = json.loads((ROOT / "CMakePresets.json").read_text("utf-8"))["configurePresets"]
    native = next(preset for preset in presets if preset["name"] == "native")
    assert "TRUENORTH_TESTS" not in native["cacheVariables"]
    commands = output_of("make", "--dry-run", "--assume-old=.venv/.ready", "run")
    assert "cmake --preset native" in commands
    assert "TRUENORTH_TESTS" not in commands
    assert re.search(r"--target TruthPlant_fmu AlignmentFilter_fmu ", commands)


@pytest.mark.parametrize(
    ("compiler", "version", "good"),
    [
        ("GNU", "11.4.0", False),
        ("GNU", "12.1.0", True),
        ("Clang", "13.0.1", False),
        ("Clang", "14.0.0", True),
    ],
)
def test_an_old_compiler_is_refused_with_a_sentence(
    tmp_path: Path, compiler: str, version: str, good: bool
) -> None:
    pretended = {
        "COMPILER_ID_RUN": "1", "COMPILER_FORCED": "1", "COMPILER_ID": compiler, "COMPILER_VERSION": version,
    }  # fmt: skip
    cmake = Path(sys.executable).with_name("cmake")
    said = output_of(
        os.fspath(cmake), "-S", os.fspath(ROOT), "-B", os.fspath(tmp_path), "-G", "Ninja",
        f"-DCMAKE_MAKE_PROGRAM={cmake.with_name('ninja')}", f"-DPython_EXECUTABLE={sys.executable}",
        *(f"-DCMAKE_CXX_{name}={value}" for name, value in pretended.items()),
    )  # fmt: skip
    refusal = f"is {compiler} {version}"
    assert (refusal in " ".join(said.split())) is not good, said


def test_the_version_is_the_same_everywhere() -> None:
    found = {
        name: re.search(pattern, (ROOT / name).read_text("utf-8"), re.MULTILINE)
        for name, pattern in {
            "CMakeLists.txt": r"project\(TrueNorth VERSION ([\d.]+)",
            "pyproject.toml": r'^version = "([\d.]+)"',
            "CHANGELOG.md": r"^## ([\d.]+)",
        }.items()
    }
    assert len({match.group(1) if match else None for match in found.values()}) == 1, found
