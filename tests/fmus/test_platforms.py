"""The FMUs of `make fmus-all`: a binary for each platform, all with the same results.

Binaries of other platforms run under qemu and wine where those are installed.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import c_program
import numpy as np
import pytest
from archives import ROOT
from numpy.typing import NDArray

from sim_scenarios.exchange.forms import FMI2
from sim_scenarios.exchange.reference import simulate
from sim_scenarios.exchange.system import System, of_scenario
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.scenario import load_scenario

FMUS = ROOT / "build" / "fmus-all"
ARCHIVES = sorted(FMUS.glob("**/*.fmu"))
STEP = 0.5
ATOM = 1e-6
"""Largest value up to which an output counts as zero but for rounding, in SI units."""
FLOOR = (2, 17)
"""glibc of CentOS 7, as old as manylinux2014."""

pytestmark = pytest.mark.skipif(not ARCHIVES, reason="no FMUs of `make fmus-all`")


@dataclass(frozen=True)
class Platform:
    """Names in FMI 2 and 3, file of the binary, the compiler's name, and what runs it here."""

    folders: tuple[str, str]
    suffix: str
    target: str
    emulator: Sequence[str] = ()
    libraries: Sequence[str] = ("-ldl",)


LINUX = Platform(("linux64", "x86_64-linux"), ".so", "x86_64-linux-gnu.2.17")
AARCH64 = Platform(
    ("aarch64-linux", "aarch64-linux"), ".so", "aarch64-linux-gnu.2.17",
    ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
)  # fmt: skip
WINDOWS = Platform(("win64", "x86_64-windows"), ".dll", "x86_64-windows-gnu", ("wine",), ())
PLATFORMS = [LINUX, AARCH64, WINDOWS]
MACOS = {
    "x86_64": Platform(("darwin64", "x86_64-darwin"), ".dylib", "x86_64-macos.11.0"),
    "arm64": Platform(("darwin64", "aarch64-darwin"), ".dylib", "aarch64-macos.11.0"),
}


def version(archive: Path) -> int:
    return 3 if archive.parent.name == "fmi3" else 2


def binary(archive: Path, platform: Platform, folder: Path) -> Path:
    """The binary of one platform, unpacked."""
    member = f"binaries/{platform.folders[version(archive) - 2]}/{archive.stem}{platform.suffix}"
    with zipfile.ZipFile(archive) as content:
        return Path(content.extract(member, folder))


def functions_of_the_standard(archive: Path) -> set[str]:
    header = (c_program.HEADERS / f"fmi{version(archive)}Functions.h").read_text()
    return set(re.findall(r"FMI\d_Export fmi\d\w+TYPE\s+(fmi\d\w+);", header))


def output_of(*command: str | Path) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.parametrize("archive", ARCHIVES, ids=lambda path: f"{path.stem}-{version(path)}")
@pytest.mark.parametrize("platform", [LINUX, AARCH64], ids=lambda platform: platform.target)
def test_linux_binaries_need_an_old_glibc_alone(archive: Path, platform: Platform, tmp_path: Path) -> None:
    library = binary(archive, platform, tmp_path)
    versions = re.findall(r"@GLIBC_(\d+)\.(\d+)", output_of("readelf", "-W", "--dyn-syms", library))
    assert versions
    assert max((int(major), int(minor)) for major, minor in versions) <= FLOOR
    needed = re.findall(r"\(NEEDED\).*\[(.*?)\]", output_of("readelf", "-W", "-d", library))
    assert "libc.so.6" in needed
    assert not [name for name in needed if name.startswith(("libstdc++", "libc++", "libgcc"))]


@pytest.mark.parametrize("archive", ARCHIVES, ids=lambda path: f"{path.stem}-{version(path)}")
@pytest.mark.parametrize("platform", PLATFORMS, ids=lambda platform: platform.target)
def test_exports_the_functions_of_the_standard_and_nothing_else(
    archive: Path, platform: Platform, tmp_path: Path
) -> None:
    if shutil.which("llvm-nm") is None:
        pytest.skip("llvm-nm, which reads the binaries of all platforms, is not installed")
    library = binary(archive, platform, tmp_path)
    if platform is WINDOWS:
        exported = set(re.findall(r"Name: (\w+)", output_of("llvm-readobj", "--coff-exports", library)))
    else:
        symbols = output_of("llvm-nm", "-D", "--extern-only", "--defined-only", "--just-symbol-name", library)
        exported = set(symbols.split())
    assert exported == functions_of_the_standard(archive)


