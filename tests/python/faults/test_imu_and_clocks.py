"""Faults of an IMU and of clocks on the wire to an AlignmentFilter: what it says, and that it comes back.

On the swaying ship with waves, where the heading can be found within the run; the fault comes at 400 s, when
the filter has converged.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from wire import STATUS, Fault, Wire, run

from sim_scenarios.fmus import Fmus
from sim_scenarios.stepping import Order

BEGIN = 400.0
MODELS: dict[str, dict[str, str]] = {
    "large_azimuth": {},
    "invariant": {"error_model": "invariant", "predictor": "linearised", "corrector": "standard"},
}

Maker = Callable[[], Fault]


@pytest.fixture(params=list(MODELS))
def model(request: pytest.FixtureRequest) -> dict[str, str]:
    return MODELS[request.param]


def wrongly_sure(data: xr.Dataset) -> np.ndarray:
    """Rows with `converged` and an error of heading or velocity beyond 3 sigma, shape (rows,)."""
    heading = np.abs(data["heading_error"].values) > 3 * data["heading_sigma"].values
    velocity = np.abs(data["velocity_error"].values) > 3 * np.maximum(data["velocity_sigma"].values, 1e-9)
    horizontal = velocity[:, :2].any(axis=1)
    return np.asarray(data["converged"].values & (heading | horizontal))


def longest(rows: np.ndarray, period: float) -> float:
    """Longest stretch of true rows [s]."""
    best = run_length = 0
    for row in rows:
        run_length = run_length + 1 if row else 0
        best = max(best, run_length)
    return best * period


def ends_right(data: xr.Dataset) -> bool:
    end = data.isel(time=-1)
    return bool(abs(float(end["heading_error"])) < 3 * float(end["heading_sigma"]))


def sound(data: xr.Dataset, stretch: float = 10.0) -> None:
    assert longest(wrongly_sure(data), 0.1) <= stretch
    assert ends_right(data)


def between(data: xr.Dataset, start: float, stop: float) -> xr.Dataset:
    return data.sel(time=slice(start, stop))


def silence(stop: float = np.inf) -> Fault:
    last: dict[str, float] = {}

    def fault(time: float, wire: Wire) -> None:
        if time <= BEGIN:
            last.update(wire.imu())
        elif time <= stop:
            wire.restore(last)

    return fault


def nans(stop: float = np.inf) -> Fault:
    def fault(time: float, wire: Wire) -> None:
        if BEGIN < time <= stop:
            wire.put("imu.delta_angle", np.full(3, np.nan))

    return fault


@pytest.mark.parametrize("fault", [silence, nans])
def test_a_silent_imu_is_told_within_seconds_and_nothing_is_converged(
    fault: Callable[[], Fault], model: dict[str, str], fmus: Fmus
) -> None:
    data = run("waves", fmus, fault(), settings=model)
    assert data["converged"].sel(time=BEGIN, method="nearest")
    late = between(data, BEGIN + 2.0, 600.0)
    assert not late["converged"].any()
    assert (late["status"] == STATUS["silent"]).all()
    assert float(data["imu.silent_for"][-1]) == pytest.approx(600.0 - BEGIN, abs=0.1)


@pytest.mark.parametrize("fault", [silence, nans])
@pytest.mark.parametrize("seconds", [1.0, 5.0, 8.6, 20.0])
def test_after_silence_the_filter_is_right_again(
    fault: Callable[[float], Fault], seconds: float, model: dict[str, str], fmus: Fmus
) -> None:
    data = run("waves", fmus, fault(BEGIN + seconds), settings={**model, "duration": 800.0})
    sound(data)
    assert data["converged"][-1]


@pytest.mark.parametrize("kind", ["silence", "not_a_number", "zeros"])
@pytest.mark.parametrize("seed", [2, 5])
def test_fixes_that_came_in_a_long_gap_teach_nothing(kind: str, seed: int, fmus: Fmus) -> None:
    """Samples that were refused are as lost as those that never came.

    A ship rolls by 7 deg, so that 8.6 s leave the tilt as wrong as that: the velocity runs away until the
    first fix after the gap, and the filter may not take the next ones for outliers.
    """
    settings = {
        **MODELS["invariant"],
        "fault.imu.kind": kind,
        "fault.imu.begin": 343.2,
        "fault.imu.duration": 8.6,
        "duration": 600.0,
    }
    data = run("swaying_ship", fmus, lambda _, __: None, seed=seed, settings=settings)
    sound(data)
    after = between(data, 343.2 + 8.6 + 10.0, 600.0)
    assert float(np.abs(after["velocity_error"].values[:, :2]).max()) < 1.0
    assert float(np.degrees(np.abs(after["nav.roll"].values - after["truth.roll"].values).max())) < 1.0


def count_jump(n: int) -> Fault:
    def fault(time: float, wire: Wire) -> None:
        if time > BEGIN:
            wire["imu.sample"] += n

    return fault


@pytest.mark.parametrize("n", [10, 100, 1000, 10**9])
def test_a_count_that_jumps_multiplies_no_increment(n: int, model: dict[str, str], fmus: Fmus) -> None:
    clean = run("waves", fmus, lambda _, __: None, settings=model)
    data = run("waves", fmus, count_jump(n), settings=model)
    assert float(data["heading_error"][-1]) == pytest.approx(float(clean["heading_error"][-1]), abs=1e-9)
    assert int(data["clock_disagreements"][-1]) == 1
    assert any("imu.sample leapt" in text for text in data.attrs["messages"])
    sound(data)


def raw_count(_: float, wire: Wire) -> None:
    wire["imu.sample"] *= 10


def test_a_count_of_raw_samples_is_learned(model: dict[str, str], fmus: Fmus) -> None:
    settings = {**model, "communication_step": 0.1}
    clean = run("waves", fmus, lambda _, __: None, settings=settings)
    data = run("waves", fmus, raw_count, settings=settings)
    assert float(data["heading_error"][-1]) == pytest.approx(float(clean["heading_error"][-1]), abs=1e-6)
    sound(data)


def clock_step(size: float, *, gnss: bool) -> Fault:
    def fault(time: float, wire: Wire) -> None:
        if time > BEGIN:
            wire["imu.time"] += size
            if gnss and wire["gnss.time"] > BEGIN:
                wire["gnss.time"] += size

    return fault


@pytest.mark.parametrize("order", [Order.gauss_seidel, Order.jacobi])
@pytest.mark.parametrize("gnss", [False, True], ids=["IMU alone", "together"])
@pytest.mark.parametrize("size", [1.0, -0.5, -20.0, 86400.0])
def test_a_clock_that_is_set_costs_nothing(
    size: float, gnss: bool, order: Order, model: dict[str, str], fmus: Fmus
) -> None:
    clean = run("waves", fmus, lambda _, __: None, settings=model, order=order)
    data = run("waves", fmus, clock_step(size, gnss=gnss), settings=model, order=order)
    assert float(data["heading_error"][-1]) == pytest.approx(float(clean["heading_error"][-1]), abs=1e-6)
    assert int(data["used_fixes"][-1]) >= int(clean["used_fixes"][-1]) - 3
    assert int(data["clock_disagreements"][-1]) >= 1
    assert (between(data, BEGIN + 0.2, BEGIN + 4.0)["status"] == STATUS["suspect"]).all()
    sound(data)


def receiver_clock_step(size: float) -> Fault:
    def fault(_: float, wire: Wire) -> None:
        if wire["gnss.time"] > BEGIN:
            wire["gnss.time"] += size

    return fault


@pytest.mark.parametrize("size", [1.0, -20.0, 3600.0, -3600.0])
def test_a_receiver_whose_clock_is_set_is_believed_again(
    size: float, model: dict[str, str], fmus: Fmus
) -> None:
    data = run("waves", fmus, receiver_clock_step(size), settings=model)
    assert int(data["rejected_fixes"][-1]) <= 3
    sound(data)


def spike(name: str, size: float, axis: int) -> Fault:
    def fault(time: float, wire: Wire) -> None:
        if abs(time - BEGIN - 0.5) < 1e-6:
            wire[f"imu.{name}[{axis}]"] += size

    return fault


@pytest.mark.parametrize("axis", [1, 2, 3])
@pytest.mark.parametrize(("name", "size"), [("delta_velocity", 1.0), ("delta_angle", 0.3)])
def test_one_wild_sample_is_doubted(
    name: str, size: float, axis: int, model: dict[str, str], fmus: Fmus
) -> None:
    data = run("waves", fmus, spike(name, size, axis), settings={**model, "duration": 800.0})
    sound(data, stretch=1.0)
    assert data["converged"][-1]


def zeros(seconds: float) -> Fault:
    def fault(time: float, wire: Wire) -> None:
        if BEGIN < time <= BEGIN + seconds:
            wire.put("imu.delta_angle", np.zeros(3))
            wire.put("imu.delta_velocity", np.zeros(3))

    return fault


@pytest.mark.parametrize("patience", [5, 20])
@pytest.mark.parametrize("seconds", [0.1, 4.0])
def test_zeros_are_no_measurement(seconds: float, patience: int, model: dict[str, str], fmus: Fmus) -> None:
    settings = {**model, "gate.patience": patience, "duration": 800.0}
    data = run("waves", fmus, zeros(seconds), settings=settings)
    sound(data)
    assert data["converged"][-1]
    assert float(np.abs(data["velocity_error"].values[:, :2]).max()) < 30.0


def rates(_: float, wire: Wire) -> None:
    wire.put("imu.delta_angle", 100.0 * wire.vector("imu.delta_angle"))
    wire.put("imu.delta_velocity", 100.0 * wire.vector("imu.delta_velocity"))


def test_rates_in_place_of_increments_are_named(model: dict[str, str], fmus: Fmus) -> None:
    data = run("waves", fmus, rates, settings={**model, "duration": 60.0, "evaluation.start": 30.0})
    assert not data["converged"].any()
    assert float(np.abs(data["velocity_error"].values).max()) < 50.0
    messages = [text for text in data.attrs["messages"] if "must be increments" in text]
    assert 1 <= len(messages) <= 3


def test_twenty_thousand_bad_samples_are_a_few_lines(model: dict[str, str], fmus: Fmus) -> None:
    data = run("waves", fmus, nans(), settings=model)
    told = [text for text in data.attrs["messages"] if "IMU sample" in text]
    assert 2 <= len(told) <= 6
    assert any("more before" in text for text in told)
    assert int(data["rejected_samples"][-1]) == pytest.approx((600.0 - BEGIN) * 100, abs=2)


def late_fix(_: float, wire: Wire) -> None:
    wire["gnss.time"] += 0.003 if wire["gnss.sample"] else 0.0


def test_a_fix_a_little_younger_than_the_imu_data_waits(model: dict[str, str], fmus: Fmus) -> None:
    settings = {**model, "imu.rate": 20.0, "communication_step": 0.05}
    data = run("waves", fmus, late_fix, settings=settings)
    assert int(data["rejected_fixes"][-1]) == 0
    assert int(data["used_fixes"][-1]) >= 598
    sound(data)


def frozen(_: float, wire: Wire) -> None:
    if wire["gnss.time"] > BEGIN:
        wire["gnss.latitude"], wire["gnss.longitude"], wire["gnss.height"] = 0.55, 2.05, 3.0
        wire.put("gnss.velocity", np.array([0.1, 9.9, 0.0]))


def test_a_receiver_that_hangs_is_told(model: dict[str, str], fmus: Fmus) -> None:
    data = run("waves", fmus, frozen, settings=model)
    assert any("the receiver hangs" in text for text in data.attrs["messages"])
    assert not between(data, BEGIN + 10.0, 600.0)["converged"].any()


@pytest.mark.parametrize("kind", ["repeated", "reordered"])
def test_fixes_are_used_although_every_other_sample_is_no_use(kind: str, fmus: Fmus) -> None:
    settings = {
        "fault.imu.kind": kind,
        "fault.imu.begin": 20.0,
        "fault.imu.duration": 20.0,
        "duration": 60.0,
        "evaluation.start": 30.0,
        "evaluation.stop": 60.0,
    }
    data = run("swaying_ship", fmus, lambda _, __: None, settings=settings)
    assert int(data["missed_samples"][-1] + data["rejected_samples"][-1]) > 500
    assert int(data["used_fixes"][-1]) >= 58
    assert not np.any(data["status"].values == STATUS["coasting"])


@pytest.mark.parametrize("kind", ["repeated", "reordered"])
@pytest.mark.parametrize("seed", [1, 4])
def test_gaps_of_a_sample_do_not_add_up(kind: str, seed: int, model: dict[str, str], fmus: Fmus) -> None:
    """Half of the samples of 4 s are lost: what is put in their place is off one way or the other."""
    settings = {
        **model,
        "fault.imu.kind": kind,
        "fault.imu.begin": 306.9,
        "fault.imu.duration": 4.4,
        "duration": 600.0,
    }
    data = run("swaying_ship", fmus, lambda _, __: None, seed=seed, settings=settings)
    sound(data)
