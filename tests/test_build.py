"""What the build needs: nothing unpinned, no tests for a run, a compiler that is new enough."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from parts import bill_of_wheel
from scikit_build_core.build import prepare_metadata_for_build_wheel

from sim_scenarios import toml

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


SOURCES = [os.fspath(path.relative_to(ROOT)) for path in sorted((ROOT / "fmu_src").rglob("*.cpp"))]
KINDS = ("euler_platform", "full_state", "invariant", "tight")
"""Models whose engines and adapters are of different kinds."""
SHORT = [f"fmu_src/filter/instances/{kind}_aids.cpp" for kind in KINDS]


@pytest.mark.parametrize(
    "source", [*SHORT, *(pytest.param(s, marks=pytest.mark.slow) for s in SOURCES if s not in SHORT)]
)
def test_the_oldest_clang_that_is_promised_understands(source: str) -> None:
    """Where a template is instantiated, it instantiates every member, whatever that requires."""
    clang = shutil.which("clang++-14")
    commands = ROOT / "build/native/compile_commands.json"
    if clang is None or not commands.exists():
        pytest.skip("there is no clang++-14, or no build to tell how a source is compiled")
    built = {one["file"]: one for one in json.loads(commands.read_text("utf-8"))}
    entry = built[os.fspath(ROOT / source)]
    where = re.findall(r"(?:-I|-D|-isystem )\S+", entry["command"])
    checked = subprocess.run(
        [
            clang,
            "-fsyntax-only",
            "-std=c++20",
            "-Wall",
            "-Wextra",
            "-Werror",
            *shlex.split(" ".join(where)),
            source,
        ],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    assert checked.returncode == 0, checked.stderr


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


def test_the_oldest_versions_that_are_tested_are_those_that_are_allowed() -> None:
    project = toml.read(ROOT / "pyproject.toml")["project"]
    extras = project["optional-dependencies"]
    allowed = [*project["dependencies"], *extras["recordings"], *extras["sign"]]
    oldest = [one.partition(";")[0].replace(">=", "==") for one in allowed if "< '3.11'" not in one]
    lines = (ROOT / "requirements.lowest").read_text("utf-8").splitlines()
    assert [line for line in lines if not line.startswith("#")] == oldest


def test_the_metadata_of_the_wheel_has_the_licences_of_all_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    folder = tmp_path / prepare_metadata_for_build_wheel(str(tmp_path), {"wheel.cmake": "false"})
    (expression,) = re.findall(r"^License-Expression: (.*)", (folder / "METADATA").read_text("utf-8"), re.M)
    parts = {
        "BSD-3-Clause",
        "BSD-2-Clause",
        "MPL-2.0",
        "Apache-2.0",
        "GPL-3.0-or-later WITH GCC-exception-3.1",
    }
    assert set(expression.split(" AND ")) == parts
    texts = {path.name for path in (folder / "licenses").rglob("*.txt")}
    assert texts == {path.name for path in (ROOT / "modelDescription/documentation/licenses").iterdir()}


def test_the_bill_of_materials_of_the_wheel_asks_for_what_its_metadata_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    folder = tmp_path / prepare_metadata_for_build_wheel(str(tmp_path), {"wheel.cmake": "false"})
    metadata = (folder / "METADATA").read_text("utf-8")
    bill = json.loads(bill_of_wheel(ROOT / "pyproject.toml", {}, {}))
    named = {part["name"] for part in bill["components"]}
    lines = re.findall(r"^Requires-Dist: (.*)", metadata, re.M)
    assert named == {re.split(r"[^\w.-]", line)[0] for line in lines if 'extra == "dev"' not in line}
    assert f"Version: {bill['metadata']['component']['version']}\n" in metadata
