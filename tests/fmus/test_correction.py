"""Whatever fixes say: weights in [0, 1], sound covariance; a neutral corrector is the standard one."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from archives import FILTERS, ROOT, requirements
from calls import OK, Fmu, Instance, Number
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from reading import read

GRAVITY = 9.795  # near the default place [m/s2]; what is wrong in it is one more thing to be estimated
FIXES = 8
METRE = 1 / 6.4e6  # [rad]
LATITUDE, LONGITUDE = math.radians(32.0), math.radians(118.0)

# Settings at which a corrector changes nothing.
NEUTRAL: dict[str, dict[str, Number]] = {
    "h_infinity": {"robust.gamma": 1e100},
    "igg": {"igg.k0": 1e99, "igg.k1": 1e100},
    "adaptive_factor": {"adaptive.threshold": 1e100},
    "variational_bayes": {"variational_bayes.iterations": 0},
    "huber": {"huber.k": 1e100},
    "combined": {"combined.limit": 1.0, "gate.threshold": 1e100},
}

# East, north, up errors of velocity [m/s] and position [m] of a fix, usual and gross.
size = st.floats(-3.0, 3.0) | st.floats(-300.0, 300.0)
fixes = st.lists(st.tuples(*[size] * 6), min_size=FIXES, max_size=FIXES)
examples = settings(
    max_examples=15,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@cache
def numbers(name: str, axis: str) -> dict[str, int]:
    """Items of an enumeration of a filter."""
    declaration = read(ROOT / "modelDescription" / f"{name}.toml")
    kind = next(v.type for v in declaration.variable if v.name == axis)
    return {
        item.name: declaration.enumeration[kind].value(item.name)
        for item in declaration.enumeration[kind].items
    }


def models(name: str) -> list[str]:
    return [model for model in numbers(name, "error_model") if model != "tight"]  # measures no fix


CASES = [(name, model) for name in FILTERS for model in models(name)]


def start(instance: Instance, name: str, model: str, parameters: dict[str, Number]) -> None:
    number = numbers(name, "error_model")[model]
    here = {"initial.latitude": LATITUDE, "initial.longitude": LONGITUDE, "initial.height": 0.0}
    rest = {f"initial.velocity[{i}]": 0.0 for i in (1, 2, 3)}
    instance.start(
        **{"error_model": number, **requirements(instance.fmu, number), **here, **rest, **parameters}
    )


def outputs(instance: Instance, errors: list[tuple[float, ...]]) -> list[dict[str, Number]]:
    """What a filter at rest puts out after each of several fixes, a second apart."""
    found = []
    for index, error in enumerate(errors):
        time = index + 1.0
        instance.inputs.assign(
            {
                **instance.inputs.values,
                "imu.sample": index + 1,
                "imu.time": time,
                "imu.delta_velocity[3]": GRAVITY,
                "gnss.sample": index + 1,
                "gnss.time": time,
                "gnss.latitude": LATITUDE + error[4] * METRE,
                "gnss.longitude": LONGITUDE + error[3] * METRE,
                "gnss.height": error[5],
                **{f"gnss.velocity[{i + 1}]": error[i] for i in range(3)},
            }
        )
        assert instance.inputs.write(instance) == OK
        assert instance.step(time - 1.0, 1.0) == OK, instance.journal.last
        found.append(instance.read())
    return found


def family(values: dict[str, Number], name: str) -> np.ndarray:
    return np.array([value for key, value in values.items() if key.startswith(f"{name}[")])


@pytest.mark.parametrize(("name", "model"), CASES)
@pytest.mark.parametrize("corrector", ["standard", *NEUTRAL])
@given(errors=fixes, gate=st.booleans())
@examples
def test_weights_and_covariance_are_sound(
    fmus: dict[str, Fmu],
    corrector: str,
    name: str,
    model: str,
    errors: list[tuple[float, ...]],
    gate: bool,
) -> None:
    chosen = {"corrector": numbers(name, "corrector")[corrector], "gate.enabled": gate}
    with fmus[name].instance() as instance:
        start(instance, name, model, chosen)
        for values in outputs(instance, errors):
            assert all(math.isfinite(value) for value in values.values())
            weights = family(values, "measurement_weight")
            assert weights.min() >= 0.0
            assert weights.max() <= 1.0
            covariance = family(values, "covariance").reshape(12, 12)
            np.testing.assert_array_equal(covariance, covariance.T)
            known = np.diag(covariance) > 0.0
            sigma = np.sqrt(np.diag(covariance)[known])
            correlation = covariance[np.ix_(known, known)] / np.outer(sigma, sigma)
            assert np.linalg.eigvalsh(correlation).min() > -1e-9  # rounding alone


@pytest.mark.parametrize(("name", "model"), CASES)
@pytest.mark.parametrize("corrector", list(NEUTRAL))
@given(errors=fixes)
@examples
def test_a_neutral_corrector_is_the_standard_one(
    fmus: dict[str, Fmu], name: str, model: str, corrector: str, errors: list[tuple[float, ...]]
) -> None:
    if model == "invariant":  # gross errors turn it by radians, and rounding with it
        errors = [tuple(float(np.clip(value, -3.0, 3.0)) for value in error) for error in errors]
    found = []
    for kind, parameters in (("standard", {}), (corrector, NEUTRAL[corrector])):
        chosen = {"corrector": numbers(name, "corrector")[kind], "gate.enabled": False}
        with fmus[name].instance() as instance:
            start(instance, name, model, {**chosen, **parameters})
            found.append(outputs(instance, errors))
    for standard, neutral in zip(*found, strict=True):
        report = "robust.gamma_effective"  # which of the two it was
        if model == "invariant":  # its covariance is turned to ENU and back
            one, other = (np.array([v[n] for n in standard if n != report]) for v in (neutral, standard))
            np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-9)
        else:
            assert {**neutral, report: 0.0} == {**standard, report: 0.0}
