"""The master: its orders, its records, its errors."""

from __future__ import annotations

import zipfile
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.attitude import wrap
from sim_scenarios.connection import initial_values
from sim_scenarios.cosimulation import connected
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.instance import Instance
from sim_scenarios.scenario import load_scenario
from sim_scenarios.simulation import simulated
from sim_scenarios.stepping import Order
from sim_scenarios.units import ARCMIN, DEGREE

EVERY_STEP = {"duration": 20.0, "evaluation.start": 10.0, "recording_period": 0.01}
SHORT = {"duration": 60.0, "evaluation.start": 30.0}


@pytest.fixture
def handed_over(fmus: Fmus) -> Fmu:
    """The filter with an initial value that is an input, to be connected or set."""
    fmu = Fmu(fmus.filter.path)
    fmu.variables["initial.roll"] = replace(fmu.variables["initial.roll"], causality="input")
    return fmu


def test_inputs_that_are_no_signals_are_set_like_parameters(handed_over: Fmu, fmus: Fmus) -> None:
    assert "initial.roll" in handed_over.inputs()
    assert connected(fmus.plant.outputs(), handed_over) == fmus.filter.inputs()
    assert handed_over.assignments("initial.roll", "1 deg") == {"initial.roll": pytest.approx(DEGREE)}


def test_an_initial_value_that_the_user_sets_is_kept(fmus: Fmus) -> None:
    run = sim_scenarios.run("swaying_ship", set={**SHORT, "initial.heading": "40 deg"}, fmus=fmus)
    assert run["nav.heading"].values[0] == pytest.approx(40 * DEGREE)


@pytest.fixture(scope="module")
def gauss_seidel(fmus: Fmus) -> xr.Dataset:
    return sim_scenarios.run("waves", set=EVERY_STEP, fmus=fmus)


def test_jacobi_is_gauss_seidel_one_step_late(gauss_seidel: xr.Dataset, fmus: Fmus) -> None:
    jacobi = sim_scenarios.run("waves", set=EVERY_STEP, order=Order.jacobi, fmus=fmus)
    for name in (
        "nav.heading",
        "nav.velocity",
        "misalignment_sigma",
        "gyro_bias",
        "nav.time",
        "truth.heading",
    ):
        np.testing.assert_array_equal(jacobi[name].values[1:], gauss_seidel[name].values[:-1], err_msg=name)
    np.testing.assert_array_equal(jacobi["nis"].values, gauss_seidel["nis"].values[: jacobi.sizes["fix"]])
    assert gauss_seidel.sizes["fix"] - jacobi.sizes["fix"] == 1  # the last one has not arrived yet


def test_truth_belongs_to_the_samples_that_the_filter_had(fmus: Fmus) -> None:
    jacobi = sim_scenarios.run("waves", set=EVERY_STEP, order=Order.jacobi, fmus=fmus)
    np.testing.assert_allclose(jacobi["nav.time"].values[1:], jacobi["time"].values[1:], atol=1e-9)


def test_every_communication_step_gives_the_same_heading(fmus: Fmus) -> None:
    settings = {"duration": 320.0, "evaluation.stop": 320.0}
    fine = sim_scenarios.run("swaying_ship", set=settings, fmus=fmus)
    for step in (0.02, 0.05, 0.1):
        coarse = sim_scenarios.run("swaying_ship", set={**settings, "communication_step": step}, fmus=fmus)
        difference = wrap(coarse["nav.heading"].values - fine["nav.heading"].values)[
            fine["time"].values >= 300
        ]
        assert np.abs(difference).max() < 0.1 * ARCMIN


def test_same_seed_same_run_other_seed_other_run(fmus: Fmus) -> None:
    first, again, other = (
        sim_scenarios.run("swaying_ship", seed=seed, set=SHORT, fmus=fmus) for seed in (3, 3, 4)
    )
    assert first.identical(again)
    assert not np.array_equal(first["innovation"].values, other["innovation"].values)


