"""Model exchange: time events at the sample period give the results of co-simulation, bit for bit."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import byref, c_double, c_int, c_size_t

import fmpy
import numpy as np
import pytest
from archives import FILTERS, FMUS, STEP
from calls import ERROR, MODEL_EXCHANGE, OK, Fmu, Instance, Number

STEPS = 1000


class EventInfo(ctypes.Structure):
    """`fmi2EventInfo`."""

    _fields_ = (
        ("again", c_int),
        ("terminate", c_int),
        ("nominals_changed", c_int),
        ("values_changed", c_int),
        ("next_defined", c_int),
        ("next", c_double),
    )


class Exchanged:
    """An instance for model exchange, as a tool with a solver of its own drives it."""

    def __init__(self, fmu: Fmu, start: float = 0.0, **parameters: Number) -> None:
        self.instance = Instance(fmu, logging=True, kind=MODEL_EXCHANGE)
        self.instance.start(start, **parameters)
        self.next_event = self.update()
        self.call("fmi2EnterContinuousTimeMode")

    def call(self, function: str, *arguments: object) -> None:
        assert self.instance.call(function, *arguments) == OK, self.instance.journal.last

    def update(self) -> float:
        info = EventInfo()
        self.call("fmi2NewDiscreteStates", byref(info))
        assert not info.again
        assert info.next_defined
        return float(info.next)

    def enter_event(self, time: float) -> None:
        """Integrate there, trying one time beyond the middle on the way, as solvers do."""
        for at in (time - 0.4 * STEP, time - 0.6 * STEP, time):
            self.call("fmi2SetTime", c_double(at))
            self.call("fmi2GetDerivatives", None, c_size_t(0))
        self.call("fmi2EnterEventMode")

    def feed(self, values: dict[str, Number]) -> None:
        self.instance.inputs.assign(values)
        assert self.instance.inputs.write(self.instance) == OK, self.instance.journal.last

    def leave_event(self) -> None:
        self.next_event = self.update()
        self.call("fmi2EnterContinuousTimeMode")


def plant_first(plant: Exchanged, filter_: Exchanged) -> None:
    plant.update()
    filter_.feed(plant.instance.read())
    filter_.update()


def filter_first(plant: Exchanged, filter_: Exchanged) -> None:
    """The filter sees the new sample only when the event is iterated."""
    filter_.update()
    plant.update()
    filter_.feed(plant.instance.read())


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("order", [plant_first, filter_first])
def test_plant_and_filter_as_in_co_simulation(
    fmus: dict[str, Fmu], name: str, order: Callable[[Exchanged, Exchanged], None]
) -> None:
    plant, filter_ = Exchanged(fmus["TruthPlant"]), Exchanged(fmus[name])
    with fmus["TruthPlant"].instance() as source, fmus[name].instance() as sink:
        source.start()
        sink.start()
        for index in range(STEPS):
            time = plant.next_event
            for model in (plant, filter_):
                model.enter_event(time)
            order(plant, filter_)
            for model in (plant, filter_):
                model.leave_event()
            assert source.step(index * STEP, STEP) == OK
            sink.inputs.assign(source.read())
            assert sink.inputs.write(sink) == OK
            assert sink.step(index * STEP, STEP) == OK
            assert plant.instance.read() == source.read(), f"step {index}"
            assert sink.outputs.read(sink) == OK
            assert filter_.instance.outputs.read(filter_.instance) == OK
            # What the clock of the master tells is as exact as its sum of steps.
            np.testing.assert_allclose(
                list(filter_.instance.read().values()), list(sink.read().values()), rtol=0, atol=1e-12
            )
    for model in (plant, filter_):
        model.instance.terminate()
        model.instance.free()


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_fmpy_samples_at_the_right_instants(version: str) -> None:
    """FMPy's own solver, whose output interval is no multiple of the sample period."""
    archive = str((FMUS if version == "fmi2" else FMUS / "fmi3") / "TruthPlant.fmu")
    shared = {"stop_time": 1.0, "output": ["imu.sample", "imu.time", "truth.heading"]}
    exchanged = fmpy.simulate_fmu(
        archive, fmi_type="ModelExchange", output_interval=0.025, record_events=False, **shared
    )
    stepped = fmpy.simulate_fmu(archive, fmi_type="CoSimulation", output_interval=STEP, **shared)
    indices = np.floor(exchanged["time"] / STEP + 1e-6).astype(int)
    assert len(exchanged) == 41
    for name in shared["output"]:
        assert np.array_equal(exchanged[name], stepped[name][indices])


