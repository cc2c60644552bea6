"""The Cramer-Rao bound against its table and against an error model written by others."""

import numpy as np
import pandas as pd
import pytest
import trajectories
from pyins.error_model import InsErrorModel
from scipy.linalg import block_diag

from sim_scenarios.attitude import misalignment, wrap
from sim_scenarios.bounds import POSITION, Knowledge, Log, Trajectory, aids_of, cramer_rao
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario_bound import bound
from sim_scenarios.units import ARCMIN, DEGREE

TIME = np.arange(6001) / 10
WINDOW = (300.0, 600.0)

GNSS = [(0.1, 1), (0.05, 1), (0.02, 1), (0.1, 10), (0.02, 10)]  # sigma [m/s], rate [Hz]
# RMS of the heading sigma over 300 to 600 s [arcmin]
TABLE = {
    "static": (15.21, 14.63, 14.42, 14.50, 14.34),
    "steady": (15.11, 14.51, 14.23, 14.34, 14.09),
    "waves": (13.72, 10.86, 5.98, 8.42, 2.09),
    "turn": (5.50, 3.13, 1.79, 2.30, 1.16),
    "zigzag 20": (5.53, 3.19, 1.76, 2.30, 1.07),
    "zigzag 45": (2.80, 1.58, 0.88, 1.15, 0.54),
}
CELLS = [
    (motion, *gnss, figure) for motion, row in TABLE.items() for gnss, figure in zip(GNSS, row, strict=True)
]


@pytest.mark.parametrize(("motion", "sigma", "rate", "figure"), CELLS)
def test_reproduces_the_table(motion: str, sigma: float, rate: float, figure: float) -> None:
    trajectory = trajectories.ship(TIME, **trajectories.MOTIONS[motion])
    result = cramer_rao(trajectory, Knowledge(gnss_velocity_sigma=sigma, gnss_rate=rate))
    assert result.heading_rms(*WINDOW) / ARCMIN == pytest.approx(figure, rel=0.03)


@pytest.mark.parametrize("scenario", ["swaying_ship", "waves", "turn", "zigzag"])
def test_plant_and_closed_form_agree(scenario: str, fmus) -> None:
    motion = {"swaying_ship": "steady", "zigzag": "zigzag 20"}.get(scenario, scenario)
    closed_form = cramer_rao(trajectories.ship(TIME, **trajectories.MOTIONS[motion]), Knowledge())
    plant = bound(scenario, fmus=fmus).attrs["bound.heading_rms"]
    assert plant == pytest.approx(closed_form.heading_rms(*WINDOW), rel=0.005)


def test_the_bound_shows_what_manoeuvres_are_worth(fmus: Fmus) -> None:
    """Without its turns a zigzag is the ship on a steady course."""
    zigzag, steady = bound("zigzag", fmus=fmus), bound("swaying_ship", fmus=fmus)
    without = zigzag.attrs["bound.heading_rms_steady"]
    assert without == pytest.approx(steady.attrs["bound.heading_rms"], rel=1e-9)
    assert zigzag.attrs["bound.heading_rms"] < 0.5 * without
    begin = int(np.searchsorted(zigzag["bound_time"].values, 50.0))  # of the first turn
    with_and_without = zigzag[["bound.heading_sigma", "bound.heading_sigma_steady"]].to_array().values
    np.testing.assert_allclose(*with_and_without[:, :begin], rtol=1e-9)
    assert "bound.heading_rms_steady" not in steady.attrs


def test_a_motion_that_needs_its_manoeuvres_has_a_bound(fmus: Fmus) -> None:
    """Straight on, this flight comes to the pole."""
    far, near = ({"motion.latitude": latitude, "imu.rate": 10.0} for latitude in ("80 deg", "89.7 deg"))
    assert "bound.heading_rms_steady" in bound("flight_constant_speed", set=far, fmus=fmus).attrs
    found = bound("flight_constant_speed", set=near, fmus=fmus)
    assert 0.0 < found.attrs["bound.heading_rms"] < np.pi
    assert "bound.heading_rms_steady" not in found.attrs
    assert (
        "bound.heading_rms_steady" in bound("flight_constant_speed", set={"imu.rate": 10.0}, fmus=fmus).attrs
    )


