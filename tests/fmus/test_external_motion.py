"""TruthPlant driven from outside through FMI, by another plant; examples/own_vehicle.py has its own ship."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from calls import OK, Fmu, Instance, Number

EXTERNAL = 4
PERIOD = 0.01
VECTORS = [f"imu.delta_{kind}[{i}]" for kind in ("angle", "velocity") for i in (1, 2, 3)]

Values = dict[str, Number]


@pytest.fixture
def plant(fmus: dict[str, Fmu]) -> Iterator[Instance]:
    with fmus["TruthPlant"].instance(logging=True) as instance:
        yield instance


@pytest.fixture
def source(fmus: dict[str, Fmu]) -> Iterator[Instance]:
    """A plant that moves the ship of swaying_ship."""
    with fmus["TruthPlant"].instance() as instance:
        yield instance.start()


def state(truth: Values) -> Values:
    """The truth of a plant as the state of a vehicle."""
    named = {
        "position": ["latitude", "longitude", "height"],
        "velocity": [f"velocity[{i}]" for i in (1, 2, 3)],
        "attitude": ["roll", "pitch", "heading"],
    }
    return {
        f"external.{name}[{i}]": truth[f"truth.{of}"]
        for name, names in named.items()
        for i, of in enumerate(names, 1)
    }


def tell(plant: Instance, values: Values) -> None:
    plant.inputs.assign(values)
    assert plant.inputs.write(plant) == OK


def begin(plant: Instance, values: Values) -> None:
    """Initialised with a first state of its vehicle."""
    plant.set("motion.kind", EXTERNAL)
    tell(plant, values)
    plant.start()


def test_the_swaying_ship_fed_from_its_own_truth_gives_the_same_increments(
    plant: Instance, source: Instance
) -> None:
    begin(plant, state(source.read()))
    for index in range(6000):
        assert source.step(index * PERIOD, PERIOD) == OK
        expected = source.read()
        tell(plant, {**state(expected), "external.time": expected["truth.time"]})
        assert plant.step(index * PERIOD, PERIOD) == OK
        got = plant.read()
        assert got["imu.sample"] == expected["imu.sample"]
        assert got["imu.time"] == expected["imu.time"] == got["truth.time"]
        assert got["gnss.sample"] == expected["gnss.sample"]
        limit = 1e-9 if index > 0 else 1e-7  # straight on: no state before is known
        assert max(abs(got[name] - expected[name]) for name in VECTORS) < limit, index
    assert got["external.rejected"] == 0


def test_a_bad_state_is_told_and_the_step_succeeds(plant: Instance, source: Instance) -> None:
    begin(plant, state(source.read()))
    assert source.step(0.0, PERIOD) == OK
    tell(plant, {**state(source.read()), "external.velocity[2]": math.nan, "external.time": PERIOD})
    assert plant.step(0.0, PERIOD) == OK
    assert plant.get("external.rejected") == 1
    assert plant.get("imu.sample") == 0
    assert plant.journal.last.endswith("external.velocity[2] = nan: must be from -10000 to 10000")
