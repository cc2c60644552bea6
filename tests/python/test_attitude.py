"""Attitude: conventions and inverses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim_scenarios.attitude import (
    dcm,
    euler_angles,
    misalignment,
    misalignment_angles,
    right_jacobian,
    skew,
    wrap,
)
from sim_scenarios.units import DEGREE

tilts = st.floats(-1.5, 1.5)
headings = st.floats(0, 2 * np.pi, exclude_max=True)
horizontal = st.floats(-1.4, 1.4)
vertical = st.floats(-3.1, 3.1)


def test_conventions() -> None:
    right, forward, up = dcm(0.0, 0.0, 90 * DEGREE).T
    np.testing.assert_allclose(forward, [1, 0, 0], atol=1e-12)  # heading east
    np.testing.assert_allclose(right, [0, -1, 0], atol=1e-12)
    assert dcm(0.0, 10 * DEGREE, 0.0)[2, 1] > 0  # bow up
    assert dcm(10 * DEGREE, 0.0, 0.0)[2, 0] < 0  # right side down
    np.testing.assert_allclose(up, [0, 0, 1])


@given(vertical, vertical, headings)
def test_dcm_is_the_product_of_rotations(roll: float, pitch: float, heading: float) -> None:
    expected = Rotation.from_euler("ZXY", [-heading, pitch, roll]).as_matrix()
    np.testing.assert_allclose(dcm(roll, pitch, heading), expected, atol=1e-15)


def test_dcm_takes_arrays_that_broadcast() -> None:
    roll, heading = np.array([0.1, -0.2]), np.array([[1.0], [2.0], [3.0]])
    found = dcm(roll, 0.3, heading)
    assert found.shape == (3, 2, 3, 3)
    np.testing.assert_array_equal(found[2, 1], dcm(-0.2, 0.3, 3.0))


@given(horizontal, horizontal, headings)
def test_euler_angles_invert(roll: float, pitch: float, heading: float) -> None:
    found = euler_angles(dcm(roll, pitch, heading))
    np.testing.assert_allclose(found[:2], (roll, pitch), atol=1e-9)
    assert abs(wrap(found[2] - heading)) < 1e-9


def test_positive_misalignment_makes_the_heading_larger() -> None:
    computed = misalignment([0, 0, 10 * DEGREE]) @ dcm(0.1, 0.05, 0.3)
    np.testing.assert_allclose(euler_angles(computed), (0.1, 0.05, 0.3 + 10 * DEGREE), atol=1e-12)


def test_misalignment_is_the_product_of_passive_rotations() -> None:
    """Zhao 2012, eq. 2, written out: up, then east, then north."""
    e, n, u = 0.2, -0.3, 0.7
    C_z = np.array([[np.cos(u), np.sin(u), 0], [-np.sin(u), np.cos(u), 0], [0, 0, 1]])
    C_x = np.array([[1, 0, 0], [0, np.cos(e), np.sin(e)], [0, -np.sin(e), np.cos(e)]])
    C_y = np.array([[np.cos(n), 0, -np.sin(n)], [0, 1, 0], [np.sin(n), 0, np.cos(n)]])
    np.testing.assert_allclose(misalignment([e, n, u]), C_y @ C_x @ C_z, atol=1e-12)


@given(horizontal, vertical, vertical)
def test_misalignment_angles_invert(east: float, north: float, up: float) -> None:
    np.testing.assert_allclose(
        misalignment_angles(misalignment([east, north, up])), [east, north, up], atol=1e-9
    )


@given(st.floats(-1e4, 1e4))
def test_wrap(angle: float) -> None:
    wrapped = float(wrap(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-9)
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-9)


def test_skew_is_the_cross_product() -> None:
    a, b = np.random.default_rng(1).standard_normal((2, 5, 3))
    np.testing.assert_allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=1e-15)


@pytest.mark.parametrize("size", [0.0, 1e-7, 5e-4, 0.1, 3.0])
def test_right_jacobian_makes_body_rates(size: float) -> None:
    """Against differences of rotations."""
    rotation, rate = size * np.array([0.6, -0.48, 0.64]), np.array([0.3, 0.5, -0.7])
    step = 1e-6
    before, after = (Rotation.from_rotvec(rotation + sign * step * rate) for sign in (-1, 1))
    expected = (before.inv() * after).as_rotvec() / (2 * step)
    np.testing.assert_allclose(right_jacobian(rotation) @ rate, expected, atol=1e-9)