def test_a_missed_event_is_refused_with_a_sentence(fmus: dict[str, Fmu]) -> None:
    plant = Exchanged(fmus["TruthPlant"])
    plant.call("fmi2SetTime", c_double(0.05))
    plant.call("fmi2EnterEventMode")
    assert plant.instance.call("fmi2NewDiscreteStates", byref(EventInfo())) == ERROR
    assert "the time event at 0.01 s was missed" in plant.instance.journal.last
    plant.instance.free()


def test_the_event_is_announced_to_who_looks_only_at_completed_steps(fmu: Fmu) -> None:
    model = Exchanged(fmu)
    for time, expected in ((0.5 * STEP, 0), (STEP, 1)):
        enter, terminate = c_int(), c_int()
        model.call("fmi2SetTime", c_double(time))
        model.call("fmi2CompletedIntegratorStep", 1, byref(enter), byref(terminate))
        assert (enter.value, terminate.value) == (expected, 0)
    model.instance.free()


def test_the_two_kinds_do_not_mix(fmu: Fmu) -> None:
    model = Exchanged(fmu)
    assert model.instance.step(0.0, STEP) == ERROR
    assert "not allowed in the phase 'continuous-time mode'" in model.instance.journal.last
    model.call("fmi2SetTime", c_double(STEP))
    assert model.instance.call("fmi2SetTime", c_double(-1.0)) == ERROR
    assert "must not be before the last time event" in model.instance.journal.last
    state = model.instance.serialise()
    with fmu.instance() as stepping:
        assert stepping.deserialise(state)[0] == ERROR
        assert "one of an instance for model exchange; this is one for co-simulation" in stepping.journal.last
    model.instance.free()


def test_a_state_leads_back(fmu: Fmu, signals: list[dict[str, Number]]) -> None:
    model = Exchanged(fmu)

    def go(first: int, last: int) -> bytes:
        for index in range(first, last):
            model.enter_event((index + 1) * STEP)
            model.feed(signals[index])
            model.leave_event()
        assert model.instance.outputs.read(model.instance) == OK
        return model.instance.outputs.bytes

    go(0, 150)
    state = model.instance.save()
    once = go(150, 300)
    assert model.instance.restore(state) == OK
    assert go(150, 300) == once
    model.instance.free()


@pytest.mark.parametrize("stamped", [True, False])
def test_a_vehicle_of_somebody_else_is_followed(fmus: dict[str, Fmu], stamped: bool) -> None:
    """With its stamp at once; without one its state is taken for that of a period before."""

    def vehicle(time: float) -> dict[str, Number]:
        """North at 5 m/s and turning."""
        values: dict[str, Number] = {f"external.velocity[{i}]": 5.0 * (i == 2) for i in (1, 2, 3)}
        values |= {f"external.attitude[{i}]": 0.1 * time * (i == 3) for i in (1, 2, 3)}
        return values | {
            "external.position[1]": 0.5 + 5.0 * time / 6.35e6,
            "external.position[2]": 1.0,
            "external.position[3]": 0.0,
        }

    model = Exchanged(fmus["TruthPlant"], **{"motion.kind": 4, **vehicle(0.0)})
    early = 0 if stamped else 1
    for index in range(1, 50):
        time = model.next_event
        model.enter_event(time)
        model.feed({**vehicle(time), **({"external.time": time} if stamped else {})})
        model.leave_event()
        outputs = model.instance.read()
        assert outputs["imu.sample"] == index - early
        assert outputs["truth.time"] == pytest.approx((index - early) * STEP, abs=1e-12)
        if index > early:
            assert outputs["truth.heading"] == pytest.approx(0.1 * time, abs=1e-12)
        assert outputs["external.rejected"] == 0
    model.instance.terminate()
    model.instance.free()
