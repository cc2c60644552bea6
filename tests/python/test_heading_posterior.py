"""The bound of heading errors of any size: against that of small errors, and a posterior in closed form.

What is drawn is held to 4 standard errors, which chance goes beyond in 6 of 100,000 cases, with the seed of
the package and with another.
"""

import numpy as np
import pytest
import trajectories
from scipy.special import ndtri

from sim_scenarios.attitude import wrap
from sim_scenarios.bounds import EARTH_RATE, Knowledge, Log, cramer_rao
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.heading_posterior import (
    DRAWS,
    NODES,
    SEED,
    WIDE,
    HeadingPosterior,
    _composed,
    heading_posterior,
    on_the_circle,
)
from sim_scenarios.scenario_bound import bound
from sim_scenarios.units import DEGREE, HOUR, STANDARD_GRAVITY

SEEDS = (SEED, 20)
CHANCE = 4.0  # standard errors
TIME = np.arange(3001) / 10
MICROMECHANICAL = {
    "angle_random_walk": 0.06 * DEGREE / HOUR**0.5,
    "velocity_random_walk": 85e-6 * STANDARD_GRAVITY,
    "accelerometer_bias_sigma": 3e-3 * STANDARD_GRAVITY,
}
AIDS = {
    "velocity": {},
    "position": {"gnss_position_sigma": (5.0, 3.0, 10.0), "gnss_velocity_sigma": (0.1, 0.2, 0.1)},
    "lever arm": {"lever_arm": (0.0, 30.0, 0.0), "gnss_position_sigma": 5.0},
}


@pytest.mark.parametrize(
    ("motion", "aid"),
    [*((motion, "position") for motion in trajectories.MOTIONS), ("turn", "velocity"), ("turn", "lever arm")],
)
def test_of_small_errors_it_is_the_cramer_rao_bound(motion: str, aid: str) -> None:
    """Prior of 10 deg, tactical gyros. While the heading is found, squares of its error are worth 4 %."""
    trajectory = trajectories.ship(TIME, **trajectories.MOTIONS[motion])
    knowledge = Knowledge(**AIDS[aid])
    found = heading_posterior(trajectory, knowledge, draws=20)
    expected = cramer_rao(trajectory, knowledge)
    np.testing.assert_array_equal(found.time, expected.time)
    np.testing.assert_allclose(found.heading_sigma[0], expected.heading_sigma[0], rtol=1e-4)
    np.testing.assert_allclose(found.heading_sigma, expected.heading_sigma, rtol=0.05)
    np.testing.assert_allclose(found.heading_sigma[-1], expected.heading_sigma[-1], rtol=0.003)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("motion", "drift"), [("static", 10.0), ("steady", 3.0), ("waves", 10.0), ("turn", 10.0)]
)
def test_it_is_as_wrong_as_it_says(motion: str, drift: float, seed: int) -> None:
    """Squared errors of the posterior mean less its variance have the mean zero, at every time."""
    trajectory = trajectories.ship(TIME, **trajectories.MOTIONS[motion])
    knowledge = Knowledge(heading_sigma=60 * DEGREE, gyro_bias_sigma=drift * DEGREE / HOUR, **MICROMECHANICAL)
    found = heading_posterior(trajectory, knowledge, seed=seed)
    excess = np.square(found.error) - found.variance
    for k in (30, 100, 200, 300):
        assert abs(excess[k].mean()) < CHANCE * excess[k].std() / DRAWS**0.5


def gyrocompass(drift: float, heading_sigma: float | None) -> float:
    """Least RMS heading error at rest: both horizontal Earth rates, measured with sigma drift [rad/s].

    By quadrature over what is measured and over the prior's error; of nothing known where sigma is None.
    """
    psi = wrap(2 * np.pi * np.arange(240) / 240)
    snr = EARTH_RATE * np.cos(32 * DEGREE) / drift
    east, north = np.meshgrid(*2 * [np.linspace(-5, 5, 41)])
    weight = np.exp(-(east**2 + north**2) / 2)
    off_by = (east[..., None] - snr * np.sin(psi)) ** 2 + (north[..., None] + snr * (1 - np.cos(psi))) ** 2
    squares = []
    for off in [0.0] if heading_sigma is None else heading_sigma * ndtri((np.arange(20) + 0.5) / 20):
        prior = np.zeros_like(psi)
        if heading_sigma is not None:
            turns = 2 * np.pi * np.arange(-3, 4)[:, None]
            prior = np.logaddexp.reduce(-(((psi - off + turns) / heading_sigma) ** 2) / 2, axis=0)
        posterior = np.exp(prior - off_by / 2)
        posterior /= posterior.sum(axis=-1, keepdims=True)
        of_guess = np.fft.ifft(np.fft.fft(posterior) * np.fft.fft(psi**2)).real  # mean square of any guess
        squares.append(np.average(of_guess.min(axis=-1), weights=weight))
    return float(np.sqrt(np.mean(squares)))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("heading_sigma", [None, 60 * DEGREE])
@pytest.mark.parametrize("drift", [2.0, 5.0, 10.0, 30.0])
def test_at_rest_it_is_that_of_a_gyrocompass(drift: float, heading_sigma: float | None, seed: int) -> None:
    found = at_rest(drift, heading_sigma or 103.9 * DEGREE, seed)
    rms, standard_error = found.heading_rms(100.0, 100.0)
    assert abs(rms - gyrocompass(drift * DEGREE / HOUR, heading_sigma)) < CHANCE * standard_error