def test_compared_filters_see_the_same_signals(fmus: Fmus) -> None:
    """A filter compared with others does exactly what it does alone."""
    together = sim_scenarios.compare("swaying_ship", seed=5, set=SHORT, fmus=fmus)
    alone = sim_scenarios.run(
        "swaying_ship", seed=5, set={**SHORT, "predictor": "linearised", "corrector": "standard"}, fmus=fmus
    )
    for name in ("nav.heading", "heading_sigma", "nis", "fix_used"):
        np.testing.assert_array_equal(together[name].sel(filter="EKF").values, alone[name].values)
    assert not np.array_equal(together["nav.heading"].sel(filter="UKF"), alone["nav.heading"])


def test_records_at_the_period_and_at_every_fix(fmus: Fmus) -> None:
    run = sim_scenarios.run(
        "swaying_ship", set={**SHORT, "recording_period": 0.5, "gnss.rate": 4.0}, fmus=fmus
    )
    np.testing.assert_allclose(run["time"], 0.5 * np.arange(121))
    np.testing.assert_allclose(run["fix_time"], 0.25 * np.arange(1, 241))


def test_progress_ends_at_one(fmus: Fmus) -> None:
    shares: list[float] = []
    sim_scenarios.run("swaying_ship", set=SHORT, progress=shares.append, fmus=fmus)
    assert shares == sorted(shares)
    assert shares[-1] == 1


def test_the_filter_starts_misaligned_as_the_scenario_says(gauss_seidel: xr.Dataset) -> None:
    np.testing.assert_allclose(
        gauss_seidel["attitude_error"].values[0], np.array([0.5, 0.5, 10]) * DEGREE, atol=1e-9
    )
    np.testing.assert_allclose(
        gauss_seidel["nav.velocity"].values[0], gauss_seidel["truth.velocity"].values[0]
    )


def test_initial_errors_of_velocity_and_position_and_draws(fmus: Fmus) -> None:
    truth = {
        **{"truth.roll": 0.0, "truth.pitch": 0.0, "truth.heading": 1.0},
        **{"truth.latitude": 0.5, "truth.longitude": 1.0, "truth.height": 10.0},
        **{f"truth.velocity[{i}]": float(i) for i in (1, 2, 3)},
    }

    def start(**errors: object) -> dict[str, float]:
        settings = {f"initial_error.{name}": value for name, value in errors.items()}
        zero = {"initial_error.misalignment": [0, 0, 0]}
        scenario = load_scenario("swaying_ship", fmus, seed=7, settings={**zero, **settings})
        return initial_values(scenario, fmus.plant, truth)

    assert start() == pytest.approx({name.replace("truth", "initial"): v for name, v in truth.items()})
    moved = start(velocity=[1, 2, 3], position=[100, 200, 30])
    assert [moved[f"initial.velocity[{i}]"] for i in (1, 2, 3)] == [2, 4, 6]
    assert moved["initial.height"] == 40
    assert (moved["initial.latitude"] - 0.5) * 6.36e6 == pytest.approx(200, rel=0.01)
    assert (moved["initial.longitude"] - 1.0) * 6.38e6 * np.cos(0.5) == pytest.approx(100, rel=0.01)
    drawn = start(misalignment_sigma=["1 deg", "1 deg", "1 deg"])
    assert drawn == start(misalignment_sigma=["1 deg", "1 deg", "1 deg"])
    assert 0 < abs(drawn["initial.heading"] - 1.0) < 5 * DEGREE
    placed = start(position=[0, 0, 30], position_sigma=[0, 0, 1])
    assert 0 < abs(placed["initial.height"] - 40) < 5
    assert placed["initial.latitude"] == pytest.approx(0.5, abs=1e-15)


