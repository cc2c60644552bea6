"""Every function in every phase of an instance: what the standard allows works, the rest is refused."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest
from calls import ERROR, OK, Fmu, Instance

STEP = 0.01


def prepare(phase: str, instance: Instance) -> Instance:
    if phase != "instantiated":
        assert instance.set_up() == OK
        assert instance.enter() == OK
    if phase in ("stepping", "terminated"):
        assert instance.exit() == OK
    if phase == "terminated":
        assert instance.terminate() == OK
    return instance


PHASES = ("instantiated", "initialising", "stepping", "terminated")


def get_output(instance: Instance) -> int:
    return instance.outputs.read(instance)


def set_parameter(instance: Instance) -> int:
    variable = instance.fmu.of("parameter", "fixed")[0]
    return instance.set(variable.name, 1)


def save_and_restore(instance: Instance) -> int:
    state = c_void_p()
    status = instance.call("fmi2GetFMUstate", byref(state))
    return max(status, instance.restore(state), instance.call("fmi2FreeFMUstate", byref(state)))


ALLOWED: dict[str, tuple[Callable[[Instance], int], tuple[str, ...]]] = {
    "set up": (lambda i: i.set_up(), ("instantiated",)),
    "enter": (lambda i: i.enter(), ("instantiated",)),
    "exit": (lambda i: i.exit(), ("initialising",)),
    "step": (lambda i: i.step(0.0, STEP), ("stepping",)),
    "terminate": (lambda i: i.terminate(), ("stepping",)),
    "reset": (lambda i: i.reset(), PHASES),
    "get an output": (get_output, ("initialising", "stepping", "terminated")),
    "set a fixed parameter": (set_parameter, ("instantiated", "initialising")),
    "save and restore": (save_and_restore, PHASES),
    "logging": (lambda i: i.call("fmi2SetDebugLogging", 1, c_size_t(0), None), PHASES),
    "last time": (lambda i: i.call("fmi2GetRealStatus", 2, byref(c_double())), PHASES),
    "terminated": (lambda i: i.call("fmi2GetBooleanStatus", 3, byref(c_int())), PHASES),
}


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("what", ALLOWED)
def test_order(instance: Instance, phase: str, what: str) -> None:
    call, allowed = ALLOWED[what]
    prepare(phase, instance)
    status = call(instance)
    if phase in allowed:
        assert status == OK, instance.journal.last
        assert not instance.journal.lines
    else:
        assert status == ERROR
        line = instance.journal.lines[-1]
        assert "not allowed in the phase" in line.text or "cannot change after initialisation" in line.text
        assert (line.instance, line.status, line.category, line.format) == (
            "instance",
            ERROR,
            "logStatusError",
            "%s",
        )


def test_a_refused_call_changes_nothing(instance: Instance) -> None:
    instance.start()
    assert instance.step(0.0, STEP) == OK
    before = instance.serialise()
    for call, allowed in ALLOWED.values():
        if "stepping" not in allowed:
            assert call(instance) == ERROR
    assert instance.serialise() == before


UNSUPPORTED = {
    "fmi2CancelStep": (),
    "fmi2SetRealInputDerivatives": (None, c_size_t(0), None, None),
    "fmi2GetRealOutputDerivatives": (None, c_size_t(0), None, None),
    "fmi2GetStatus": (0, None),
    "fmi2GetIntegerStatus": (0, None),
    "fmi2GetStringStatus": (1, None),
    "fmi2GetRealStatus": (0, None),
    "fmi2GetBooleanStatus": (0, None),
    "fmi2GetDirectionalDerivative": (None, c_size_t(0), None, c_size_t(0), None, None),
    "fmi2GetString": (byref(c_uint(0)), c_size_t(1), None),
    "fmi2SetString": (byref(c_uint(0)), c_size_t(1), None),
    "fmi2EnterEventMode": (),
    "fmi2NewDiscreteStates": (None,),
    "fmi2EnterContinuousTimeMode": (),
    "fmi2CompletedIntegratorStep": (1, None, None),
    "fmi2SetTime": (c_double(0.0),),
    "fmi2SetContinuousStates": (None, c_size_t(0)),
    "fmi2GetDerivatives": (None, c_size_t(0)),
    "fmi2GetEventIndicators": (None, c_size_t(0)),
    "fmi2GetContinuousStates": (None, c_size_t(0)),
    "fmi2GetNominalsOfContinuousStates": (None, c_size_t(0)),
}


@pytest.mark.parametrize("function", UNSUPPORTED)
def test_what_is_not_supported_says_so(instance: Instance, function: str) -> None:
    instance.start()
    assert instance.call(function, *UNSUPPORTED[function]) == ERROR
    assert instance.journal.last.startswith(f"{function}: ")
    assert instance.step(0.0, STEP) == OK


@pytest.mark.parametrize("kind", [-1, 4, 2**31 - 1])
def test_kinds_of_status_that_there_are_not(instance: Instance, kind: int) -> None:
    instance.start()
    assert instance.call("fmi2GetRealStatus", kind, byref(c_double())) == ERROR
    assert instance.call("fmi2GetBooleanStatus", kind, byref(c_int())) == ERROR
    assert instance.call("fmi2GetStatus", kind, byref(c_int())) == ERROR


# Arguments after the component; None where a pointer is expected and something is asked of it.
NULLS = {
    "fmi2GetReal": (None, c_size_t(1), None),
    "fmi2GetInteger": (None, c_size_t(1), None),
    "fmi2GetBoolean": (None, c_size_t(1), None),
    "fmi2SetReal": (None, c_size_t(1), None),
    "fmi2SetInteger": (None, c_size_t(1), None),
    "fmi2SetBoolean": (None, c_size_t(1), None),
    "fmi2GetFMUstate": (None,),
    "fmi2SetFMUstate": (None,),
    "fmi2SerializedFMUstateSize": (None, None),
    "fmi2SerializeFMUstate": (None, None, c_size_t(8)),
    "fmi2DeSerializeFMUstate": (None, c_size_t(8), None),
    "fmi2SetDebugLogging": (1, c_size_t(1), None),
    "fmi2GetRealStatus": (2, None),
    "fmi2GetBooleanStatus": (3, None),
}
HARMLESS = {
    "fmi2SetupExperiment": (0, c_double(), c_double(), 0, c_double()),
    "fmi2EnterInitializationMode": (),
    "fmi2ExitInitializationMode": (),
    "fmi2Terminate": (),
    "fmi2Reset": (),
    "fmi2DoStep": (c_double(), c_double(STEP), 1),
    "fmi2FreeFMUstate": (None,),
}


@pytest.mark.parametrize("function", NULLS)
def test_null_pointers(instance: Instance, function: str) -> None:
    instance.start()
    assert instance.call(function, *NULLS[function]) == ERROR
    assert instance.journal.last.startswith(f"{function}: ")


@pytest.mark.parametrize("function", ["fmi2GetReal", "fmi2SetReal"])
def test_null_values(instance: Instance, function: str) -> None:
    instance.start()
    reference = c_uint(next(v.valueReference for v in instance.fmu.of("parameter") if v.type == "Real"))
    assert instance.call(function, byref(reference), c_size_t(1), None) == ERROR
    assert instance.journal.last == f"{function}: value is NULL"


@pytest.mark.parametrize("kind", ["Real", "Integer", "Boolean", "String"])
@pytest.mark.parametrize("access", ["Get", "Set"])
def test_nothing_is_asked_for(instance: Instance, access: str, kind: str) -> None:
    instance.start()
    assert instance.call(f"fmi2{access}{kind}", None, c_size_t(0), None) == OK


def test_null_component(fmu: Fmu) -> None:
    for function, arguments in {**UNSUPPORTED, **NULLS, **HARMLESS}.items():
        assert fmu.library[function](None, *arguments) == ERROR, function
    fmu.library.fmi2FreeInstance(None)


def test_freeing_no_state_is_fine(instance: Instance) -> None:
    assert instance.call("fmi2FreeFMUstate", None) == OK
    assert instance.call("fmi2FreeFMUstate", byref(c_void_p())) == OK
