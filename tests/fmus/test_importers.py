"""Other tools run what `truenorth export SCENARIO` writes, unchanged, and reach its reference results.

Nothing is handed in from outside: no parameter, no start value, no step but the one that the folder names.
With TRUENORTH_RECORD_IMPORTERS=1 the scenarios are run to their end, and what was measured is kept in
`importers.json`, of which `importer_table.py` makes `docs/importers.md`. Without it, they are cut short.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import c_program
import fmpy
import importer_table
import numpy as np
import pytest
from archives import FMUS, plain_csv
from calls import Number
from fmpy.ssp.simulation import simulate_ssp
from numpy.typing import NDArray
from typer.testing import CliRunner

from sim_scenarios import Start
from sim_scenarios.cli.application import app
from sim_scenarios.exchange.forms import FMI2, FMI3, Form
from sim_scenarios.exchange.recorded import of_recording
from sim_scenarios.exchange.replay import ATOM
from sim_scenarios.exchange.system import System, of_scenario
from sim_scenarios.exchange.verification import TOLERANCE
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import EXPORTED_STEP


def test_the_page_is_made_of_what_was_measured() -> None:
    """`python tests/fmus/importer_table.py` writes it."""
    assert importer_table.PAGE.read_text(encoding="utf-8") == importer_table.page()
    assert importer_table.load()
    for cell in importer_table.load():
        assert cell["scenario"] in (*SCENARIOS, RECORDING)
        assert cell["outcome"] in LIMITS.values() or float(cell["outcome"]) <= TOLERANCE


SCENARIOS = ("swaying_ship", "align_then_navigate", "flight_loose_tight", "dvl_alignment")
RECORDING = "recorded_ship"
"""20 s of the plant's signals in a CSV file."""

SHORT = {"align_then_navigate": 310.0}
"""It hands over after some 230 s; of the others, a minute shows all that is connected [s].

FMPy sums its steps: in 60 s and 310 s as in the whole scenarios, it takes no step too many.
"""


def settings(scenario: str) -> dict[str, float]:
    """What is set, of a scenario."""
    if importer_table.asked() or scenario == RECORDING:
        return {}
    duration = SHORT.get(scenario, 60.0)
    return {"duration": duration, "evaluation.start": duration / 2, "evaluation.stop": duration}


@dataclass(frozen=True)
class Exported:
    """A folder as the command wrote it."""

    scenario: str
    folder: Path
    system: System

    def reference(self, name: str, form: Form = FMI2, kind: str = "ref") -> NDArray[np.void]:
        """Inputs or outputs of the FMU of this name."""
        return importer_table.read_csv(self.folder / form.place(f"reference/{name}_{kind}.csv"))

    def fmu(self, name: str, form: Form) -> Path:
        return self.folder / form.name / f"{name}.fmu"

    @property
    def ssp(self) -> Path:
        return self.folder / f"{self.scenario}.ssp"


@pytest.fixture(scope="session", params=[*SCENARIOS, RECORDING])
def exported(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    signals: list[dict[str, Number]],
) -> Exported:
    """What a partner gets."""
    folder, scenario = tmp_path_factory.mktemp("partner"), request.param
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    changed = settings(scenario)
    file = plain_csv(signals, tmp_path_factory.mktemp("recording") / f"{RECORDING}.csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRUENORTH_FMUS", str(FMUS))
        what = [str(file) if scenario == RECORDING else scenario]
        what += [f"--set={name}={value}" for name, value in changed.items()]
        result = CliRunner().invoke(app, ["export", *what, "--output", str(folder)])
    assert result.exit_code == 0, result.output
    if scenario == RECORDING:
        recording = load_recording(file)
        options = {"task": Filter.alignment, "settings": {}, "fmus": fmus}
        return Exported(scenario, folder, of_recording(recording, Start(), file.parent, **options))
    loaded = load_scenario(scenario, fmus, settings={"communication_step": EXPORTED_STEP, **changed})
    return Exported(scenario, folder, of_scenario(loaded, fmus))


Record = Callable[[importer_table.Importer, float | str], None]


@pytest.fixture
def reached(exported: Exported) -> Record:
    """Judge a difference, and keep it, or what the importer cannot do."""

    def judge(importer: importer_table.Importer, outcome: float | str) -> None:
        importer_table.keep(importer, exported.scenario, outcome)
        assert isinstance(outcome, str) or outcome <= TOLERANCE

    return judge


