"""Conventions of axes and mountings."""

from __future__ import annotations

import numpy as np
import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.axes import conversion

MOUNTING = [[-0.98866, -0.092586, 0.118231], [-0.093239, 0.995644, 0.0], [-0.117716, -0.011024, -0.992986]]


@pytest.mark.parametrize(
    ("convention", "vector", "body"),
    [
        ("right-forward-up", [1, 2, 3], [1, 2, 3]),
        ("forward-right-down", [1, 2, 3], [2, 1, -3]),
        ("FRD", [1, 2, 3], [2, 1, -3]),
        ("forward-left-up", [1, 2, 3], [-2, 1, 3]),
        ("backward-right-up", [1, 2, 3], [2, -1, 3]),
        ("up-right-forward", [1, 2, 3], [2, 3, 1]),
    ],
)
def test_a_vector_goes_where_its_axes_point(convention: str, vector: list[int], body: list[int]) -> None:
    np.testing.assert_array_equal(conversion(convention) @ vector, body)


def test_a_mounting_leads_into_the_convention() -> None:
    """The matrix of a car's IMU, whose x points back and z up; the convention is that of the car."""
    body = conversion("forward-right-down", MOUNTING)
    forward, right, down = np.array(MOUNTING) @ [0.1, 0.2, 9.8]
    np.testing.assert_allclose(body @ [0.1, 0.2, 9.8], [right, forward, -down])
    assert (body @ [0, 0, 1])[2] > 0.99


@pytest.mark.parametrize(
    ("convention", "mounting", "words"),
    [
        ("forward-right-up", None, "is left-handed"),
        ("right-left-up", None, "must have one of right or left"),
        ("north-east-down", None, "must be three of right, left"),
        ("XYZ", None, "must be three of"),
        ("FRD", np.eye(3) * 1.1, r"must be a rotation; its rows' products differ by 0\.21"),
        ("FRD", np.diag([1.0, 1.0, -1.0]), "mirrors"),
        ("FRD", np.full((3, 3), np.nan), "must be a rotation"),
    ],
)
def test_what_is_no_rotation_is_refused(convention: str, mounting: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        conversion(convention, mounting)
