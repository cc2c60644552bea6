"""The Earth after WGS-84 (NIMA TR8350.2): rotation, radii of curvature, normal gravity.

Vectors are in east, north, up; latitudes in rad, heights above the ellipsoid in m.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SEMI_MAJOR_AXIS: Final = 6378137.0  # m
FLATTENING: Final = 1 / 298.257223563
ECCENTRICITY_2: Final = FLATTENING * (2 - FLATTENING)
EARTH_RATE: Final = 7.292115e-5  # rad/s
EQUATORIAL_GRAVITY: Final = 9.7803253359  # m/s2
SOMIGLIANA: Final = 1.931852652458e-3
CENTRIFUGAL_RATIO: Final = 3.449786506841e-3  # w^2 a^2 b / GM


def earth_rate(latitude: Array) -> Array:
    """Earth rate w_ie in ENU [rad/s], shape (n, 3)."""
    return EARTH_RATE * np.stack((np.zeros_like(latitude), np.cos(latitude), np.sin(latitude)), axis=-1)


def gravity(latitude: Array, height: Array) -> Array:
    """Magnitude of normal gravity [m/s2]: Somigliana, expanded in height (NIMA TR8350.2, eq. 4-3)."""
    sin2 = np.sin(latitude) ** 2
    on_ellipsoid = EQUATORIAL_GRAVITY * (1 + SOMIGLIANA * sin2) / np.sqrt(1 - ECCENTRICITY_2 * sin2)
    ratio = height / SEMI_MAJOR_AXIS
    slope = 2 * (1 + FLATTENING + CENTRIFUGAL_RATIO - 2 * FLATTENING * sin2)
    result: Array = on_ellipsoid * (1 - slope * ratio + 3 * ratio**2)
    return result


def curvature(latitude: Array, height: Array) -> Array:
    """Matrix from velocity (ENU) [m/s] to transport rate w_en (ENU) [rad/s], shape (n, 3, 3)."""
    meridian, prime_vertical = radii(latitude)
    matrix = np.zeros((*latitude.shape, 3, 3))
    matrix[..., 0, 1] = -1 / (meridian + height)
    matrix[..., 1, 0] = 1 / (prime_vertical + height)
    matrix[..., 2, 0] = np.tan(latitude) / (prime_vertical + height)
    return matrix


def radii(latitude: ArrayLike) -> tuple[Array, Array]:
    """Radii of curvature of the ellipsoid [m]: meridian and prime vertical."""
    root = np.sqrt(1 - ECCENTRICITY_2 * np.sin(latitude) ** 2)
    return SEMI_MAJOR_AXIS * (1 - ECCENTRICITY_2) / root**3, SEMI_MAJOR_AXIS / root


def displacement(position: Array, origin: Array) -> Array:
    """From one position to another nearby: east, north, up [m].

    Parameters
    ----------
    position, origin : ndarray, shape (..., 3)
        Latitude [rad], longitude [rad], height [m].

    Returns
    -------
    ndarray, shape (..., 3)
    """
    latitude, height = origin[..., 0], origin[..., 2]
    meridian, prime_vertical = radii(latitude)
    turn = (position[..., 1] - origin[..., 1] + np.pi) % (2 * np.pi) - np.pi
    east = turn * (prime_vertical + height) * np.cos(latitude)
    north = (position[..., 0] - latitude) * (meridian + height)
    return np.stack((east, north, position[..., 2] - height), axis=-1)


def displaced(origin: Array, displacement: Array) -> Array:
    """The position that lies nearby, east, north, up [m] of another; shapes as of `displacement`."""
    latitude, height = origin[..., 0], origin[..., 2]
    meridian, prime_vertical = radii(latitude)
    east, north, up = np.moveaxis(displacement, -1, 0)
    longitude = origin[..., 1] + east / ((prime_vertical + height) * np.cos(latitude))
    return np.stack((latitude + north / (meridian + height), longitude, height + up), axis=-1)
