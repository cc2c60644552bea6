"""An exported scenario whose vehicle is somebody else's: Playback moves the plant, in any tool."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

import importer_table
import numpy as np
import pytest
from archives import FMUS
from fmpy.ssp.simulation import simulate_ssp
from numpy.typing import NDArray
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.cosimulation import Recorded, simulate
from sim_scenarios.exchange import reference as reference_results
from sim_scenarios.exchange.driven import with_vehicle
from sim_scenarios.exchange.system import of_scenario
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.instance import Instance
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import Master, Order
from sim_scenarios.vehicles import Vehicle

SCENARIO = """
extends = "swaying_ship"
description = "Round a buoy"
duration = 60.0
evaluation = { start = 30.0, stop = 60.0 }

[waypoints]
places = [["32 deg", "118 deg"], ["32.003 deg", "118 deg"], ["32.003 deg", "118.01 deg"]]
speed = 10.0
turn_rate = "6 deg/s"

[plant]
imu.gyro.white_noise = 0.0
imu.accelerometer.white_noise = 0.0
"""
STEP = 0.1


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("driven")
    (place / "buoy.toml").write_text(SCENARIO)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRUENORTH_FMUS", str(FMUS))
        result = CliRunner().invoke(app, ["export", str(place / "buoy.toml"), "--output", str(place / "out")])
    assert result.exit_code == 0, result.output
    return place / "out"


@pytest.fixture(scope="module")
def vehicle(folder: Path) -> Vehicle:
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    moving = load_scenario(folder.parent / "buoy.toml", fmus).vehicle()
    assert moving is not None
    return moving


def reference(folder: Path, name: str, kind: str = "ref") -> NDArray[np.void]:
    return importer_table.read_csv(folder / "reference" / f"{name}_{kind}.csv")


def test_the_plant_goes_where_the_vehicle_is(folder: Path, vehicle: Vehicle) -> None:
    """One step late, as all components step at once."""
    shown = reference(folder, "TruthPlant")
    late = np.maximum(shown["time"] - STEP, 0.0)
    states = vehicle.states(late)
    for name, column in (("latitude", 1), ("longitude", 2), ("velocity[1]", 4), ("velocity[2]", 5)):
        np.testing.assert_allclose(shown[f"truth.{name}"], states[:, column], rtol=1e-13, atol=1e-9)
    assert np.ptp(shown["truth.velocity[1]"]) == pytest.approx(10, rel=1e-3)  # it has turned
    np.testing.assert_allclose(shown["imu.time"], late, atol=1e-9)
    told = reference(folder, "TruthPlant", "in")
    np.testing.assert_allclose(told["external.time"], told["time"], atol=1e-9)
    np.testing.assert_array_equal(told["external.position[1]"], vehicle.states(told["time"])[:, 1])


def test_the_filter_takes_it_for_a_ship(folder: Path, vehicle: Vehicle) -> None:
    estimates = reference(folder, "AlignmentFilter")
    assert estimates["nav.time"][-1] == pytest.approx(60 - 2 * STEP, abs=1e-9)
    heading = vehicle.states(np.array([60 - 2 * STEP]))[0, 9]
    off = (estimates["nav.heading"][-1] - heading + np.pi) % (2 * np.pi) - np.pi
    assert abs(off) < 3 * estimates["heading_sigma"][-1]
    assert estimates["used_fixes"][-1] > 50
    assert estimates["rejected_fixes"][-1] == 0


def test_libcosim_runs_the_system(folder: Path) -> None:
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_osp_config_file(str(folder / "OspSystemStructure.xml"))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    assert execution.simulate_until(60 * 10**9)
    fmu, expected = Fmu(folder / "fmi2" / "AlignmentFilter.fmu"), reference(folder, "AlignmentFilter")
    names = [n for n in expected.dtype.names if n != "time" and fmu.variables[n].kind == "Real"]
    index = execution.slave_index_from_instance_name("filter")
    got = observer.last_real_values(index, [fmu.variables[name].reference for name in names])
    np.testing.assert_allclose(got, [expected[name][-1] for name in names], rtol=1e-9, atol=1e-15)


def test_fmpy_puts_the_vehicle_elsewhere_at_first(folder: Path) -> None:
    """Its SSP feeds zeros in the first step; the plant believes the second true state, and counts."""
    result = simulate_ssp(str(folder / "buoy.ssp"), stop_time=3.0, step_size=STEP)
    assert result["plant.imu.sample"][:4].tolist() == [0, 0, 2, 3]  # one is missing, and counted
    np.testing.assert_allclose(result["plant.imu.time"][2:], result["time"][2:], atol=1e-9)


def test_it_verifies(folder: Path) -> None:
    result = CliRunner().invoke(app, ["verify", str(folder)])
    assert result.exit_code == 0, result.output


def test_the_partner_is_told_what_moves_the_plant(folder: Path) -> None:
    text = (folder / "README.md").read_text(encoding="utf-8")
    assert "`Playback` plays how a vehicle moves into the inputs `external.*` of `TruthPlant`" in text
    assert "`truth.latitude` to `external.position[1]`" in text


def test_the_compiled_loop_drives_the_plant_as_python_does(
    folder: Path, vehicle: Vehicle, tmp_path: Path
) -> None:
    """The driver of the reference results in `cosimulation.simulate`, by both masters, to the same bits."""
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    made = of_scenario(load_scenario(folder.parent / "buoy.toml", fmus), fmus)
    system, times = with_vehicle(made, vehicle, fmus["Playback"], tmp_path), STEP * np.arange(301)

    def run(master: Master) -> Recorded:
        with ExitStack() as stack:
            instances = {
                c.name: stack.enter_context(closing(Instance(c.fmu, c.name, c.values)))
                for c in system.components
            }
            source, sink = reference_results._connected(system, instances)
            return simulate(source, [sink], times, record_every=10, order=Order.jacobi, master=master)

    python, loop = run(Master.python), run(Master.compiled)
    assert np.ptp(python.filters[0]["nav.latitude"]) > 1e-6
    for name, values in python.filters[0].items():
        np.testing.assert_array_equal(loop.filters[0][name], values, err_msg=name)
