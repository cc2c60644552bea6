"""The Earth against its published figures and against pymap3d."""

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymap3d import rcurve

from sim_scenarios.earth import curvature, earth_rate, gravity, radii

latitudes = st.floats(-1.5, 1.5)


@given(latitudes)
def test_radii_of_curvature_are_those_of_pymap3d(latitude: float) -> None:
    meridian, prime_vertical = radii(latitude)
    assert meridian == pytest.approx(rcurve.meridian(latitude, deg=False), rel=1e-12)
    assert prime_vertical == pytest.approx(rcurve.transverse(latitude, deg=False), rel=1e-12)


@given(latitudes, st.floats(-400, 10_000), st.floats(0, 2 * np.pi))
def test_transport_rate_turns_the_local_level_as_it_moves(
    latitude: float, height: float, course: float
) -> None:
    """A metre along the course, through Earth-centred coordinates."""
    east, north = np.sin(course), np.cos(course)
    x, y, z = pymap3d.enu2ecef(east, north, 0.0, latitude, 0.0, height, deg=False)
    moved_latitude, moved_longitude, _ = pymap3d.ecef2geodetic(x, y, z, deg=False)
    rate = curvature(np.array([latitude]), np.array([height]))[0] @ [east, north, 0.0]
    dlat, dlon = moved_latitude - latitude, float(moved_longitude)
    turned = [-dlat, dlon * np.cos(latitude), dlon * np.sin(latitude)]
    np.testing.assert_allclose(rate, turned, atol=1e-11)


def test_the_earth_turns_about_its_axis() -> None:
    np.testing.assert_allclose(
        earth_rate(np.array([0.0, np.pi / 2])), [[0, 7.292115e-5, 0], [0, 0, 7.292115e-5]], atol=1e-20
    )


def test_gravity_of_the_ellipsoid() -> None:
    # NIMA TR8350.2: at the equator, at the pole, and 1000 m above the equator
    latitude = np.array([0.0, np.pi / 2, 0.0])
    expected = [9.7803253359, 9.8321849378, 9.7803253359 - 3.0877e-3]
    np.testing.assert_allclose(gravity(latitude, np.array([0.0, 0.0, 1000.0])), expected, atol=1e-6)