@pytest.mark.parametrize("archive", ARCHIVES, ids=lambda path: f"{path.stem}-{version(path)}")
@pytest.mark.parametrize("processor", MACOS)
def test_macos_binaries_need_the_system_library_alone(archive: Path, processor: str, tmp_path: Path) -> None:
    """Read, not run. Zig's linker cannot hide the allocation functions of C++; they are weak."""
    if shutil.which("llvm-objdump") is None:
        pytest.skip("llvm-objdump, which reads binaries of macOS, is not installed")
    try:
        library = binary(archive, MACOS[processor], tmp_path)
    except KeyError:
        pytest.skip("built without macOS, which is no platform of `make fmus-all` unless asked for")
    reader = ("llvm-objdump", "--macho", f"--arch={processor}")
    header = output_of(*reader, "--private-headers", library)
    assert re.search(r"platform macos\s+sdk \S+\s+minos 11\.0", header)
    assert re.search(rf"LC_ID_DYLIB\s+cmdsize \d+\s+name @rpath/{library.name} ", header)
    assert processor == "x86_64" or "LC_CODE_SIGNATURE" in header
    used = re.findall(r"^\t(\S+) \(compat", output_of(*reader, "--dylibs-used", library), re.MULTILINE)
    assert used == [f"@rpath/{library.name}", "/usr/lib/libSystem.B.dylib"]
    trie = output_of(*reader, "--exports-trie", library)
    exported = dict(re.findall(r"^0x\w+\s+_(\w+)(.*)$", trie, re.MULTILINE))
    assert {name for name in exported if name.startswith("fmi")} == functions_of_the_standard(archive)
    for name, kind in exported.items():
        assert name.startswith(("fmi", "_mh_", "__dso_handle")) or (
            re.match(r"_Z(n|d)[wla]", name) and "weak_def" in kind
        ), name


# ------------------------------------------------------------------ the same results


@pytest.fixture(scope="module")
def fmus() -> Fmus:
    return Fmus({path.stem: Fmu(path) for path in ARCHIVES if version(path) == 2})


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder for the program that runs a system, one for each platform."""
    return tmp_path_factory.mktemp("programs")


def outputs_of(platform: Platform, system: System, programs: Path, folder: Path) -> NDArray[np.float64]:
    """Outputs of all components, a column each, after every step, from the binaries of a platform."""
    program = programs / f"{platform.target}.exe"
    if not program.exists():
        pytest.importorskip("ziglang")
        zig = [sys.executable, "-m", "ziglang", "cc", "-target", platform.target]
        c_program.compiled(zig, FMI2, program, platform.libraries)
    libraries = [binary(component.fmu.path, platform, folder) for component in system.components]
    arguments = [
        argument
        for component, library in zip(system.components, libraries, strict=True)
        for argument in (f"./{library.name}", component.fmu.guid, component.fmu.name, "none")
    ]
    references = {
        component.name: {name: v.reference for name, v in component.fmu.variables.items()}
        for component in system.components
    }
    given = c_program.orders(system, FMI2, references, with_parameters=True)
    return c_program.outputs([*platform.emulator, program, *arguments], given, libraries[0].parent)


@pytest.mark.parametrize("scenario", ["swaying_ship", "flight_loose_tight", "align_then_navigate"])
@pytest.mark.parametrize("platform", [LINUX, AARCH64, WINDOWS], ids=lambda platform: platform.target)
def test_a_system_gives_the_results_of_linux(
    platform: Platform, scenario: str, fmus: Fmus, programs: Path, tmp_path: Path
) -> None:
    """To 1e-9 of the largest value of each output of the plant, 1e-6 of the filters, which the plant feeds.

    Outputs that are zero but for rounding are compared as if their largest value were ATOM.
    """
    if platform.emulator and shutil.which(platform.emulator[0]) is None:
        pytest.skip(f"{platform.emulator[0]} is not installed")
    loaded = load_scenario(scenario, fmus, settings={"communication_step": STEP})
    system = of_scenario(loaded, fmus)
    expected = simulate(system)
    columns = iter(outputs_of(platform, system, programs, tmp_path).T)
    for component in system.components:
        tolerance = 1e-9 if component is system.plant else 1e-6
        outputs = expected[component.name].outputs
        every = round(outputs["time"][1] / STEP)
        for name in component.outputs:
            reference = outputs[name].astype(float)
            limit = tolerance * max(np.abs(reference).max(), ATOM)
            np.testing.assert_allclose(next(columns)[::every], reference, rtol=0, atol=limit, err_msg=name)