def test_the_bound_of_a_scenario_knows_its_lever_arm_and_says_what_it_leaves_out(fmus) -> None:
    data = bound("swaying_ship", fmus=fmus, set={"plant.gnss.lever_arm": [0, 30, 0], "gnss.latency": 0.5})
    expected = cramer_rao(trajectories.ship(TIME), Knowledge(lever_arm=(0.0, 30.0, 0.0)))
    assert data.attrs["bound.heading_rms"] == pytest.approx(expected.heading_rms(*WINDOW), rel=0.005)
    assert data.attrs["bound.leaves_out"] == "gnss.latency"
    assert data.attrs["bound.measured"] == "velocity"


def test_the_bound_says_when_the_biases_are_drawn_otherwise_than_it_assumes(fmus) -> None:
    said = {"imu.gyro.bias_sigma": "0.02 deg/h", "bound.gyro_bias_sigma": "0.05 deg/h"}
    assert bound("swaying_ship", fmus=fmus, set=said).attrs["bound.leaves_out"] == "imu.gyro.bias_sigma"


@pytest.mark.parametrize("name", ["imu.gyro.bias_sigma", "plant.imu.gyro.bias_sigma"])
def test_the_bound_follows_the_biases_that_are_drawn(fmus: Fmus, name: str) -> None:
    followed = bound("swaying_ship", fmus=fmus, set={name: "0.005 deg/h"})
    told = bound(
        "swaying_ship",
        fmus=fmus,
        set={"imu.gyro.bias_sigma": "0.005 deg/h", "bound.gyro_bias_sigma": "0.005 deg/h"},
    )
    assert followed.attrs["bound.leaves_out"] == ""
    assert followed.attrs["bound.heading_rms"] == told.attrs["bound.heading_rms"]
    assert (
        followed.attrs["bound.heading_rms"]
        < 0.5 * bound("swaying_ship", fmus=fmus).attrs["bound.heading_rms"]
    )


def test_biases_that_are_not_drawn_leave_the_bound_as_it_is(fmus: Fmus) -> None:
    none, some = (bound("swaying_ship", fmus=fmus, set=s) for s in ({"imu.gyro.bias_sigma": 0.0}, {}))
    assert none.attrs["bound.heading_rms"] == some.attrs["bound.heading_rms"]


@pytest.mark.parametrize("motion", ["steady", "waves", "zigzag 20"])
def test_agrees_with_the_error_model_of_pyins(motion: str) -> None:
    trajectory = trajectories.ship(TIME, **trajectories.MOTIONS[motion])
    expected = heading_sigma_by_pyins(trajectory, Knowledge())
    late = TIME[::10] >= WINDOW[0]
    np.testing.assert_allclose(
        cramer_rao(trajectory, Knowledge()).heading_sigma[late], expected[late], rtol=0.01
    )


def heading_sigma_by_pyins(trajectory: Trajectory, k: Knowledge) -> np.ndarray:
    """Heading sigma after each fix, from the modified phi-angle model in NED with position states.

    pyins: n = NED, b = forward-right-down, degrees; states position, velocity, phi, and both biases.
    """
    to_ned = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])
    C = to_ned @ trajectory.C_bn @ to_ned
    pva = pd.DataFrame(
        {
            "lat": np.rad2deg(trajectory.latitude),
            "lon": 0.0,
            "alt": trajectory.height,
            **dict(zip(("VN", "VE", "VD"), (trajectory.velocity @ to_ned).T, strict=True)),
            "roll": np.rad2deg(np.arctan2(C[:, 2, 1], C[:, 2, 2])),
            "pitch": np.rad2deg(-np.arcsin(C[:, 2, 0])),
            "heading": np.rad2deg(np.arctan2(C[:, 1, 0], C[:, 0, 0])),
        }
    )
    model = InsErrorModel()
    F9, B_gyro, B_accel = model.system_matrices(pva)
    output = model.transform_to_output(pva)  # position, velocity, roll-pitch-heading [deg]
    F = np.zeros((len(pva), 15, 15))
    F[:, :9, :9], F[:, :9, 9:12], F[:, :9, 12:] = F9, B_gyro, B_accel
    B = np.concatenate((B_gyro, B_accel), axis=2)
    noise = np.diag([k.angle_random_walk**2] * 3 + [k.velocity_random_walk**2] * 3)

    angles = np.rad2deg([k.tilt_sigma, k.tilt_sigma, k.heading_sigma])
    sigmas = np.concatenate(([0.01] * 3, [k.velocity_sigma] * 3, angles))
    to_states = np.linalg.inv(output[0])
    P = block_diag(
        to_states @ np.diag(np.square(sigmas)) @ to_states.T,
        k.gyro_bias_sigma**2 * np.eye(3),
        k.accelerometer_bias_sigma**2 * np.eye(3),
    )
    result = [k.heading_sigma]
    for i in range(1, len(pva)):
        dt = trajectory.time[i] - trajectory.time[i - 1]
        mean = (F[i] + F[i - 1]) / 2 * dt
        Phi = np.eye(15) + mean + mean @ mean / 2
        Q = np.zeros((15, 15))
        Q[:9, :9] = B[i] @ noise @ B[i].T * dt
        P = Phi @ P @ Phi.T + Q
        if i % 10 == 0:
            H = np.zeros((3, 15))
            H[:, :9] = output[i, 3:6]
            information = np.linalg.inv(P) + H.T @ H / k.gnss_velocity_sigma**2
            P = np.linalg.inv(information)
            P = (P + P.T) / 2
            heading = output[i, 8]
            result.append(np.deg2rad(np.sqrt(heading @ P[:9, :9] @ heading)))
    return np.array(result)


