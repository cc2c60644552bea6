"""The same seed has the same bits on every processor: under qemu, with and without AVX2 and FMA.

A C library chooses its functions by the processor, and their last bits differ; the FMUs use none of them.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import c_program
import numpy as np
import pytest
from archives import FMUS
from numpy.typing import NDArray

from sim_scenarios.exchange.forms import FMI2
from sim_scenarios.exchange.system import System, of_scenario
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import load_scenario

EMULATOR = "qemu-x86_64"
PROCESSORS = {"SSE4.2": "Nehalem", "AVX": "SandyBridge", "AVX2 and FMA": "Haswell"}
SETTINGS = {"duration": 60.0, "evaluation.start": 30.0, "evaluation.stop": 60.0, "communication_step": 0.1}

FAULTY = {
    **{"fault.imu.kind": "silence", "fault.imu.begin": 35.0, "fault.imu.duration": 5.0},
    **{"gnss.latency": 0.123, "gnss.position_outlier.probability": 0.05},
}
"""What makes a filter begin anew, and take fixes between two samples of the IMU."""
BY_PROCESSOR = re.compile(
    r"(?:a?(?:sin|cos|tan)h?|atan2|sincos|exp[m12]*|exp10|log(?:1p|2|10)?|pow|cbrt|hypot|fma|[lt]gamma|erfc?)f?"
)
"""Functions of a C library that it has several of."""


def outputs_of(system: System, emulator: list[str], program: Path, folder: Path) -> NDArray[np.float64]:
    """Outputs of all components, a column each, after every step."""
    arguments: list[str] = []
    for component in system.components:
        with zipfile.ZipFile(component.fmu.path) as archive:
            library = archive.extract(f"binaries/linux64/{component.fmu.path.stem}.so", folder)
        arguments += [library, component.fmu.guid, component.fmu.name, "none"]
    references = {
        component.name: {name: v.reference for name, v in component.fmu.variables.items()}
        for component in system.components
    }
    given = c_program.orders(system, FMI2, references, with_parameters=True)
    return c_program.outputs([*emulator, program, *arguments], given, folder)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads a binary of Linux")
@pytest.mark.parametrize("name", ["TruthPlant", "AlignmentFilter", "NavigationFilter", "Playback"])
def test_no_function_is_used_that_the_processor_chooses(name: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(FMUS / f"{name}.fmu") as archive:
        (member,) = (one for one in archive.namelist() if one.endswith(f"/{name}.so"))
        library = archive.extract(member, tmp_path)
    listed = subprocess.run(
        ["nm", "-D", "--undefined-only", library], capture_output=True, text=True, check=True
    )
    used = {line.split()[-1].partition("@")[0] for line in listed.stdout.splitlines()}
    assert "memcpy" in used
    assert {one for one in used if BY_PROCESSOR.fullmatch(one)} == set()


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return c_program.compiled(["cc"], FMI2, tmp_path_factory.mktemp("program") / "system", ["-ldl"])


@pytest.mark.skipif(shutil.which(EMULATOR) is None, reason=f"{EMULATOR} is not installed")
@pytest.mark.parametrize("scenario", ["swaying_ship", "waves", "flight_loose_tight", "align_then_navigate"])
@pytest.mark.parametrize("settings", [{}, FAULTY], ids=["sound", "faulty"])
def test_every_processor_has_the_same_bits(
    scenario: str, settings: dict[str, object], program: Path, tmp_path: Path
) -> None:
    fmus = Fmus()
    system = of_scenario(load_scenario(scenario, fmus, settings={**SETTINGS, **settings}), fmus)
    here = outputs_of(system, [], program, tmp_path)
    assert len(here) == 601
    for name, processor in PROCESSORS.items():
        there = outputs_of(system, [EMULATOR, "-cpu", processor], program, tmp_path)
        np.testing.assert_array_equal(there, here, err_msg=name)