def difference(values: Mapping[str, float], reference: NDArray[np.void], row: int = -1) -> float:
    """Largest difference from a row, of the largest value of each output, but at least ATOM.

    The row must not be like the first one, with which nothing would have been simulated.
    """
    assert values.keys() <= set(reference.dtype.names)
    assert len(values) > 5
    moved = [name for name in values if reference[name][row] != reference[name][0]]
    assert len(moved) > len(values) / 2
    return max(
        abs(float(value) - reference[name][row]) / max(np.abs(reference[name]).max(), ATOM)
        for name, value in values.items()
    )


def table_difference(result: NDArray[np.void], reference: NDArray[np.void]) -> float:
    """Largest difference over all rows of the reference that the result has, which must be all."""
    instants = np.round(reference["time"] * 1e6)
    rows = np.searchsorted(np.round(result["time"] * 1e6), instants, side="right") - 1
    np.testing.assert_allclose(result["time"][rows], reference["time"], atol=1e-6)
    return max(
        float(np.max(np.abs(result[name][rows].astype(float) - reference[name].astype(float))))
        / max(float(np.abs(reference[name]).max()), ATOM)
        for name in reference.dtype.names
        if name != "time"
    )


# ------------------------------------------------------------------ systems


def test_fmpy_ssp(exported: Exported, reached: Record) -> None:
    system = exported.system
    stop = system.checked - system.step / 2  # FMPy adds steps up, and 3000 of 0.1 s do not reach 300 s
    result = simulate_ssp(str(exported.ssp), stop_time=stop, step_size=system.step)
    reference = exported.reference(system.filter.fmu.name)
    assert len(result) == round(system.checked / system.step)
    final = {n: result[f"filter.{n}"][-1] for n in reference.dtype.names if n != "time"}
    reached(importer_table.Importer("FMPy", version("fmpy"), "SSP 1.0", "2"), difference(final, reference))


@pytest.mark.parametrize("form", ["OSP", "SSP 1.0"])
def test_libcosim(form: str, exported: Exported, reached: Record) -> None:
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    if form == "OSP":
        execution = CosimExecution.from_osp_config_file(str(exported.folder / "OspSystemStructure.xml"))
    else:
        execution = CosimExecution.from_ssp_file(str(exported.ssp))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    assert execution.simulate_until(round(exported.system.checked * 1e9))
    component = exported.system.filter
    index = execution.slave_index_from_instance_name(component.name)
    reals = [name for name in component.outputs if component.fmu.variables[name].kind == "Real"]
    references = [component.fmu.variables[name].reference for name in reals]
    values = dict(zip(reals, observer.last_real_values(index, references), strict=True))
    reached(
        importer_table.Importer("libcosim (libcosimpy)", version("libcosimpy"), form, "2"),
        difference(values, exported.reference(component.fmu.name)),
    )


def test_ecos(exported: Exported, reached: Record) -> None:
    library = Path(sys.prefix) / "lib" / "libtbb.so.12"
    if library.exists():  # PyPI's tbb lies where the loader does not look
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    pytest.importorskip("ecospy")
    from ecospy import EcosSimulation

    component = exported.system.filter
    reals = [name for name in component.outputs if component.fmu.variables[name].kind == "Real"]
    with EcosSimulation(exported.system.step, ssp_path=str(exported.ssp)) as simulation:
        simulation.init()
        simulation.step(round(exported.system.checked / exported.system.step))
        values = {name: simulation.get_real(f"{component.name}::{name}") for name in reals}
    reached(
        importer_table.Importer("Ecos (ecospy)", version("ecospy"), "SSP 1.0", "2"),
        difference(values, exported.reference(component.fmu.name)),
    )