def at_rest(drift: float, heading_sigma: float, seed: int) -> HeadingPosterior:
    """Of a vehicle with gyros of biases alone [deg/h]."""
    knowledge = Knowledge(
        tilt_sigma=0.1 * DEGREE,
        heading_sigma=heading_sigma,
        gyro_bias_sigma=drift * DEGREE / HOUR,
        accelerometer_bias_sigma=1e-6,
        angle_random_walk=1e-9,
        velocity_random_walk=1e-7,
        gnss_velocity_sigma=0.01,
    )
    trajectory = trajectories.ship(TIME[:1001], **trajectories.MOTIONS["static"])
    return heading_posterior(trajectory, knowledge, seed=seed)


@pytest.mark.parametrize(("heading_sigma", "known"), [(103.9, 180 / 3**0.5), (60.0, 59.73)])
def test_gyros_that_do_not_feel_the_earth_leave_the_prior(heading_sigma: float, known: float) -> None:
    """A normal distribution of 60 deg around the circle has 59.73 deg. Tilts are found first."""
    found = at_rest(1000.0, heading_sigma * DEGREE, SEED)
    np.testing.assert_allclose(found.heading_sigma[10:20] / DEGREE, known, rtol=0.01)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_zigzag_shows_the_heading_to_gyros_that_do_not(seed: int) -> None:
    knowledge = Knowledge(heading_sigma=103.9 * DEGREE, gyro_bias_sigma=10 * DEGREE / HOUR, **MICROMECHANICAL)
    steady, zigzag = (
        heading_posterior(trajectories.ship(TIME, **trajectories.MOTIONS[motion]), knowledge, seed=seed)
        for motion in ("steady", "zigzag 20")
    )
    assert steady.heading_sigma[-1] > 30 * DEGREE
    assert zigzag.heading_sigma[-1] < 1 * DEGREE
    small = cramer_rao(trajectories.ship(TIME, **trajectories.MOTIONS["zigzag 20"]), knowledge)
    assert zigzag.heading_sigma[-1] == pytest.approx(small.heading_sigma[-1], rel=0.01)


@pytest.mark.parametrize("motion", ["static", "turn"])
def test_below_a_wide_prior_the_cramer_rao_bound_is_enough(motion: str) -> None:
    trajectory = trajectories.ship(TIME, **trajectories.MOTIONS[motion])
    for drift in (1.0, 10.0):
        knowledge = Knowledge(heading_sigma=WIDE, gyro_bias_sigma=drift * DEGREE / HOUR, **MICROMECHANICAL)
        ratio = (
            heading_posterior(trajectory, knowledge).heading_sigma
            / cramer_rao(trajectory, knowledge).heading_sigma
        )
        assert 0.95 < ratio.min() <= ratio.max() < 1.05


def test_five_headings_tell_all_others() -> None:
    trajectory = trajectories.ship(TIME[:101], waves=True, turns=[(0, 10, 60)])
    every_second = np.arange(10, 101, 10)
    knowledge = Knowledge(gnss_position_sigma=5.0)
    psi = np.array([0.3, 2.0, -2.5])
    of_nodes = [_composed(trajectory, knowledge, node, every_second) for node in NODES]
    for i, heading in enumerate(psi):
        for each, expected in zip(
            zip(*of_nodes, strict=True), _composed(trajectory, knowledge, heading, every_second), strict=True
        ):
            told = on_the_circle(psi, np.array(each))[i]
            np.testing.assert_allclose(told, expected, atol=1e-7)


def test_a_scenario_has_it_where_its_prior_is_wide(fmus: Fmus) -> None:
    settings = {"duration": 100.0, "evaluation.start": 50.0, "evaluation.stop": 100.0}
    small, wide = (
        bound("turn", set={**settings, "bound.heading_sigma": sigma}, fmus=fmus)
        for sigma in ("19 deg", "20 deg")
    )
    assert not [name for name in (*small, *small.attrs) if "_any" in str(name)]
    assert wide["bound.heading_sigma_any"].dims == ("bound_time",)
    rms, cramer_rao_rms = (wide.attrs[f"bound.heading_rms{which}"] for which in ("_any", ""))
    assert rms == pytest.approx(cramer_rao_rms, rel=0.05)
    assert 0 < wide.attrs["bound.heading_rms_any_standard_error"] < 0.05 * rms


def test_hypotheses_are_close_enough_for_twenty_minutes_of_turns(fmus: Fmus) -> None:
    """Nothing is known beforehand, and the heading is found. Twice as far apart they are 3 % off."""
    known = bound("align_then_navigate", fmus=fmus).attrs
    assert known["bound.heading_rms_any"] == pytest.approx(known["bound.heading_rms"], rel=0.01)


def test_refuses_what_it_cannot_use() -> None:
    trajectory = trajectories.ship(TIME[:101])
    with pytest.raises(InputError, match=r"more than 1.125 deg"):
        heading_posterior(trajectory, Knowledge(heading_sigma=1 * DEGREE))
    with pytest.raises(InputError, match="knows no log"):
        heading_posterior(trajectory, Knowledge(log=Log((0.1, 0.1, 0.1), 1.0)))
    with pytest.raises(InputError, match="needs GNSS"):
        heading_posterior(trajectory, Knowledge(gnss_rate=0.0))
    with pytest.raises(InputError, match="needs a fix"):
        heading_posterior(trajectory, Knowledge(gnss_rate=0.001))
    with pytest.raises(InputError, match="nothing is recorded between 300 s and 600 s"):
        heading_posterior(trajectory, Knowledge()).heading_rms(300, 600)
