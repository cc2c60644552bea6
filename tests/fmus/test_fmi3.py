"""The FMI 3.0 FMUs: sound archives, the FMI 2 results bit for bit, and refusals."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import zipfile
from ctypes import byref, c_double, c_int64, c_size_t, c_uint, c_void_p
from pathlib import Path

import fmpy
import pytest
from archives import FMUS, STEP
from calls import OK, Fmu, Number
from calls3 import KINDS, Fmu3, Ports3, scalar_names
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from lxml import etree

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3"
HEADER = Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h"
ERROR3 = 3


@pytest.fixture(scope="session")
def fmu3(fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> Fmu3:
    """The FMI 3 FMU of the same component, with the same resources."""
    folder = tmp_path_factory.mktemp(fmu.name)
    if (fmu.folder / "resources").exists():
        shutil.copytree(fmu.folder / "resources", folder / "resources")
    return Fmu3.load(FMUS / "fmi3" / fmu.archive.name, folder)


def bits(values: dict[str, Number]) -> dict[str, bytes]:
    """Exact values, whatever the width that a version gives to integers."""
    return {
        name: bytes(c_double(value)) if isinstance(value, float) else bytes(c_int64(int(value)))
        for name, value in values.items()
    }


# ------------------------------------------------------------------ archive


def test_validator_finds_nothing(fmu3: Fmu3) -> None:
    assert validate_fmu(str(fmu3.archive)) == []


@pytest.mark.parametrize(
    ("member", "schema"),
    [
        ("modelDescription.xml", "fmi3ModelDescription.xsd"),
        ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3TerminalsAndIcons.xsd"),
    ],
)
def test_schema(fmu3: Fmu3, member: str, schema: str) -> None:
    with zipfile.ZipFile(fmu3.archive) as content:
        document = etree.fromstring(content.read(member))
    etree.XMLSchema(etree.parse(SCHEMA / schema)).assertValid(document)


def test_exports_the_functions_of_the_standard_and_nothing_else(fmu3: Fmu3) -> None:
    binary = next((fmu3.folder / "binaries").rglob(f"{fmu3.archive.stem}.so"))
    assert binary.parent.name.endswith("-linux")
    table = subprocess.run(
        ["nm", "-D", "--defined-only", binary], capture_output=True, text=True, check=True
    ).stdout
    standard = set(re.findall(r"FMI3_Export fmi3\w+TYPE\s+(fmi3\w+);", HEADER.read_text()))
    assert len(standard) > 70
    assert {line.split()[-1] for line in table.splitlines()} == standard


def test_both_versions_describe_the_same_variables(fmu: Fmu, fmu3: Fmu3) -> None:
    described = {}
    for variable in fmu3.description.modelVariables:
        starts = variable.start.split() if variable.start else []
        for index, name in enumerate(scalar_names(variable)):
            start = starts[index if len(starts) > 1 else 0] if starts else None
            described[name] = (variable.causality, variable.variability, start)
    del described["time"]
    assert described == {v.name: (v.causality, v.variability, v.start) for v in fmu.variables.values()}
    assert fmu3.description.instantiationToken == fmu.guid


def test_terminals_name_members_of_equal_name(fmu: Fmu, fmu3: Fmu3) -> None:
    names = {v.name for v in fmu3.description.modelVariables}
    for archive, known in ((fmu.archive, set(fmu.variables)), (fmu3.archive, names)):
        with zipfile.ZipFile(archive) as content:
            document = etree.fromstring(content.read("terminalsAndIcons/terminalsAndIcons.xml"))
        terminals = {terminal.get("name"): terminal for terminal in document.iter("Terminal")}
        assert set(terminals) == {"imu", "gnss", "body_velocity", "heading_aid", "height_aid"}
        for port, terminal in terminals.items():
            members = {m.get("variableName"): m.get("memberName") for m in terminal}
            assert set(members) <= known
            assert "sample" in members.values()
            assert all(variable == f"{port}.{member}" for variable, member in members.items())


# ------------------------------------------------------------------ results


def test_the_results_are_those_of_fmi_2_bit_for_bit(
    fmu: Fmu, fmu3: Fmu3, signals: list[dict[str, Number]]
) -> None:
    slave = fmu3.slave()
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    inputs, outputs = (Ports3(slave, fmu3.of(causality)) for causality in ("input", "output"))
    fed = {name: number for name, number in inputs.read().items() if name not in signals[0]}
    moved = set()
    with fmu.instance() as instance:
        instance.start()
        assert bits(outputs.read()) == bits(instance.read())
        for index in range(500):
            sample = {**fed, **signals[index]}
            instance.inputs.assign(sample)
            assert instance.inputs.write(instance) == OK
            inputs.write(sample)
            assert instance.step(index * STEP, STEP) == OK, instance.journal.last
            slave.doStep(currentCommunicationPoint=index * STEP, communicationStepSize=STEP)
            values = bits(instance.read())
            moved.add(tuple(values.values()))
            assert bits(outputs.read()) == values, f"step {index}"
    assert len(moved) > 4, "the outputs must move for the comparison to mean anything"
    slave.terminate()
    slave.freeInstance()


def test_a_state_belongs_to_its_version(fmu: Fmu, fmu3: Fmu3) -> None:
    with fmu.instance() as instance:
        instance.start()
        assert instance.step(0.0, STEP) == OK
        state = instance.serialise()
    slave = fmu3.slave()
    with pytest.raises(FMICallException, match="fmi3DeserializeFMUState failed with status 3"):
        slave.deserializeFMUState(state)
    slave.freeInstance()


def test_the_time_is_a_variable(fmu3: Fmu3) -> None:
    slave = fmu3.slave()
    slave.enterInitializationMode(startTime=5.0)
    slave.exitInitializationMode()
    slave.doStep(currentCommunicationPoint=5.0, communicationStepSize=STEP)
    (time,) = fmu3.of("independent")
    assert slave.getFloat64([time.valueReference]) == [pytest.approx(5.0 + STEP)]
    slave.freeInstance()


# ------------------------------------------------------------------ refusals


def refusal(fmu3: Fmu3, function: str, *arguments: object) -> int:
    """Status of a call on a stepping instance."""
    slave = fmu3.slave()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    status = int(slave.dll[function](c_void_p(slave.component), *arguments))
    slave.freeInstance()
    return status


NOT_OFFERED = {
    "fmi3EnterStepMode": (),
    "fmi3EnterEventMode": (),
    "fmi3EnterConfigurationMode": (),
    "fmi3EvaluateDiscreteStates": (),
    "fmi3GetFloat32": (byref(c_uint(0)), c_size_t(1), None, c_size_t(1)),
    "fmi3SetString": (byref(c_uint(0)), c_size_t(1), None, c_size_t(1)),
    "fmi3GetClock": (byref(c_uint(0)), c_size_t(1), None),
    "fmi3GetIntervalDecimal": (None, c_size_t(0), None, None),
    "fmi3GetOutputDerivatives": (None, c_size_t(0), None, None, c_size_t(0)),
    "fmi3GetDirectionalDerivative": (*((None, c_size_t(0)) * 4),),
    "fmi3ActivateModelPartition": (c_uint(0), c_double(0.0)),
    "fmi3GetFloat64": (None, c_size_t(1), None, c_size_t(1)),
    "fmi3SetInt64": (None, c_size_t(1), None, c_size_t(1)),
    "fmi3GetFMUState": (None,),
}  # fmt: skip


@pytest.mark.parametrize("function", NOT_OFFERED)
def test_what_is_not_offered_is_refused(fmu3: Fmu3, function: str) -> None:
    assert refusal(fmu3, function, *NOT_OFFERED[function]) == ERROR3


def test_null_instances_are_refused(fmu3: Fmu3) -> None:
    slave = fmu3.slave()
    for function, arguments in NOT_OFFERED.items():
        assert slave.dll[function](None, *arguments) == ERROR3, function
    slave.freeInstance()


def test_an_array_needs_all_its_values(fmu3: Fmu3) -> None:
    array = next(v for v in fmu3.description.modelVariables if v.dimensions and v.type == "Float64")
    slave = fmu3.slave()
    with pytest.raises(FMICallException):
        slave.setFloat64([array.valueReference], [1.0])
    slave.freeInstance()


def test_each_variable_has_one_reference_and_one_type(fmu3: Fmu3) -> None:
    """The references in between are those of elements in FMI 2, and of nothing here."""
    kinds = {v.valueReference: KINDS[v.type] for v in fmu3.description.modelVariables}
    sizes = {v.valueReference: len(scalar_names(v)) for v in fmu3.description.modelVariables}
    assert len(kinds) < max(kinds) + 1, "there are arrays"
    slave = fmu3.slave()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    buffer = (c_double * max(sizes.values()))()
    for reference in range(max(kinds) + 2):
        for kind in KINDS.values():
            status = slave.dll[f"fmi3Get{kind}"](
                c_void_p(slave.component), byref(c_uint(reference)), c_size_t(1),
                buffer, c_size_t(sizes.get(reference, 1)),
            )  # fmt: skip
            assert status == (OK if kinds.get(reference) == kind else ERROR3), (reference, kind)
    slave.freeInstance()


def test_any_byte_but_zero_is_true(fmu3: Fmu3) -> None:
    """A state with another byte could not be restored."""
    settable = [
        v for v in fmu3.description.modelVariables
        if v.type == "Boolean" and v.causality in ("input", "parameter")
    ]  # fmt: skip
    slave = fmu3.slave()
    for variable in settable:
        size = len(scalar_names(variable))
        bytes_ = (ctypes.c_ubyte * size)(*[2] * size)
        arguments = (
            c_void_p(slave.component), byref(c_uint(variable.valueReference)), c_size_t(1),
            bytes_, c_size_t(size),
        )  # fmt: skip
        assert slave.dll["fmi3SetBoolean"](*arguments) == OK
        slave.setFMUState(slave.getFMUState())
    slave.enterInitializationMode()
    for variable in settable:
        size = len(scalar_names(variable))
        assert slave.getBoolean([variable.valueReference], nValues=size) == [True] * size
    slave.freeInstance()


LOGGER = ctypes.CFUNCTYPE(None, c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


def test_a_log_that_is_off_tells_nothing(fmu3: Fmu3) -> None:
    """FMI 3 asks to respect the switch for errors, too."""
    lines: list[str] = []
    logger = LOGGER(lambda _environment, _status, _category, text: lines.append(text.decode()))
    slave = fmu3.slave()
    instantiate = slave.dll["fmi3InstantiateCoSimulation"]
    instantiate.restype = c_void_p
    resources = f"{fmu3.folder / 'resources'}/".encode()
    for logging in (False, True):
        given = b"x", fmu3.description.instantiationToken.encode(), resources, False, logging
        handle = c_void_p(instantiate(*given, False, False, None, c_size_t(0), None, logger, None))

        def refused(handle: c_void_p = handle) -> int:
            """Lines that a refused call writes."""
            lines.clear()
            arguments = (c_double(0.0), c_double(STEP), False, None, None, None, None)
            assert slave.dll["fmi3DoStep"](handle, *arguments) == ERROR3
            return len(lines)

        assert refused() == logging
        for on in (True, False):
            assert slave.dll["fmi3SetDebugLogging"](handle, on, c_size_t(0), None) == OK
            assert refused() == on
        slave.dll["fmi3FreeInstance"](handle)
    slave.freeInstance()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"instantiationToken": b"another"}, "different builds"),
        ({"instanceName": b""}, "instanceName is NULL or empty"),
        ({"eventModeUsed": True}, "no event mode"),
    ],
)
def test_refused_instances(fmu3: Fmu3, change: dict[str, object], sentence: str) -> None:
    lines: list[str] = []
    logger = LOGGER(lambda _environment, _status, _category, text: lines.append(text.decode()))
    arguments = {
        "instanceName": b"x",
        "instantiationToken": fmu3.description.instantiationToken.encode(),
        "eventModeUsed": False,
        **change,
    }
    slave = fmu3.slave()
    instantiate = slave.dll["fmi3InstantiateCoSimulation"]
    instantiate.restype = c_void_p
    handle = instantiate(
        arguments["instanceName"], arguments["instantiationToken"], None, False, False,
        arguments["eventModeUsed"], False, None, c_size_t(0), None, logger, None,
    )  # fmt: skip
    slave.freeInstance()
    assert handle is None
    assert len(lines) == 1
    assert sentence in lines[0]
