"""Other tools run the exported pair for 600 s and reach the reference results.

All steps are Jacobi steps of 0.5 s. On one platform the results agree to the last bit; TOLERANCE leaves room
for importers that add up their times in floating point.
"""

from __future__ import annotations

import csv
import ctypes
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from archives import FMUS
from calls3 import Fmu3, Ports3
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv
from numpy.typing import NDArray

from sim_scenarios.exchange import System, export
from sim_scenarios.fmus import Fmu, Fmus

STEP = 0.5
STOP = 600.0
TOLERANCE = {"rtol": 1e-12, "atol": 1e-12}
SHOWN = ("nav.heading", "nav.roll", "nav.latitude", "nav.velocity[1]", "heading_sigma")


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("export")


@pytest.fixture(scope="session")
def system(folder: Path) -> System:
    """The exported system; libcosim could not set another corrector than the default one."""
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    return export("swaying_ship", folder, set={"corrector": "standard"}, step=STEP, fmus=fmus)


def table(path: Path) -> NDArray[np.void]:
    """All columns as numbers; FMPy and the reference write Booleans as words."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    words = {"True": 1.0, "False": 0.0}
    values = [tuple(words[text] if text in words else float(text) for text in row) for row in rows]
    return np.array(values, dtype=[(name, float) for name in header])


@pytest.fixture(scope="session")
def reference(system: System, folder: Path) -> NDArray[np.void]:
    """What the filter must put out, each second."""
    return table(folder / "reference" / f"{system.filter.fmu.name}_ref.csv")


def assert_reached(values: list[float], reference: NDArray[np.void]) -> None:
    """The filter's outputs at the end are those of the reference, and not those of the start."""
    last = reference[-1]
    assert last["time"] == STOP
    assert abs(last["nav.heading"] - reference[0]["nav.heading"]) > 0.01
    np.testing.assert_allclose(values, [last[name] for name in SHOWN], **TOLERANCE)


# ------------------------------------------------------------------ FMPy


def assert_same_table(result: NDArray[np.void], expected: NDArray[np.void]) -> None:
    every = round((expected["time"][1] - expected["time"][0]) / STEP)
    for name in expected.dtype.names:
        column = result[name][::every].astype(float)
        np.testing.assert_allclose(column, expected[name].astype(float), err_msg=name, **TOLERANCE)


def test_fmpy_repeats_the_reference_experiment_of_each_fmu(system: System, folder: Path) -> None:
    for component in system.components:
        name = component.fmu.name
        expected = table(folder / "reference" / f"{name}_ref.csv")
        result = fmpy.simulate_fmu(
            str(folder / "fmi2" / f"{name}.fmu"), stop_time=STOP, output_interval=STEP,
            start_values=dict(component.values), output=[n for n in expected.dtype.names if n != "time"],
            input=table(folder / "reference" / f"{name}_in.csv") if component.inputs else None,
        )  # fmt: skip
        assert_same_table(result, expected)


def test_fmpy_model_exchange_samples_as_co_simulation_does(system: System, folder: Path) -> None:
    """With a solver of its own; the inputs of an event are there at once, those of a step at its end."""
    component = system.filter
    shared = {
        "stop_time": STOP, "output_interval": STEP, "start_values": dict(component.values),
        "input": table(folder / "reference" / f"{component.fmu.name}_in.csv"), "output": component.outputs,
    }  # fmt: skip
    archive = str(folder / "fmi2" / f"{component.fmu.name}.fmu")
    exchanged = fmpy.simulate_fmu(archive, fmi_type="ModelExchange", record_events=False, **shared)
    stepped = fmpy.simulate_fmu(archive, fmi_type="CoSimulation", **shared)
    assert len(exchanged) == len(stepped)
    for name in component.outputs:
        np.testing.assert_array_equal(exchanged[name][:-1], stepped[name][1:], err_msg=name)


