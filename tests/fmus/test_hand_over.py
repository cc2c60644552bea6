"""An alignment handed over to navigation, FMU to FMU, in both orders of a master."""

from __future__ import annotations

import math

import pytest
from archives import FILTERS, ROOT
from calls import OK, Fmu, Instance, Number
from reading import read

STEP = 0.1
SECONDS = 330
AT_NAV = ("roll", "pitch", "heading", "latitude", "longitude", "height", "time")
VECTORS = ("gyro_bias", "accelerometer_bias")


def handed(alignment: dict[str, Number]) -> dict[str, Number]:
    """The alignment's outputs as the navigation's inputs."""
    return {
        "initial.valid": int(alignment["converged"]),
        **{f"initial.{name}": alignment[f"nav.{name}"] for name in AT_NAV},
        **{f"initial.velocity[{i}]": alignment[f"nav.velocity[{i}]"] for i in (1, 2, 3)},
        **{f"initial.{name}[{i}]": alignment[f"{name}[{i}]"] for name in VECTORS for i in (1, 2, 3)},
        **{
            f"initial.covariance[{i},{j}]": alignment[f"covariance[{i},{j}]"]
            for i in range(1, 13)
            for j in range(1, 13)
        },
    }


def step(instance: Instance, index: int, values: dict[str, Number]) -> None:
    instance.inputs.assign(values)
    assert instance.inputs.write(instance) == OK
    assert instance.step(index * STEP, STEP) == OK, instance.journal.last


@pytest.mark.parametrize(
    ("jacobi", "models"),
    [
        (False, ("large_azimuth", "loose")),
        (True, ("large_azimuth", "loose")),
        (False, ("invariant", "invariant")),
        (True, ("invariant", "tight")),
    ],
)
def test_an_alignment_is_handed_over(fmus: dict[str, Fmu], jacobi: bool, models: tuple[str, str]) -> None:
    """The invariant alignment does without the heading at the start, which is far off."""
    aligning, navigating = (
        read(ROOT / "modelDescription" / f"{name}.toml").enumeration["ErrorModel"].value(model)
        for name, model in zip(FILTERS, models, strict=True)
    )
    heading = 2.5 if models[0] == "invariant" else 0.1
    with (
        fmus["TruthPlant"].instance() as plant,
        fmus["AlignmentFilter"].instance() as alignment,
        fmus["NavigationFilter"].instance(logging=True) as navigation,
    ):
        plant.start()
        alignment.start(**{"error_model": aligning, "prior.heading_sigma": 0.17, "initial.heading": heading})
        navigation.start(**{"error_model": navigating, "initial.valid": 0})
        signals, aligned = plant.read(), alignment.read()
        started = None
        for index in range(round(SECONDS / STEP)):
            old_signals, old_aligned = signals, aligned
            assert plant.step(index * STEP, STEP) == OK
            signals = plant.read()
            step(alignment, index, old_signals if jacobi else signals)
            aligned = alignment.read()
            step(navigation, index, {**old_signals, **handed(old_aligned)} if jacobi
                 else {**signals, **handed(aligned)})  # fmt: skip
            if started is None and navigation.get("status") != 1:
                started = navigation.read()
        truth = old_signals if jacobi else signals
        found = navigation.read()
    lines = [line.text for line in navigation.journal.lines]
    assert sum("navigation starts at" in line for line in lines) == 1
    assert not any("refused" in line for line in lines)

    # The first fix after the hand-over finds the heading as sure as it was, not as the prior has it.
    assert started is not None
    assert 0.5 * aligned["heading_sigma"] < started["heading_sigma"] < 2 * aligned["heading_sigma"]
    error = math.remainder(found["nav.heading"] - truth["truth.heading"], math.tau)
    assert abs(error) < 4 * found["heading_sigma"] < math.radians(2.0)
    north = 6.36e6 * (found["nav.latitude"] - truth["truth.latitude"])
    assert abs(north) < 4 * found["position_sigma[2]"] < 15.0
