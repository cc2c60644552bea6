"""Stored states: bit-identical continuation, also in another process, and refusal of what is no state."""

from __future__ import annotations

import multiprocessing
import struct
from ctypes import byref, c_char, c_size_t, c_void_p
from pathlib import Path

import pytest
from archives import SAMPLES, STEP, variants
from calls import ERROR, OK, Fmu, Instance, Number, run

MIDDLE = SAMPLES // 2
VERSION_OFFSET, VERSION_SIZE = 8, 4


def continue_elsewhere(
    archive: Path, folder: Path, states: list[bytes], signals: list[dict[str, Number]]
) -> list[list[bytes]]:
    """Runs in a process of its own."""
    fmu, continued = Fmu.loaded(archive, folder), []
    for state in states:
        with fmu.instance() as instance:
            status, handle = instance.deserialise(state)
            assert status == OK, instance.journal.last
            assert instance.restore(handle) == OK, instance.journal.last
            continued.append(run(instance, signals, MIDDLE, SAMPLES, STEP))
    return continued


def test_a_run_continues_bit_for_bit_in_another_process(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    states, expected = [], []
    for parameters in variants(fmu):
        with fmu.instance() as instance:
            instance.start(**parameters)
            first = run(instance, signals, 0, MIDDLE, STEP)
            states.append(instance.serialise())
            expected.append(run(instance, signals, MIDDLE, SAMPLES, STEP))
        assert len(set(first + expected[-1])) > SAMPLES // 200, (
            "the outputs must move for the comparison to mean anything"
        )
    with multiprocessing.get_context("spawn").Pool(1) as process:
        continued = process.apply(continue_elsewhere, (fmu.archive, fmu.folder, states, signals))
    assert continued == expected


def test_going_back_and_again(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    with fmu.instance() as instance:
        instance.start()
        run(instance, signals, 0, 500, STEP)
        state = instance.save()
        once = run(instance, signals, 500, 900, STEP)
        assert instance.restore(state) == OK
        assert run(instance, signals, 500, 900, STEP) == once


def test_a_state_carries_parameters_and_phase(fmu: Fmu) -> None:
    name = next(v.name for v in fmu.of("parameter", "fixed") if v.type == "Real")
    with fmu.instance() as source, fmu.instance() as target:
        value = float(fmu.variables[name].start) * 0.5
        source.set(name, value)
        source.start(start=7.0)
        status, handle = target.deserialise(source.serialise())
        assert status == OK
        assert target.restore(handle) == OK
        assert target.get(name) == value
        assert target.step(7.0, STEP) == OK


def test_overwriting_a_state(instance: Instance) -> None:
    instance.start()
    state = instance.save()
    instance.step(0.0, STEP)
    same = c_void_p(state.value)
    assert instance.call("fmi2GetFMUstate", byref(same)) == OK
    assert same.value == state.value
    instance.step(STEP, STEP)
    assert instance.restore(state) == OK
    assert instance.step(STEP, STEP) == OK


def test_states_of_others_are_refused(fmu: Fmu) -> None:
    with fmu.instance() as one, fmu.instance() as other:
        one.start()
        other.start()
        state = one.save()
        assert other.restore(state) == ERROR
        assert "serialise it" in other.journal.last
        assert other.step(0.0, STEP) == OK


def test_a_freed_state_is_refused(instance: Instance) -> None:
    instance.start()
    state = instance.save()
    freed = c_void_p(state.value)
    assert instance.call("fmi2FreeFMUstate", byref(freed)) == OK
    assert freed.value is None
    assert instance.restore(state) == ERROR


@pytest.mark.parametrize("length", [0, 5, 8, 12, 19, 20, 100, -1])
def test_truncated(instance: Instance, length: int) -> None:
    state = instance.start().serialise()
    status, handle = instance.deserialise(state[:length])
    assert status == ERROR
    assert handle.value is None
    assert "not the state of" in instance.journal.last or "truncated" in instance.journal.last


def test_every_flipped_byte(instance: Instance) -> None:
    state = instance.start().serialise()
    for position in range(0, len(state), max(1, len(state) // 500)):
        damaged = bytearray(state)
        damaged[position] ^= 0x10
        status, _ = instance.deserialise(bytes(damaged))
        assert status == ERROR, f"byte {position}"
    assert instance.step(0.0, STEP) == OK
    assert instance.deserialise(state)[0] == OK


def test_wrong_version(instance: Instance) -> None:
    state = bytearray(instance.start().serialise())
    state[VERSION_OFFSET : VERSION_OFFSET + VERSION_SIZE] = struct.pack("<I", 99)
    assert instance.deserialise(bytes(state))[0] == ERROR
    assert "has format version 99; this FMU reads version 2" in instance.journal.last


def test_appended_bytes(instance: Instance) -> None:
    assert instance.deserialise(instance.start().serialise() + b"\0")[0] == ERROR


def test_state_of_another_fmu(fmu: Fmu, fmus: dict[str, Fmu], instance: Instance) -> None:
    foreign = next(other for other in fmus.values() if other.name != fmu.name)
    with foreign.instance() as stranger:
        state = stranger.start().serialise()
    assert instance.deserialise(state)[0] == ERROR
    assert instance.journal.last.endswith(f"the stored state is one of {foreign.name}; this is {fmu.name}")


def test_a_buffer_that_is_too_small(instance: Instance) -> None:
    state = instance.start().save()
    assert instance.call("fmi2SerializeFMUstate", state, (c_char * 4)(), c_size_t(4)) == ERROR
    assert "the buffer has 4 bytes, the state needs" in instance.journal.last
