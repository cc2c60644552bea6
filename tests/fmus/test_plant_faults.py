"""Faults of the plant: their names are a contract, their page tells all of them, and each can be chosen."""

from __future__ import annotations

import re

import pytest
from archives import STEP
from calls import OK, Fmu

KINDS = {
    "imu": [
        "none",
        "silence",
        "not_a_number",
        "spike",
        "stuck",
        "zeros",
        "bias_step",
        "scale_step",
        "count_jump",
        "clock_step",
        "clock_drift",
        "repeated",
        "reordered",
    ],
    "gnss": [
        "none",
        "silence",
        "frozen",
        "position_jump",
        "drift",
        "velocity_sign",
        "time_offset",
        "latency",
    ],
}


@pytest.fixture
def plant(fmus: dict[str, Fmu]) -> Fmu:
    return fmus["TruthPlant"]


@pytest.mark.parametrize("sensor", KINDS)
def test_names_and_numbers_of_the_faults(plant: Fmu, sensor: str) -> None:
    items = plant.variables[f"fault.{sensor}.kind"].declaredType.items
    assert [item.name for item in items] == KINDS[sensor]
    assert [int(item.value) for item in items] == list(range(1, len(items) + 1))
    for name in ("begin", "duration", "size", "axis"):
        variable = plant.variables[f"fault.{sensor}.{name}"]
        assert (variable.causality, variable.variability) == ("parameter", "fixed")
        assert float(variable.start) == 0.0


@pytest.mark.parametrize("sensor", KINDS)
def test_the_page_tells_every_fault(plant: Fmu, sensor: str) -> None:
    page = (plant.folder / "documentation" / "index.html").read_text(encoding="utf-8")
    tables = re.findall(r'<table class="faults">(.*?)</table>', page, re.DOTALL)
    table = next(t for t in tables if f"<th><code>fault.{sensor}.kind</code></th>" in t)
    assert re.findall(r"<tr><td><code>(\w+)</code></td>", table) == KINDS[sensor]


@pytest.mark.parametrize(
    ("sensor", "kind"), [(sensor, kind) for sensor, kinds in KINDS.items() for kind in kinds[1:]]
)
def test_every_fault_is_seen_in_its_sensor_and_nowhere_else(plant: Fmu, sensor: str, kind: str) -> None:
    fault = {
        f"fault.{sensor}.kind": KINDS[sensor].index(kind) + 1,
        f"fault.{sensor}.begin": 2.0,
        f"fault.{sensor}.duration": 2.0,
        f"fault.{sensor}.size": 1.0,
    }
    disturbed = set()
    with plant.instance() as sound, plant.instance() as faulty:
        sound.start()
        faulty.start(**fault)
        for index in range(400):
            assert sound.step(index * STEP, STEP) == OK
            assert faulty.step(index * STEP, STEP) == OK
            expected, found = sound.read(), faulty.read()
            disturbed |= {name for name, value in found.items() if value != expected[name]}
    biases = {
        f"truth.{group}_bias[{i}]"
        for group in ("gyro", "accelerometer")
        for i in (1, 2, 3)
        if kind == "bias_step"
    }
    assert {name for name in disturbed if not name.startswith(f"{sensor}.")} == biases
    assert disturbed > biases
