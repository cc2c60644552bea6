"""Playback and its resources: where it finds the recording, and the sentence where it does not."""

from __future__ import annotations

import random
import shutil
from ctypes import byref
from pathlib import Path

import pytest
from archives import FMUS, SAMPLES, STEP, give_recording
from calls import CO_SIMULATION, ERROR, OK, Fmu, Journal, Number, run

Samples = list[dict[str, Number]]


@pytest.fixture
def template(tmp_path: Path) -> Fmu:
    """Playback as it is built."""
    return Fmu.load(FMUS / "Playback.fmu", tmp_path / "built")


def refusal(fmu: Fmu, resources: bytes | None) -> str:
    """What an FMU says that is not instantiated."""
    journal = Journal()
    handle = fmu.library.fmi2Instantiate(
        b"x", CO_SIMULATION, fmu.guid.encode(), resources, byref(journal.callbacks), 0, 0
    )
    assert handle is None
    assert [line.category for line in journal.lines] == ["logStatusError"]
    return journal.last


@pytest.mark.parametrize("told", [True, False])
def test_without_a_recording_it_is_not_instantiated(template: Fmu, told: bool) -> None:
    resources = (template.folder / "resources").as_uri().encode() if told else None
    said = refusal(template, resources)
    assert said.startswith("fmi2Instantiate: there is no ")
    assert "recording.bin: `truenorth export RECORDING` makes an FMU that has its recording" in said
    assert "the tool must tell the FMU where its resources are" in said


@pytest.mark.parametrize("slashes", ["file:///", "file:/", "file://localhost/"])
def test_folders_may_have_any_name(template: Fmu, signals: Samples, tmp_path: Path, slashes: str) -> None:
    folder = tmp_path / "a drive, 100 % süß #1"
    give_recording(folder, signals)
    uri = (folder / "resources").as_uri().replace("file:///", slashes)
    assert "%20" in uri
    journal = Journal()
    handle = template.library.fmi2Instantiate(
        b"x", CO_SIMULATION, template.guid.encode(), uri.encode(), byref(journal.callbacks), 0, 0
    )
    assert handle, journal.last
    template.library.fmi2FreeInstance(handle)


def test_damaged_recordings_are_refused_with_the_file(template: Fmu, signals: Samples) -> None:
    give_recording(template.folder, signals[:50])
    file, dice = template.folder / "resources" / "recording.bin", random.Random(1)
    whole = file.read_bytes()
    for number in range(200):
        damaged = bytearray(whole)
        if number % 2:
            damaged[dice.randrange(len(damaged))] ^= 1 << dice.randrange(8)
        else:
            del damaged[dice.randrange(len(damaged)) :]
        file.write_bytes(damaged)
        said = refusal(template, (template.folder / "resources").as_uri().encode())
        assert f"{file}: it is " in said


def test_the_file_is_read_once(template: Fmu, signals: Samples) -> None:
    """A reset and a stored state need it no more."""
    give_recording(template.folder, signals)
    with template.instance() as instance:
        shutil.rmtree(template.folder / "resources")
        once = run(instance.start(), signals, 0, SAMPLES, STEP)
        assert instance.reset() == OK
        state = instance.start().save()
        assert run(instance, signals, 0, SAMPLES, STEP) == once
        assert instance.restore(state) == OK
        assert run(instance, signals, 0, SAMPLES, STEP) == once


def test_two_recordings_in_one_process(fmus: dict[str, Fmu], template: Fmu, signals: Samples) -> None:
    """Neither knows of the other, and a state of the one is refused by the other."""
    give_recording(template.folder, signals[1000:])
    other = Fmu.loaded(template.archive, template.folder)
    with fmus["Playback"].instance() as first, other.instance() as second:
        first.start()
        second.start()
        for index in range(500):
            assert first.step(index * STEP, STEP) == OK
            assert second.step(index * STEP, STEP) == OK
        for instance, sample in ((first, signals[499]), (second, signals[1499])):
            shown = instance.read()
            for axis in (1, 2, 3):
                assert shown[f"imu.delta_angle[{axis}]"] == sample[f"imu.delta_angle[{axis}]"]
        status, state = second.deserialise(first.serialise())
        assert status == OK
        assert second.restore(state) == ERROR
        assert "one of another recording" in second.journal.last


def test_the_end_is_told_once(fmus: dict[str, Fmu]) -> None:
    with fmus["Playback"].instance(logging=True) as instance:
        instance.start()
        for index in range(0, 2 * SAMPLES, 10):
            assert instance.step(index * STEP, 10 * STEP) == OK
        assert instance.read()["recording.ended"]
        assert [line.text for line in instance.journal.lines] == [
            "the recording has ended at 20 s, 20 s of its own clock: nothing new comes any more"
        ]