def test_a_bad_parameter_is_refused_in_the_words_of_the_fmu(fmus: Fmus) -> None:
    with pytest.raises(SimulationError, match=r"plant \(TruthPlant\) failed .*gnss.rate"):
        sim_scenarios.run("swaying_ship", set={"gnss.rate": -1.0}, fmus=fmus)
    with pytest.raises(SimulationError, match=r"filter \(AlignmentFilter\) failed .*robust.gamma"):
        sim_scenarios.run("swaying_ship", set={"robust.gamma": -1.0}, fmus=fmus)


def test_a_binary_that_does_not_load_is_refused(fmus: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "Broken.fmu"
    library = f"binaries/{fmpy.platform_tuple}/{fmus.filter.library.name}"
    with zipfile.ZipFile(fmus.filter.path) as original, zipfile.ZipFile(path, "w") as copy:
        copy.writestr("modelDescription.xml", original.read("modelDescription.xml"))
        copy.writestr(library, b"no library")
    folder = Path.cwd()
    with pytest.raises(SimulationError, match=r"Broken.fmu cannot be instantiated: Failed to load"):
        Instance(Fmu(path), "broken", {})
    assert Path.cwd() == folder


def test_a_step_that_does_not_fit_is_refused(fmus: Fmus) -> None:
    with pytest.raises(
        InputError, match=r"recording_period = 0.1 s: must be a whole multiple of the step of 0.03"
    ):
        sim_scenarios.run("swaying_ship", set={"communication_step": 0.03}, fmus=fmus)
    with pytest.raises(SimulationError, match="TruthPlant"):
        sim_scenarios.run(
            "swaying_ship", set={"communication_step": 0.015, "recording_period": 0.15}, fmus=fmus
        )


def test_messages_reach_the_instance_that_sent_them(outliers: xr.Dataset) -> None:
    gated = outliers.sel(filter="UKF, gate")
    refused = int((~gated["fix_used"]).sum())
    assert 0 < outliers.attrs["messages"].count("UKF, gate: fix") <= refused  # some lines tell of several
    assert "UKF, no gate: fix" not in outliers.attrs["messages"]


def test_unconnected_inputs_are_named(fmus: Fmus) -> None:
    with pytest.raises(
        InputError, match=r"nothing is connected to the inputs gnss.sample, .* of AlignmentFilter"
    ):
        connected([name for name in fmus.filter.inputs() if not name.startswith("gnss.")], fmus.filter)


def test_values_are_set_and_read_by_name(fmus: Fmus) -> None:
    with closing(
        Instance(fmus.filter, "one", {"gate.enabled": False, "predictor": 1, "robust.gamma": 4.5})
    ) as one:
        one.begin_initialisation(0.0, 1.0)
        assert one.read(["robust.gamma", "predictor", "gate.enabled"]) == [4.5, 1, 0]


def test_what_is_added_joins_the_increments_of_every_step(fmus: Fmus) -> None:
    """A bias that is added is a bias of the plant; what is added begins anew behind its end."""
    bias = 0.05 * DEGREE / 3600
    settings = {**SHORT, "imu.gyro.bias_sigma": 0.0, "imu.gyro.white_noise": 0.0}
    plain = load_scenario("swaying_ship", fmus, settings=settings)
    biased = load_scenario("swaying_ship", fmus, settings={**settings, "imu.gyro.bias": [bias, 0.0, 0.0]})
    filters = {"filter": plain.filter}
    added = {"imu.delta_angle[1]": np.full(7, 0.01 * bias)}
    disturbed, _ = simulated(plain, fmus, filters, added=added)
    expected, _ = simulated(biased, fmus, filters)
    undisturbed, _ = simulated(plain, fmus, filters)
    for name in ("nav.heading", "nav.pitch"):
        one, other, without = (run.filters[0][name] for run in (disturbed, expected, undisturbed))
        np.testing.assert_allclose(one, other, atol=1e-9 * DEGREE)
        assert np.max(np.abs(without - other)) > 1e-7 * DEGREE
