"""Scenarios whose vehicle is somebody else's: run, compared, in campaigns; or refused in a sentence."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import sailing
import xarray as xr

import sim_scenarios
from sim_scenarios import compiled, simulation
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.provenance import attributes
from sim_scenarios.report import report_run
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master, Order
from sim_scenarios.studies.cases import cases, fingerprint
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.runs import Bench
from sim_scenarios.studies.store import State

HEAD = """
extends = "swaying_ship"
description = "A vehicle of somebody else's"
duration = 60.0
evaluation = { start = 30.0, stop = 60.0 }
"""
WAY = """
[waypoints]
places = [["32 deg", "118 deg"], ["32.004 deg", "118 deg"], ["32.004 deg", "118.01 deg", "5 m"]]
speed = "20 km/h"
turn_rate = "6 deg/s"
"""


@pytest.fixture
def folder(fmus: Fmus, tmp_path: Path) -> Path:
    """With scenarios `alone`, `file` and `way`; the file is of what the ship alone does."""
    truth = sailing.put_out(sailing.sailing(fmus), fmus)
    (tmp_path / "tracks").mkdir()
    sailing.written(sailing.columns(truth, truth["imu.time"]), tmp_path / "tracks" / "ship.csv")
    waves = f"[plant]\nmotion.wave.velocity = {sailing.WAVE[0].tolist()}\n"
    for name, text in {"alone": waves, "file": "trajectory = 'tracks/ship.csv'\n", "way": WAY}.items():
        (tmp_path / f"{name}.toml").write_text(HEAD + text, encoding="utf-8")
    return tmp_path


def test_it_runs_as_the_plant_would_alone(folder: Path, fmus: Fmus, tmp_path: Path) -> None:
    alone, driven = (
        sim_scenarios.run(folder / f"{name}.toml", seed=3, fmus=fmus) for name in ("alone", "file")
    )
    for name in ("nav.heading", "truth.latitude", "truth.velocity", "heading_sigma", "bound.heading_sigma"):
        np.testing.assert_allclose(
            driven[name].values, alone[name].values, rtol=1e-7, atol=1e-8, err_msg=name
        )
    assert np.ptp(driven["nav.heading"].values) > 0
    told = json.loads(driven.attrs["settings"])
    assert told["vehicle"]["path"] == str(folder / "tracks" / "ship.csv")
    assert told["vehicle"]["version"].startswith("sha256:")
    assert told["plant"]["motion.kind"] == "external"
    assert "motion.speed" not in told["plant"]
    assert "ship.csv" in report_run(driven, tmp_path / "report").read_text(encoding="utf-8")


def test_filters_are_compared_past_waypoints(folder: Path, fmus: Fmus) -> None:
    runs = sim_scenarios.compare(folder / "way.toml", seed=1, set={"duration": 40.0}, fmus=fmus)
    assert runs.sizes["filter"] == 6
    truth = runs.isel(filter=0)
    speed = np.linalg.norm(truth["truth.velocity"].values, axis=1)
    np.testing.assert_allclose(speed, 20 / 3.6, rtol=1e-4)
    assert json.loads(runs.attrs["settings"])["vehicle"]["speed"] == str(20 / 3.6)


@pytest.mark.parametrize("order", ["gauss-seidel", "jacobi"])
def test_no_state_is_refused_and_no_sample_late(order: str, folder: Path, fmus: Fmus) -> None:
    settings = {"duration": 20.0, "evaluation.start": 5.0, "recording_period": 1.0}
    run = sim_scenarios.run(folder / "file.toml", set=settings, order=order, fmus=fmus)
    assert not any("refused" in message for message in json.loads(run.attrs["messages"]))
    assert run.sizes["fix"] == (20 if order == "gauss-seidel" else 19)


def test_a_campaign_goes_through_it(folder: Path, fmus: Fmus) -> None:
    plan = load_plan(folder / "file.toml", runs=2, set={"duration": 31.0}, filters=("UKF",))
    [case] = cases(plan, fmus)
    bench = Bench(1.0, Master.auto, fmus)
    outcome = bench.run(case, 1, attributes(case.scenario, fmus))
    assert (outcome.state, outcome.failure) == ({"UKF": State.finished}, "")
    before = fingerprint(plan, [case], {})
    path = folder / "tracks" / "ship.csv"
    path.write_text(path.read_text() + "\n")
    assert fingerprint(plan, cases(plan, fmus), {}) != before


def test_nothing_is_drawn_in_vain(folder: Path, fmus: Fmus) -> None:
    drawn = {"motion.speed": {"uniform": [1.0, 5.0]}}
    plan = load_plan(folder / "way.toml", runs=2, draw=drawn)
    with pytest.raises(InputError, match=r"draw: motion\.speed has no effect: way has a vehicle of its own"):
        cases(plan, fmus)
    [case] = cases(load_plan(folder / "way.toml", draw={"gnss.rate": {"uniform": [1.0, 5.0]}}), fmus)
    assert len(case.draws) == 1


@pytest.mark.parametrize("order", Order)
def test_a_compiled_loop_tells_what_python_tells(folder: Path, fmus: Fmus, order: Order) -> None:
    scenario = load_scenario(folder / "way.toml", fmus)
    python, loop = (
        simulation.simulated(scenario, fmus, {"UKF": scenario.filter}, order, master=master)[0]
        for master in (Master.python, Master.compiled)
    )
    assert len(loop.time) > 2 * compiled.GIVEN * scenario.communication_step / scenario.recording_period
    for name, values in python.filters[0].items():
        np.testing.assert_array_equal(loop.filters[0][name], values, err_msg=name)


def test_what_extends_a_driven_scenario(folder: Path, fmus: Fmus) -> None:
    """Another vehicle takes the place of that of the file below; part of the waypoints may differ."""
    for name, below, text in (
        ("faster", "way", "waypoints.speed = 6.0"),
        ("other", "way", "trajectory = 'tracks/ship.csv'"),
    ):
        (folder / f"{name}.toml").write_text(f'extends = "{folder}/{below}"\n{text}\n', encoding="utf-8")
    faster, other = (load_scenario(folder / f"{name}.toml", fmus) for name in ("faster", "other"))
    assert faster.waypoints is not None
    assert (faster.waypoints.speed, len(faster.waypoints.places)) == (6.0, 3)
    assert other.waypoints is None
    assert other.trajectory is not None


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"motion.speed": 3.0}, "the setting motion.speed: has no effect: trajectory says how"),
        ({"duration": 60.5}, "duration = 60.5 s: must be at most 60 s, when the trajectory ends"),
        ({"trajectory": "none.csv"}, "trajectory: there is no file none.csv"),
        ({"trajectory": ""}, "trajectory: there is no file "),
        ({"waypoints.speed": 3.0}, "waypoints.places: field required"),
    ],
)
def test_settings_that_do_not_go_with_a_file(
    settings: dict[str, object], says: str, folder: Path, fmus: Fmus
) -> None:
    with pytest.raises(InputError, match=says):
        load_scenario(folder / "file.toml", fmus, settings=settings)


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"trajectory": "tracks/ship.csv"}, "trajectory and waypoints: there must be one of them alone"),
        ({"waypoints.speed": "-3 m/s"}, "waypoints.speed: -3: must be greater than 0"),
        ({"waypoints.speed": "3 deg"}, "waypoints.speed: '3 deg' is not in a unit of"),
        ({"waypoints.places": [["32 deg", "118 deg"]]}, "waypoints.places: .* at least 2"),
        (
            {"waypoints.places": [["91 deg", "118 deg"], ["32 deg", "118 deg"]]},
            "must be at most 89.95 either way",
        ),
        ({"waypoints.turn_rate": "0.05 deg/s"}, "that the turns at them take; go slower"),
        ({"waypoints.bank": 1.0}, "waypoints.bank: there is no such entry"),
        ({"duration": 500.0}, "duration = 500 s: must be at most .* s, when the way past the waypoints ends"),
    ],
)
def test_settings_that_do_not_go_with_waypoints(
    settings: dict[str, object], says: str, folder: Path, fmus: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(InputError, match=says):
        load_scenario(folder / "way.toml", fmus, settings=settings)


def test_an_external_motion_without_vehicle(fmus: Fmus) -> None:
    with pytest.raises(InputError, match=r"plant\.motion\.kind = external: needs a trajectory or waypoints"):
        load_scenario("swaying_ship", fmus, settings={"motion.kind": "external"})


def test_the_bound_of_a_driven_vehicle_has_no_manoeuvres_left_out(folder: Path, fmus: Fmus) -> None:
    data: xr.Dataset = sim_scenarios.bound(folder / "way.toml", fmus=fmus)
    assert np.isfinite(data.attrs["bound.heading_rms"])
    assert "bound.heading_rms_steady" not in data.attrs