def test_fmpy_runs_the_fmi_3_pair(
    system: System, folder: Path, reference: NDArray[np.void], tmp_path: Path
) -> None:
    """Step by step: the inputs of FMPy's own `simulate_fmu` cannot be arrays that change at events."""
    ports, slaves = {}, {}
    for component in system.components:
        archive = folder / "fmi3" / f"{component.fmu.name}.fmu"
        fmu = Fmu3.load(archive, tmp_path / component.name)
        slave = slaves[component.name] = fmu.slave()
        parameters = Ports3(slave, fmu.of("parameter"))
        parameters.write(parameters.filled(component.values))
        slave.enterInitializationMode(startTime=0.0, stopTime=STOP)
        ports[component.name] = {kind: Ports3(slave, fmu.of(kind)) for kind in ("input", "output")}
    plant, filter_ = ports[system.plant.name], ports[system.filter.name]
    inputs = filter_["input"]
    given = {**system.filter.values, **plant["output"].read()}
    inputs.write(inputs.filled(given))
    for slave in slaves.values():
        slave.exitInitializationMode()
    for index in range(round(STOP / STEP)):
        inputs.write(inputs.filled({**given, **plant["output"].read()}))
        for slave in slaves.values():
            slave.doStep(currentCommunicationPoint=index * STEP, communicationStepSize=STEP)
    values = filter_["output"].read()
    for slave in slaves.values():
        slave.terminate()
        slave.freeInstance()
    assert_reached([values[name] for name in SHOWN], reference)


def test_fmpy_ssp(system: System, folder: Path, reference: NDArray[np.void]) -> None:
    archive = folder / f"{system.name}.ssp"
    with zipfile.ZipFile(archive) as content:
        content.extractall(folder / "unpacked")
    # FMPy 0.3 overlooks parameter bindings; it takes one set with the components' names in front.
    sets = {
        c.name: read_ssv(str(folder / "unpacked" / "resources" / f"{c.name}.ssv")) for c in system.components
    }
    merged = sets[system.plant.name]
    for component, values in sets.items():
        for parameter in values.parameters:
            parameter.name = f"{component}.{parameter.name}"
    merged.parameters += sets[system.filter.name].parameters
    result = simulate_ssp(str(archive), stop_time=STOP, step_size=STEP, parameter_set=merged)
    assert_reached([result[f"filter.{name}"][-1] for name in SHOWN], reference)


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
@pytest.mark.parametrize("name", ["TruthPlant", "AlignmentFilter"])
def test_fmpy_command_line_with_default_arguments(name: str, version: str, tmp_path: Path) -> None:
    """It chooses a coarse step by itself; the truth does not depend on it, the filter waits for data."""
    archive, output = {"fmi2": FMUS, "fmi3": FMUS / "fmi3"}[version] / f"{name}.fmu", tmp_path / "result.csv"
    subprocess.run(
        [sys.executable, "-m", "fmpy", "simulate", archive, "--output-file", output],
        check=True, capture_output=True, cwd=tmp_path,
    )  # fmt: skip
    with output.open(newline="") as file:
        *_, last = csv.DictReader(file)
    assert float(last["time"]) == pytest.approx(STOP)
    if name == "TruthPlant":
        fine = fmpy.simulate_fmu(str(FMUS / f"{name}.fmu"), output_interval=0.05, stop_time=STOP)[-1]
        assert float(last["imu.time"]) == pytest.approx(STOP)
        for truth in ("truth.heading", "truth.latitude", "truth.roll"):
            assert float(last[truth]) == pytest.approx(fine[truth], abs=1e-9)
    else:
        assert int(last["status"]) == 1


# ------------------------------------------------------------------ other importers


@pytest.mark.parametrize("form", ["osp", "ssp"])
def test_libcosim(form: str, system: System, folder: Path, reference: NDArray[np.void]) -> None:
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    if form == "osp":
        execution = CosimExecution.from_osp_config_file(str(folder / "OspSystemStructure.xml"))
    else:
        execution = CosimExecution.from_ssp_file(str(folder / f"{system.name}.ssp"))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    assert execution.simulate_until(round(STOP * 1e9))
    index = execution.slave_index_from_instance_name(system.filter.name)
    references = [system.filter.fmu.variables[name].reference for name in SHOWN]
    assert_reached(list(observer.last_real_values(index, references)), reference)


def test_ecos(system: System, folder: Path, reference: NDArray[np.void]) -> None:
    library = Path(sys.prefix) / "lib" / "libtbb.so.12"
    if library.exists():  # PyPI's tbb lies where the loader does not look
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    pytest.importorskip("ecospy")
    from ecospy import EcosSimulation

    with EcosSimulation(STEP, ssp_path=str(folder / f"{system.name}.ssp")) as simulation:
        simulation.init(parameter_set=system.name)
        simulation.step(round(STOP / STEP))
        values = [simulation.get_real(f"{system.filter.name}::{name}") for name in SHOWN]
    assert_reached(values, reference)
