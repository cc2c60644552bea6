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

import fmpy
import numpy as np
import pytest
from archives import ROOT
from numpy.typing import NDArray

from sim_scenarios.exchange.reference import Columns, Results, simulate
from sim_scenarios.exchange.system import Component, System, of_scenario
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.scenario import load_scenario

FMUS = ROOT / "build" / "fmus-all"
ARCHIVES = sorted(FMUS.glob("**/*.fmu"))
HEADERS = Path(fmpy.__file__).parent / "c-code"
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


def version(archive: Path) -> int:
    return 3 if archive.parent.name == "fmi3" else 2


def binary(archive: Path, platform: Platform, folder: Path) -> Path:
    """The binary of one platform, unpacked."""
    member = f"binaries/{platform.folders[version(archive) - 2]}/{archive.stem}{platform.suffix}"
    with zipfile.ZipFile(archive) as content:
        return Path(content.extract(member, folder))


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
    header = (HEADERS / f"fmi{version(archive)}Functions.h").read_text()
    assert exported == set(re.findall(r"FMI\d_Export fmi\d\w+TYPE\s+(fmi\d\w+);", header))


# ------------------------------------------------------------------ the same results

KINDS = {"Real": "R", "Integer": "I", "Enumeration": "I", "Boolean": "B"}


@pytest.fixture(scope="module")
def fmus() -> Fmus:
    return Fmus({path.stem: Fmu(path) for path in ARCHIVES if version(path) == 2})


def words(component: Component, names: Sequence[str]) -> str:
    variables = component.variables(list(names))
    return " ".join([str(len(names)), *(f"{KINDS[v.kind]} {v.reference}" for v in variables)])


def rows(columns: Columns, names: Sequence[str]) -> str:
    table = zip(*(columns[name].tolist() for name in names), strict=True)
    return "\n".join(" ".join(float(value).hex() for value in row) for row in table)


def orders(system: System, component: Component, results: Results) -> str:
    """What `replay.c` reads."""
    variables = component.fmu.variables
    parameters = [
        f"{KINDS[variables[name].kind]} {variables[name].reference} {float(value).hex()}"
        for name, value in component.values.items()
    ]
    return "\n".join(
        [
            f"{system.step.hex()} {round(system.stop / system.step)}",
            f"{len(parameters)} {' '.join(parameters)}",
            words(component, component.inputs),
            words(component, component.outputs),
            rows(results.inputs, component.inputs) if component.inputs else "",
            "",
        ]
    )


@pytest.fixture(scope="module")
def replay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder for the program that runs an FMU, one for each platform."""
    return tmp_path_factory.mktemp("replay")


def replayed(
    platform: Platform, system: System, component: Component, results: Results, replay: Path, folder: Path
) -> dict[str, NDArray[np.float64]]:
    """The component's outputs after every step, from the binary of a platform."""
    program = replay / f"{platform.target}.exe"
    if not program.exists():
        pytest.importorskip("ziglang")
        source = Path(__file__).with_name("replay.c")
        compiler = [sys.executable, "-m", "ziglang", "cc", "-O1", "-target", platform.target]
        subprocess.run([*compiler, f"-I{HEADERS}", source, *platform.libraries, "-o", program], check=True)
    library = binary(component.fmu.path, platform, folder)
    finished = subprocess.run(
        [*platform.emulator, program, f"./{library.name}", component.fmu.guid, component.fmu.name],
        input=orders(system, component, results), capture_output=True, text=True, check=False,
        cwd=library.parent,
    )  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    table = np.array(
        [[float.fromhex(word) for word in line.split()] for line in finished.stdout.splitlines()]
    )
    return dict(zip(component.outputs, table.T, strict=True))


@pytest.mark.parametrize("scenario", ["swaying_ship", "flight_loose_tight"])
@pytest.mark.parametrize("platform", [LINUX, AARCH64, WINDOWS], ids=lambda platform: platform.target)
def test_results_are_those_of_linux(
    platform: Platform, scenario: str, fmus: Fmus, replay: Path, tmp_path: Path
) -> None:
    """To 1e-9 of the largest value of each output of the plant, 1e-6 of the filter, fed with the same inputs.

    Outputs that are zero but for rounding are compared as if their largest value were ATOM.
    """
    if platform.emulator and shutil.which(platform.emulator[0]) is None:
        pytest.skip(f"{platform.emulator[0]} is not installed")
    loaded = load_scenario(scenario, fmus, settings={"communication_step": STEP})
    system = of_scenario(loaded, fmus)
    expected = simulate(loaded, fmus, system)
    for component, tolerance in ((system.plant, 1e-9), (system.filter, 1e-6)):
        results = expected[component.name]
        columns = replayed(platform, system, component, results, replay, tmp_path)
        every = round(results.outputs["time"][1] / STEP)
        for name, column in columns.items():
            reference = results.outputs[name].astype(float)
            limit = tolerance * max(np.abs(reference).max(), ATOM)
            np.testing.assert_allclose(column[::every], reference, rtol=0, atol=limit, err_msg=name)
