"""The plant and a filter as they come out of the box, connected by name, work together."""

from __future__ import annotations

import math

import pytest
from archives import FILTERS
from calls import OK, Fmu

STEP = 0.1
ARCMIN = math.pi / 180 / 60


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_heading_is_found(fmus: dict[str, Fmu], name: str, seed: int) -> None:
    """From level and north, where the ship rolls 8 deg and yaws 5 deg: beyond the prior of the tilt."""
    with fmus["TruthPlant"].instance() as plant, fmus[name].instance() as instance:
        plant.start(seed=seed)
        instance.start()
        for index in range(6000):
            assert plant.step(index * STEP, STEP) == OK, plant.journal.last
            instance.inputs.assign(plant.read())
            assert instance.inputs.write(instance) == OK
            assert instance.step(index * STEP, STEP) == OK, instance.journal.last
        truth, found = plant.read(), instance.read()
    error = math.remainder(found["nav.heading"] - truth["truth.heading"], math.tau)
    # An accurate filter is at 15 arcmin (the limit by the gyro bias), one in 10000 beyond 60.
    assert abs(error) < 60 * ARCMIN
    assert abs(error) < 4 * found["heading_sigma"]
    assert found["converged"]
