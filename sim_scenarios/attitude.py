"""Attitude: Euler angles, direction cosine matrices and misalignment.

`C_bn` maps body (right, forward, up) to navigation (east, north, up). Heading is clockwise from north, pitch
about the right axis (bow up), roll about the forward axis (right side down).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def dcm(roll: ArrayLike, pitch: ArrayLike, heading: ArrayLike) -> Array:
    """C_bn of Euler angles [rad], each of shape (...) -> (..., 3, 3)."""
    angles = np.broadcast_arrays(roll, pitch, heading)
    (sr, cr), (sp, cp), (sh, ch) = ((np.sin(angle), np.cos(angle)) for angle in angles)
    rows = (
        (ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr),
        (ch * sp * sr - sh * cr, ch * cp, -sh * sr - ch * sp * cr),
        (-cp * sr, sp, cp * cr),
    )
    return np.stack([element for row in rows for element in row], axis=-1).reshape(*sr.shape, 3, 3)


def euler_angles(C_bn: Array) -> tuple[float, float, float]:
    """Roll, pitch, heading [rad] of one C_bn, shape (3, 3); heading in [0, 2 pi)."""
    minus_heading, pitch, roll = Rotation.from_matrix(C_bn).as_euler("ZXY")
    return float(roll), float(pitch), float(-minus_heading % (2 * np.pi))


def misalignment(phi: ArrayLike) -> Array:
    """Matrix from the true to a misaligned navigation frame, C_n^{n'} (Zhao 2012, eqs. 1 and 2).

    C_n^{n'} = C_y C_x C_z, passive rotations.

    Parameters
    ----------
    phi : array_like, shape (3,)
        Rotation about east, north, up [rad], applied up, east, north in turn. A positive rotation about up
        makes the heading in n' larger than the true one.

    Returns
    -------
    ndarray, shape (3, 3)
    """
    east, north, up = np.asarray(phi, dtype=float)
    passive: Array = Rotation.from_euler("ZXY", [up, east, north]).inv().as_matrix()
    return passive


def wrap(angle: ArrayLike) -> Array:
    """Angles wrapped to [-pi, pi) [rad]."""
    wrapped: Array = (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi
    return wrapped


def misalignment_angles(C_n_computed: Array) -> Array:
    """Rotations about east, north, up [rad] of C_n^{n'}, the inverse of `misalignment`.

    Shape (..., 3, 3) -> (..., 3).
    """
    C = C_n_computed
    east = np.arcsin(np.clip(C[..., 1, 2], -1, 1))
    north = np.arctan2(-C[..., 0, 2], C[..., 2, 2])
    up = np.arctan2(-C[..., 1, 0], C[..., 1, 1])
    angles: Array = np.stack((east, north, up), axis=-1)
    return angles


def skew(vector: Array) -> Array:
    """Cross-product matrices of vectors, shape (..., 3) -> (..., 3, 3)."""
    matrix = np.zeros((*vector.shape, 3))
    x, y, z = np.moveaxis(vector, -1, 0)
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -z, y, -x
    return matrix - np.swapaxes(matrix, -1, -2)


def right_jacobian(rotation: Array) -> Array:
    """J_r, which makes the body rate of the derivative of a rotation vector: w = J_r(y) dy/dt.

    Shape (..., 3) -> (..., 3, 3).
    """
    angle2 = np.sum(rotation**2, axis=-1)[..., None, None]
    angle = np.sqrt(np.maximum(angle2, 1e-6))
    small = angle2 < 1e-6  # two terms of the series are exact to double precision, and safe at zero
    first = np.where(small, 0.5 - angle2 / 24, 2 * np.sin(0.5 * angle) ** 2 / angle**2)
    second = np.where(small, 1 / 6 - angle2 / 120, (angle - np.sin(angle)) / angle**3)
    cross = skew(rotation)
    jacobian: Array = np.eye(3) - first * cross + second * cross @ cross
    return jacobian