def test_the_lever_arm_is_observed_as_the_misaligned_attitude_moves_it() -> None:
    """Row of the attitude against a difference of antenna velocities and places, C and C disturbed by phi."""
    trajectory = trajectories.ship(TIME[:101], waves=True)
    lever_arm, phi = np.array([2.0, -30.0, 10.0]), np.array([1e-6, -2e-6, 3e-6])
    knowledge = Knowledge(lever_arm=tuple(lever_arm), gnss_position_sigma=5.0)
    (gnss,) = aids_of(trajectory, knowledge)
    H = gnss.H
    disturbed = misalignment(phi) @ trajectory.C_bn
    moved = (disturbed - trajectory.C_bn) @ lever_arm
    # d/dt in n of what is carried along by the body is C (w x l), w_en apart (1e-6 rad/s)
    swung = np.gradient(moved, trajectory.time, axis=0)
    np.testing.assert_allclose(H[:, :3, :3] @ phi, swung, atol=1e-9)
    np.testing.assert_allclose(H[:, 3:, :3] @ phi, moved, atol=1e-9)
    np.testing.assert_array_equal(H[:, :3, 3:6], np.broadcast_to(np.eye(3), (101, 3, 3)))
    np.testing.assert_array_equal(H[:, 3:, 12:], np.broadcast_to(np.eye(3), (101, 3, 3)))


def test_a_lever_arm_that_swings_shows_the_heading() -> None:
    trajectory = trajectories.ship(TIME)
    at_imu, at_bow = (Knowledge(lever_arm=(0.0, forward, 0.0)) for forward in (0.0, 30.0))
    limits = [cramer_rao(trajectory, knowledge).heading_rms(*WINDOW) for knowledge in (at_imu, at_bow)]
    assert limits[1] < 0.6 * limits[0]


def test_positions_alone_are_averaged() -> None:
    """With a perfect IMU at rest an error of position stays, one of height grows as cosh(sqrt(2 g / R) t)."""
    trajectory = trajectories.ship(TIME[:1001], sway=False, speed=0.0)
    perfect = Knowledge(
        tilt_sigma=1e-9,
        heading_sigma=1e-9,
        velocity_sigma=1e-9,
        gyro_bias_sigma=1e-15,
        accelerometer_bias_sigma=1e-12,
        angle_random_walk=0.0,
        velocity_random_walk=0.0,
        position_sigma=20.0,
        gnss_position_sigma=(5.0, 5.0, 10.0),
    )
    growth = np.cosh(np.sqrt(2 * 9.795 / 6.384e6) * np.arange(101.0))
    sigma = cramer_rao(trajectory, perfect).sigma[:, POSITION]
    for axis, (gnss, grown) in enumerate(((5.0, np.ones(101)), (5.0, np.ones(101)), (10.0, growth))):
        information = 1 / 20.0**2 + (np.cumsum(grown**2) - 1) / gnss**2  # the first fix comes after 1 s
        np.testing.assert_allclose(sigma[:, axis], grown / np.sqrt(information), rtol=1e-3)


def test_more_knowledge_never_hurts() -> None:
    trajectory = trajectories.ship(TIME[:3001], waves=True)
    coarse = cramer_rao(trajectory, Knowledge()).heading_sigma
    for better in (
        Knowledge(gnss_velocity_sigma=0.05),
        Knowledge(heading_sigma=5 * DEGREE),
        Knowledge(angle_random_walk=0.0),
        Knowledge(gyro_bias_sigma=1e-8),
        Knowledge(gnss_position_sigma=5.0),
    ):
        assert np.all(cramer_rao(trajectory, better).heading_sigma <= coarse * (1 + 1e-9))


