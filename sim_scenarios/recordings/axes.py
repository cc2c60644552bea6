"""Axes of an IMU, and the way from them to right, forward, up.

A convention is three directions, first, second and third axis: "forward-right-down", or FRD. A mounting is a
matrix that takes vectors from the sensor's own axes into those of the convention.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.tables import Array

BODY: Final = "right-forward-up"
DIRECTIONS: Final = {
    "right": (1.0, 0.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
    "forward": (0.0, 1.0, 0.0),
    "backward": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}
_BY_LETTER: Final = {name[0].upper(): name for name in DIRECTIONS}
LARGEST_SKEW: Final = 0.02
"""How far a mounting may be from a rotation: it is printed with few digits, or holds scale factors."""


def conversion(convention: str, mounting: Sequence[Sequence[float]] | None = None) -> Array:
    """Matrix from the sensor's axes to right, forward, up.

    Parameters
    ----------
    convention : str
        Which way the axes point into which `mounting` leads; without a mounting, the sensor's own.
    mounting : sequence, shape (3, 3), optional
        From the sensor's axes to those of the convention.

    Returns
    -------
    ndarray, shape (3, 3)

    Raises
    ------
    InputError
        If the convention is none or left-handed, or the mounting is no rotation.
    """
    to_body: Array = np.array([DIRECTIONS[name] for name in _names(convention)]).T
    if abs(np.linalg.det(to_body)) < 0.5:
        raise InputError(
            f"axes = '{convention}': must have one of right or left, forward or backward, up or down"
        )
    if np.linalg.det(to_body) < 0:
        raise InputError(f"axes = '{convention}': is left-handed")
    if mounting is None:
        return to_body
    matrix = np.array(mounting, dtype=float)
    skew = float(np.abs(matrix @ matrix.T - np.eye(3)).max())
    if not skew <= LARGEST_SKEW:
        raise InputError(
            f"mounting: must be a rotation; its rows' products differ by {skew:.3g} from those of one, where "
            f"{LARGEST_SKEW:g} is allowed"
        )
    if np.linalg.det(matrix) < 0:
        raise InputError("mounting: must be a rotation, and it mirrors: its determinant is -1")
    result: Array = to_body @ matrix
    return result


def _names(convention: str) -> list[str]:
    names = convention.split("-") if "-" in convention else [_BY_LETTER.get(c, c) for c in convention]
    if len(names) != 3 or not set(names) <= set(DIRECTIONS):
        raise InputError(
            f"axes = '{convention}': must be three of {', '.join(DIRECTIONS)}, such as '{BODY}' or 'FRD'"
        )
    return names
