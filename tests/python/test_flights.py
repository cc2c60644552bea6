"""The flight scenarios, one seed each: what their notes promise (over many seeds: sim_scenarios.bands)."""

from __future__ import annotations

import numpy as np
import pytest

import sim_scenarios
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.navigation import NavigationVerdict, judge
from sim_scenarios.metrics.statistics import chi_square_interval
from sim_scenarios.scenario import load_scenario

CHANNELS = 6


def verdicts(scenario: str, fmus: Fmus, **settings: object) -> dict[str, NavigationVerdict]:
    runs = sim_scenarios.compare(scenario, set=settings, fmus=fmus)
    return {str(label): judge(runs.sel(filter=label)) for label in runs["filter"].values}


def test_small_errors_make_all_predictors_one_filter(fmus: Fmus) -> None:
    found = verdicts("flight_constant_speed", fmus, duration=400.0)
    ekf = found["EKF"]
    for label in ("UKF", "augmented UKF"):
        assert found[label].horizontal == pytest.approx(ekf.horizontal, rel=0.02)
        assert found[label].velocity == pytest.approx(ekf.velocity, rel=0.02)
        assert found[label].yaw == pytest.approx(ekf.yaw, rel=0.02)
    freedom = ekf.nis.count * CHANNELS
    lower, upper = chi_square_interval(freedom, 0.999)
    assert lower < ekf.nis.mean * freedom < upper


def test_weights_keep_the_accuracy_of_clean_fixes(fmus: Fmus) -> None:
    found = verdicts("flight_outliers", fmus, duration=400.0)
    for label in ("IGG", "UKF, gate"):
        assert found[label].horizontal < 0.5 * found["UKF"].horizontal
        assert found[label].velocity < 0.5 * found["UKF"].velocity


def test_the_adaptive_factor_survives_a_fault_of_the_accelerometers(fmus: Fmus) -> None:
    found = verdicts("flight_accelerometer_fault", fmus, duration=600.0)
    single_fix = np.hypot(10.0, 10.0)
    for label in ("adaptive factor", "IGG with guard"):
        assert found[label].horizontal < single_fix
    assert not found["UKF"].ok
    assert found["IGG without guard"].horizontal > 1000.0


def test_the_fixes_of_jing_2023_have_its_sigmas(fmus: Fmus) -> None:
    """Eq. 20: 0.2 m/s and 8 m, of the receiver and as the filter is told."""
    scenario = load_scenario("flight_varying_noise", fmus)
    for axis in (1, 2, 3):
        assert scenario.plant[f"gnss.velocity_sigma[{axis}]"] == 0.2
        assert scenario.plant[f"gnss.position_sigma[{axis}]"] == 8.0
    told = {name: scenario.filter[f"measurement.{name}_sigma"] for name in ("position", "height", "velocity")}
    assert told == {"position": 8.0, "height": 8.0, "velocity": 0.2}


def test_variational_bayes_learns_the_noise(fmus: Fmus) -> None:
    runs = sim_scenarios.compare("flight_varying_noise", set={"duration": 900.0}, fmus=fmus)
    told, learned = (judge(runs.sel(filter=label)) for label in ("UKF", "VB, rho 0.95"))
    assert learned.velocity < 0.85 * told.velocity
    assert learned.tilt < 0.7 * told.tilt
    late = runs.sel(filter="VB, rho 0.95")["measurement_sigma_estimate"].values[runs["fix_time"].values > 700]
    # From 200 fixes a sigma is known to 1 / sqrt(2 * 200) = 5 %: five times that.
    np.testing.assert_allclose(late[:, :3].mean(axis=0), 6 * 8.0, rtol=0.25)
    np.testing.assert_allclose(late[:, 12:15].mean(axis=0), 6 * 0.2, rtol=0.25)


def test_three_satellites_bind_the_error_in_an_outage(fmus: Fmus) -> None:
    assert verdicts("gnss_outage_turn_tight", fmus, duration=661.0)["UKF"].ok