@pytest.mark.parametrize("form", [FMI2, FMI3], ids=lambda form: form.name)
def test_c_program(form: Form, exported: Exported, reached: Record, tmp_path: Path) -> None:
    """`system.c` knows of the folder which FMUs there are and how they are connected, and nothing else."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    system = exported.system
    program = c_program.compiled([compiler], form, tmp_path / "system", ["-ldl"])
    arguments: list[str | Path] = []
    references = {}
    for component in system.components:
        archive = exported.fmu(component.fmu.name, form)
        fmu, folder = Fmu(archive), tmp_path / component.name
        fmpy.extract(archive, unzipdir=str(folder))
        resources = folder / "resources"
        (library,) = (folder / "binaries" / fmu.library.parent.name).iterdir()
        token = fmu.model.guid or fmu.model.instantiationToken
        arguments += [library, token, fmu.name, resources.as_uri() if form is FMI2 else resources]
        references[component.name] = {str(v.name): int(v.valueReference) for v in fmu.model.modelVariables}
    given = c_program.orders(system, form, references, with_parameters=False)
    columns = iter(c_program.outputs([program, *arguments], given, tmp_path).T)
    worst = 0.0
    for component in system.components:
        reference = exported.reference(component.fmu.name)
        every = round(reference["time"][1] / system.step)
        names = [e.name for entry in form.entries(component, component.outputs) for e in entry.elements]
        result = np.zeros(len(reference), dtype=[("time", float), *((name, float) for name in names)])
        result["time"] = reference["time"]
        for name in names:
            result[name] = next(columns)[::every]
        worst = max(worst, table_difference(result, reference))
    reached(
        importer_table.Importer("a C program, `tests/fmus/system.c`", "", "co-simulation", form.fmi), worst
    )


# ------------------------------------------------------------------ one FMU at a time

Words = list[str | Path]


@dataclass(frozen=True)
class Job:
    """What a command line is to do: run an FMU with the inputs, if there are any, and write some outputs."""

    fmu: Path
    inputs: Path | None
    output: Path
    shown: list[str]


@pytest.mark.parametrize("form", [FMI2, FMI3], ids=lambda form: form.name)
def test_fmpy_command_line(form: Form, exported: Exported, reached: Record, tmp_path: Path) -> None:
    """Each FMU with the inputs of the folder, by its step; what FMPy would choose is coarser."""

    def command(job: Job) -> Words:
        words = [sys.executable, "-m", "fmpy", "simulate", job.fmu, "--output-file", job.output]
        words += ["--output-interval", str(exported.system.step), "--output-variables", *job.shown]
        return [*words, "--input-file", job.inputs] if job.inputs else words

    importer = importer_table.Importer("FMPy", version("fmpy"), "command line", form.fmi)
    reached(importer, worst_of(exported, form, command, tmp_path))


@pytest.mark.parametrize("form", [FMI2, FMI3], ids=lambda form: form.name)
def test_fmusim(form: Form, exported: Exported, reached: Record, tmp_path: Path) -> None:
    """The simulator of the Modelica Association, in Rust, where it is: with the step that the FMUs state."""
    program = program_of("fmusim")

    def command(job: Job) -> Words:
        words = [program, "simulate", job.fmu, "--output-file", job.output]
        words += [word for name in job.shown for word in ("--output-variable", name)]
        return [*words, "--input-file", job.inputs] if job.inputs else words

    importer = importer_table.Importer("fmusim", version_of(program), "command line", form.fmi)
    reached(importer, worst_of(exported, form, command, tmp_path))


@pytest.mark.parametrize("form", [FMI2, FMI3], ids=lambda form: form.name)
def test_fmi_sim(form: Form, exported: Exported, reached: Record, tmp_path: Path) -> None:
    """The simulator of rust-fmi, where it is: with the step that the FMUs state."""
    program = program_of("fmi-sim")

    def command(job: Job) -> Words:
        words = [program, "--model", job.fmu, "--output-file", job.output]
        return [*words, *(["--input-file", job.inputs] if job.inputs else []), "co-simulation"]

    importer = importer_table.Importer("fmi-sim (rust-fmi)", version_of(program), "command line", form.fmi)
    reached(importer, worst_of(exported, form, command, tmp_path))


def program_of(name: str) -> Path:
    """A program that no registry of Python has."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"there is no {name}")
    return Path(found)


def version_of(program: Path) -> str:
    """Version that a program tells, after its name."""
    said = subprocess.run([program, "--version"], check=False, capture_output=True, text=True)
    return (said.stdout + said.stderr).split()[-1]


LIMITS = {
    "occurs more than once": "cannot read `x[1,2]` in a CSV",
    "could not convert string to float: 'false'": "cannot feed discrete arrays",
    "is out of bounds for axis 0": "cannot feed discrete arrays",
    "must be a divisor of the simulation duration (20.01)": "takes 0.01 s for no divisor of 20.01 s",
}
"""What command lines say of what they cannot do, and what that is."""


def worst_of(exported: Exported, form: Form, command: Callable[[Job], Words], folder: Path) -> float | str:
    """Largest difference of what a command line makes of the FMUs, one after the other; or its limit."""
    differences = []
    for component in exported.system.components:
        name = component.fmu.name
        reference = exported.reference(name, form)
        inputs = exported.folder / form.place(f"reference/{name}_in.csv")
        job = Job(
            exported.fmu(name, form),
            inputs if inputs.exists() else None,
            folder / f"{name}.csv",
            [column for column in reference.dtype.names if column != "time"],
        )
        finished = subprocess.run(command(job), check=False, capture_output=True, text=True, cwd=folder)
        if finished.returncode:
            limits = [limit for words, limit in LIMITS.items() if words in finished.stderr]
            assert limits, finished.stderr
            return limits[0]
        differences.append(table_difference(importer_table.read_csv(job.output), reference))
    return max(differences)
