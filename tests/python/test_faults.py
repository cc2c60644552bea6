"""When the faults of a plant end."""

import numpy as np
import pytest

from sim_scenarios import faults
from sim_scenarios.fmus import Fmus, Number


def of(fmus: Fmus, **given: object) -> float | None:
    values: dict[str, Number] = {}
    for name, value in given.items():
        values |= fmus.plant.assignments("fault." + name.replace("_", ".", 1), value)
    return faults.end(values, fmus.plant)


def test_no_fault_has_no_end(fmus: Fmus) -> None:
    assert of(fmus) is None
    assert of(fmus, imu_begin=30.0, imu_duration=5.0) is None


def test_a_fault_ends_after_its_duration(fmus: Fmus) -> None:
    assert of(fmus, imu_kind="silence", imu_begin=30.0, imu_duration=5.0) == 35
    later = {"gnss_kind": "frozen", "gnss_begin": 50.0, "gnss_duration": 10.0}
    assert of(fmus, imu_kind="silence", imu_begin=30.0, imu_duration=5.0, **later) == 60


@pytest.mark.parametrize("kind", faults.ONCE)
def test_what_happens_once_ends_at_once(fmus: Fmus, kind: str) -> None:
    assert of(fmus, imu_kind=kind, imu_begin=30.0) == 30


@pytest.mark.parametrize("kind", ["silence", "stuck", "zeros", "bias_step", "scale_step", "clock_step"])
def test_what_lasts_for_ever_has_no_end(fmus: Fmus, kind: str) -> None:
    assert of(fmus, imu_kind=kind, imu_begin=30.0) == np.inf


def test_every_kind_is_known(fmus: Fmus) -> None:
    """The plant says in words which kinds happen once without a duration."""
    said = fmus.plant.variables["fault.imu.duration"].description
    once = said.partition("once (")[2].partition(")")[0].split(", ")
    assert sorted(once) == sorted(faults.ONCE)


def test_faults_are_taken_out() -> None:
    plant = {"seed": 3, "fault.imu.kind": 2, "fault.imu.begin": 30.0}
    assert faults.without(plant) == {"seed": 3}
    assert faults.concerns("plant.fault.gnss.size")
    assert not faults.concerns("gnss.rate")
