"""The compiled loop against the Python master: the same results to the last bit, the same sentences."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from ctypes import CFUNCTYPE, c_double, c_int, c_size_t, c_void_p
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import compiled, connection, cosimulation, provenance, simulation
from sim_scenarios.compiled import Loop
from sim_scenarios.cosimulation import Sink
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.replay import replay
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.tables import ImuTable, Recording
from sim_scenarios.recordings.zero_velocity import ZeroVelocity
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master, Order
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.runs import Bench
from sim_scenarios.studies.store import State

SHORT = {"duration": 45.0, "evaluation.start": 20.0, "evaluation.stop": 45.0}
BOTH = (Master.python, Master.compiled)


def same(
    fmus: Fmus,
    name: str,
    settings: Mapping[str, object],
    order: Order = Order.gauss_seidel,
    added: Mapping[str, np.ndarray] | None = None,
) -> xr.Dataset:
    """A run by both masters: all that is recorded and said is the same; by the loop."""
    scenario = load_scenario(name, fmus, seed=5, settings={**SHORT, **settings}, running=None)
    filters = scenario.filters()
    by_python, by_loop = (
        simulation.simulated(scenario, fmus, filters, order, added=added, master=master) for master in BOTH
    )
    assert list(map(str, by_loop[1])) == list(map(str, by_python[1]))
    data, expected = (
        simulation.dataset(one, scenario, fmus, list(filters)) for one, _ in (by_loop, by_python)
    )
    assert data.identical(expected)
    assert np.isfinite(data["nav.heading"]).all()
    return data


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("swaying_ship", {"duration": 600.0, "evaluation.start": 300.0, "evaluation.stop": 600.0}),
        ("gnss_outliers", {"gnss.rate": 10.0}),  # a fix at every recorded instant
        ("waves", {"gnss.latency": 0.35, "plant.gnss.lever_arm": [0.5, 2.0, 8.0]}),
        ("flight_loose_tight", {}),  # the NavigationFilter, with its Boolean signals
        ("parked_vehicle", {"communication_step": 0.02, "recording_period": 0.2}),
        ("zigzag", {"fault.imu.kind": "silence", "fault.imu.begin": 25.0, "fault.imu.duration": 2.0}),
        ("align_then_navigate", {}),  # an alignment that is handed over
    ],
)
@pytest.mark.parametrize("order", Order)
def test_the_loop_gives_the_results_of_the_python_master(
    fmus: Fmus, scenario: str, settings: dict[str, object], order: Order
) -> None:
    same(fmus, scenario, settings, order)


def test_the_name_of_the_function_counts_the_changes_of_its_structs() -> None:
    """A library of another version would read them wrongly: with a new hash comes the next number."""
    text = (Path(__file__).parents[2] / "fmu_src" / "runner" / "loop.hpp").read_text(encoding="utf-8")
    found = "".join(re.findall(r"^(?:struct|enum class) .*?^\};", text, re.MULTILINE | re.DOTALL))
    assert all(name in found for name in ("Kind", "When", "Operation", "Loop"))
    words = " ".join(re.sub("//.*", "", found).split())
    digest = hashlib.sha256(words.encode()).hexdigest()[:16]
    assert (compiled._FUNCTION, digest) == ("truenorth_run_2", "464208b44d817972")


def test_several_fixes_in_a_period_and_steps_behind_the_last_row(fmus: Fmus) -> None:
    data = same(fmus, "waves", {"gnss.rate": 20.0, "recording_period": 0.7})
    assert data.sizes == {**data.sizes, "time": 65, "fix": 900}
    assert float(data["time"][-1]) == pytest.approx(44.8)


def test_what_is_added_begins_anew_behind_its_end(fmus: Fmus) -> None:
    added = {"imu.delta_angle[1]": 1e-9 * np.arange(7.0), "imu.delta_velocity[2]": 1e-7 * np.arange(1301.0)}
    same(fmus, "swaying_ship", {}, added=added)


@pytest.mark.parametrize("task", Filter)
def test_a_recording_is_replayed_to_the_same_bits(
    fmus: Fmus, monkeypatch: pytest.MonkeyPatch, task: Filter
) -> None:
    """At rest, with a clock that wanders; the steps are as long as the samples."""
    noise = np.random.default_rng(1).standard_normal((3, 6001, 3))
    time = 0.01 * np.arange(1, 6002) + 1e-4 * noise[2, :, 0]
    imu = ImuTable(time, 1e-6 * noise[0], np.array([0.0, 0.0, 0.098]) + 1e-4 * noise[1])
    aiding = ZeroVelocity((45.0, 10.0, 0.0))

    def replayed(by: Master) -> xr.Dataset:
        monkeypatch.setattr(compiled, "steps", lambda _: by is Master.compiled)
        return replay(Recording("rest", imu), Start(0.0), filter=task, zero_velocity=aiding, fmus=fmus)

    python, loop = map(replayed, BOTH)
    assert python.sizes["time"] > 500
    assert python.sizes["fix"] > 10 or task is Filter.align_then_navigate  # whose minute is too short
    assert loop.identical(python)


@pytest.mark.parametrize("master", BOTH)
def test_a_campaign_keeps_the_same(fmus: Fmus, master: Master) -> None:
    (case,) = cases(load_plan("swaying_ship", set=SHORT), fmus)
    attributes = provenance.attributes(case.scenario, fmus)
    outcome = Bench(1.0, master, fmus).run(case, 5, attributes)
    assert set(outcome.state.values()) == {State.finished}
    whole = sim_scenarios.compare("swaying_ship", seed=5, set=SHORT, fmus=fmus)
    heading = whole["heading_error"].sel(filter="UKF").values[::10]
    np.testing.assert_array_equal(outcome.kept["UKF"]["heading_error"], np.abs(heading))


@pytest.mark.parametrize("master", BOTH)
def test_an_fmu_that_stops_says_when_and_why(fmus: Fmus, master: Master) -> None:
    settings = {**SHORT, "communication_step": 0.015, "recording_period": 0.15}
    scenario = load_scenario("swaying_ship", fmus, settings=settings)
    with pytest.raises(SimulationError, match=r"^plant \(TruthPlant\) failed in the step from 0 s: .*0\.015"):
        simulation.simulated(scenario, fmus, {"one": scenario.filter}, master=master)


STEP = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_int)
ACCESS = CFUNCTYPE(c_int, c_void_p, c_void_p, c_size_t, c_void_p)


@pytest.mark.parametrize("master", BOTH)
def test_a_filter_that_stops_under_way_says_when_and_in_what(fmus: Fmus, master: Master) -> None:
    """In the second turn of the loop; stand-ins for functions of the FMU refuse."""
    scenario = load_scenario("swaying_ship", fmus, settings=SHORT)
    filters = {"one": scenario.filter, "other": scenario.filter}
    accessed = count()

    def failure(refused: Callable[[Sink], None]) -> str:
        with ExitStack() as stack:
            source, sinks = connection.connect(scenario, fmus, filters, stack)
            refused(sinks[1])
            with pytest.raises(SimulationError) as told:
                connection.record(scenario, fmus, source, sinks, master=master)
        return str(told.value)

    def step(sink: Sink) -> None:
        sink.instance.do_step = STEP(lambda _, time, __, ___: 3 if time > 12.3 else 0)

    def access(sink: Sink) -> None:
        (_, imu, *call), *others = sink.port.setters
        refuse = ACCESS(lambda _, which, *__: 2 if which == imu and next(accessed) == 1500 else 0)
        sink.port.setters = [(refuse, imu, *call), *others]

    told = "other (AlignmentFilter) failed in {}: it gives no reason"
    assert failure(step) == told.format("the step from 12.31 s")
    assert failure(access) == told.format("setting imu.sample, imu.time, imu.delta_angle[1] ...")
    assert next(accessed) == 1501


def test_a_run_is_interrupted_between_steps(fmus: Fmus) -> None:
    shares: list[float] = []

    def interrupt(share: float) -> None:
        shares.append(share)
        if len(shares) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sim_scenarios.run("swaying_ship", progress=interrupt, fmus=fmus)
    assert shares == [compiled.AT_ONCE / 60_000, 2 * compiled.AT_ONCE / 60_000]
    again = sim_scenarios.run("swaying_ship", set=SHORT, fmus=fmus)
    assert again.identical(sim_scenarios.run("swaying_ship", set=SHORT, fmus=fmus))


def test_without_a_library_python_steps(fmus: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "own_folders", lambda: [tmp_path])
    compiled._library.cache_clear()
    try:
        monkeypatch.setattr(Loop, "run", None)
        run = sim_scenarios.run("waves", set=SHORT, fmus=fmus)
        assert run.sizes["time"] == 451
        for call in (
            lambda: sim_scenarios.campaign("waves", tmp_path, master="compiled", fmus=fmus),
            lambda: compiled.steps(Master.compiled),
        ):
            with pytest.raises(
                InputError, match=r"^master = compiled: there is no compiled loop for \w+ on "
            ):
                call()
        assert list(tmp_path.iterdir()) == []
    finally:
        compiled._library.cache_clear()


def test_a_library_of_another_version_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "own_folders", lambda: [tmp_path])
    monkeypatch.setattr(compiled, "_FUNCTION", "truenorth_run_0")
    compiled._library.cache_clear()
    try:
        assert not compiled.steps(Master.auto)
    finally:
        compiled._library.cache_clear()


def test_a_source_that_only_python_steps(fmus: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    """A live view sees every row."""
    monkeypatch.setattr(cosimulation, "Loop", None)
    seen: list[float] = []
    sim_scenarios.run("waves", set=SHORT, watch=lambda *_: seen.append, fmus=fmus)
    assert len(seen) == 450
