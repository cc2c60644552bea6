"""Error models x predictors x correctors: what a filter accepts is what its page says, and works."""

from __future__ import annotations

import ctypes
import math
import re
from itertools import product

import pytest
from archives import FILTERS, ROOT
from calls import OK, Fmu, Number, Signals
from reading import read

STEP = 0.1
STEPS = 3000
AXES = ("error_model", "predictor", "corrector")
MOTION_KINDS = {"ship": 1, "parked_vehicle": 2}
Combination = tuple[str, str, str]


def items(name: str) -> dict[str, dict[str, int]]:
    """Number of every item of the three enumerations of a filter."""
    declaration = read(ROOT / "modelDescription" / f"{name}.toml")
    types = {v.name: declaration.enumeration[v.type] for v in declaration.variable if v.name in AXES}
    return {axis: {item.name: types[axis].value(item.name) for item in types[axis].items} for axis in AXES}


def documented(fmu: Fmu) -> set[Combination]:
    """The rows of the table of combinations, each a product of its first three cells."""
    page = (fmu.folder / "documentation" / "index.html").read_text(encoding="utf-8")
    table = re.search(r'<table class="combinations">(.*?)</table>', page, re.DOTALL)
    assert table, "the page has no table of combinations"
    rows = re.findall(r"<tr>(<td>.*?)</tr>", table[1], re.DOTALL)
    cells = [re.findall(r"<td>(.*?)</td>", row, re.DOTALL) for row in rows]
    return {
        c for row in cells for c in product(*(re.findall(r"<code>(\w+)</code>", text) for text in row[:3]))
    }


class Recording:
    """What the plant put out, as bytes that can be laid into a filter's inputs."""

    def __init__(self, fmus: dict[str, Fmu], sink: Fmu, kind: int) -> None:
        names = [name for name in fmus["TruthPlant"].variables if name in {v.name for v in sink.of("input")}]
        with fmus["TruthPlant"].instance() as plant:
            plant.start(**{"motion.kind": kind, "imu.accelerometer.bias_sigma": 1e-3})  # m/s2
            self.truth = [plant.read()]
            port = Signals(fmus["TruthPlant"].variables[name] for name in names)
            self.rows: list[bytes] = []
            for index in range(STEPS):
                assert plant.step(index * STEP, STEP) == OK, plant.journal.last
                assert port.read(plant) == OK
                self.rows.append(port.bytes)
            self.truth.append(plant.read())
        self.port = Signals(sink.variables[name] for name in names)

    def lay(self, index: int) -> None:
        row, begin = self.rows[index], 0
        for _, _, values in self.port.groups:
            size = ctypes.sizeof(values)
            ctypes.memmove(values, row[begin : begin + size], size)
            begin += size


@pytest.fixture(scope="module")
def recordings(fmus: dict[str, Fmu]) -> dict[tuple[str, str], Recording]:
    return {
        (name, kind): Recording(fmus, fmus[name], number)
        for name in FILTERS
        for kind, number in MOTION_KINDS.items()
    }


def start_of(truth: dict[str, Number]) -> dict[str, Number]:
    """The truth, heading and tilt a little off."""
    known = ("latitude", "longitude", "height", *(f"velocity[{i}]" for i in (1, 2, 3)))
    return {
        **{f"initial.{name}": truth[f"truth.{name}"] for name in known},
        "initial.roll": truth["truth.roll"] + 0.003,
        "initial.pitch": truth["truth.pitch"] - 0.003,
        "initial.heading": math.remainder(truth["truth.heading"] + 0.05, math.tau),
    }


def outcome(fmu: Fmu, recording: Recording, settings: dict[str, Number]) -> dict[str, Number] | None:
    """Outputs at the end; None if the initialisation was refused, which names one of the three parameters."""
    with fmu.instance() as instance:
        for name, value in {**start_of(recording.truth[0]), **settings}.items():
            assert instance.set(name, value) == OK, instance.journal.last
        assert instance.set_up() == OK
        instance.enter()
        if instance.exit() != OK:
            assert any(f"{axis} = " in instance.journal.last for axis in AXES), instance.journal.last
            return None
        for index in range(STEPS):
            recording.lay(index)
            assert recording.port.write(instance) == OK
            assert instance.step(index * STEP, STEP) == OK, instance.journal.last
        return instance.read()


def is_sane(found: dict[str, Number], truth: dict[str, Number]) -> bool:
    """Finite, at work, and after five minutes better than at the start."""
    heading = math.remainder(found["nav.heading"] - truth["truth.heading"], math.tau)
    tilt = max(abs(found[f"nav.{angle}"] - truth[f"truth.{angle}"]) for angle in ("roll", "pitch"))
    velocity = max(abs(found[f"nav.velocity[{i}]"] - truth[f"truth.velocity[{i}]"]) for i in (1, 2, 3))
    north = 6.4e6 * (found["nav.latitude"] - truth["truth.latitude"])
    return (
        all(math.isfinite(value) for value in found.values())
        and found["used_fixes"] + found["rejected_fixes"] == STEPS * STEP
        and found["used_fixes"] >= 0.95 * STEPS * STEP
        and abs(heading) < 0.03
        and tilt < 0.003
        and velocity < 0.5
        and abs(north) < 20.0
    )


@pytest.mark.parametrize("name", FILTERS)
def test_what_is_accepted_is_documented_and_works(
    fmus: dict[str, Fmu], recordings: dict[tuple[str, str], Recording], name: str
) -> None:
    numbers = items(name)
    accepted, insane = set(), []
    for combination in product(*numbers.values()):
        stationary = combination[0].startswith("euler")
        recording = recordings[name, "parked_vehicle" if stationary else "ship"]
        settings: dict[str, Number] = {
            axis: numbers[axis][item] for axis, item in zip(AXES, combination, strict=True)
        }
        if stationary:
            settings |= {f"initial.velocity[{i}]": 0.0 for i in (1, 2, 3)}
        found = outcome(fmus[name], recording, settings)
        if found is not None:
            accepted.add(combination)
            if not is_sane(found, recording.truth[1]):
                insane.append(combination)
    assert accepted == documented(fmus[name])
    assert insane == []