def test_fixes_between_two_samples_of_the_trajectory_all_count() -> None:
    """Two at once are one of half the variance."""
    trajectory = trajectories.ship(TIME[:3001], waves=True)
    sampling = 1 / (TIME[1] - TIME[0])
    many = Knowledge(gnss_rate=2 * sampling, gnss_velocity_sigma=0.3, gnss_position_sigma=5.0)
    fewer = Knowledge(
        gnss_rate=sampling, gnss_velocity_sigma=0.3 / np.sqrt(2), gnss_position_sigma=5.0 / np.sqrt(2)
    )
    sigma, expected = (cramer_rao(trajectory, knowledge).sigma for knowledge in (many, fewer))
    np.testing.assert_allclose(sigma, expected, rtol=1e-9)


def test_without_motion_the_east_gyro_bias_limits_the_heading() -> None:
    trajectory = trajectories.ship(TIME, sway=False, speed=0.0)
    nearly_perfect = Knowledge(
        gnss_velocity_sigma=1e-3,
        angle_random_walk=0.0,
        velocity_random_walk=1e-9,
        accelerometer_bias_sigma=1e-6,
    )
    limit = nearly_perfect.gyro_bias_sigma / (7.292115e-5 * np.cos(32 * DEGREE))
    assert cramer_rao(trajectory, nearly_perfect).heading_sigma[-1] == pytest.approx(limit, rel=0.01)


def test_a_log_of_known_axes_is_a_receiver_of_velocities() -> None:
    trajectory = trajectories.ship(TIME[:301])
    known = {"tilt_sigma": 1e-9, "heading_sigma": 1e-9, "gyro_bias_sigma": 1e-15, "angle_random_walk": 0.0}
    receiver = cramer_rao(trajectory, Knowledge(**known))
    log = cramer_rao(trajectory, Knowledge(**known, gnss_rate=0.0, log=Log((0.1, 0.1, 0.1), 1.0)))
    np.testing.assert_allclose(log.sigma[:, 3:12], receiver.sigma[:, 3:12], rtol=1e-5)


def test_a_log_that_is_off_by_a_scale_tells_speed_no_better_than_that() -> None:
    trajectory = trajectories.ship(TIME[:301])
    off, right = (
        cramer_rao(
            trajectory,
            Knowledge(velocity_sigma=10.0, gnss_rate=0.0, log=Log((0.01, 0.01, 0.01), 1.0, scale)),
        )
        for scale in (0.02, 0.0)
    )
    speed = 10.0  # northwards
    assert off.sigma[-1, 4] == pytest.approx(0.02 * speed, rel=0.05)
    assert right.sigma[-1, 4] < 0.1 * off.sigma[-1, 4]
    assert off.sigma[-1, -1] == pytest.approx(0.02, rel=0.05)  # without fixes nothing tells it


def test_starts_from_the_prior() -> None:
    result = cramer_rao(trajectories.ship(TIME[:101]), Knowledge())
    np.testing.assert_allclose(result.sigma[0, :3], np.array([1, 1, 10]) * DEGREE)
    assert result.time[0] == 0
    assert result.time[1] == pytest.approx(1)


def test_refuses_what_it_cannot_use() -> None:
    trajectory = trajectories.ship(TIME[:101])
    with pytest.raises(InputError, match="needs GNSS"):
        cramer_rao(trajectory, Knowledge(gnss_velocity_sigma=(0.1, 0.0, 0.1)))
    with pytest.raises(InputError, match="no fix between 300 s and 600 s"):
        cramer_rao(trajectory, Knowledge()).heading_rms(300, 600)
    with pytest.raises(ValueError, match="must increase"):
        cramer_rao(trajectories.ship(np.zeros(3)), Knowledge())


def test_trajectory_of_the_tests_turns_its_bow() -> None:
    """The closed form that the table rests on: heading follows the course, clockwise."""
    trajectory = trajectories.ship(TIME, sway=False, turns=[(150, 60, 90)])
    bow = trajectory.C_bn[:, :, 1]
    heading = np.arctan2(bow[:, 0], bow[:, 1])
    np.testing.assert_allclose(wrap(heading[[0, -1]]) / DEGREE, [0, 90], atol=1e-9)
    np.testing.assert_allclose(trajectory.velocity[-1], [10, 0, 0], atol=1e-9)
