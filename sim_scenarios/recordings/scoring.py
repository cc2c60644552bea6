"""Maxima of likelihoods by damped scoring: Newton steps with the expected second derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Loss(NamedTuple):
    """Negative logarithm of a likelihood at a point of p parameters.

    Attributes
    ----------
    value : float
    gradient : ndarray, shape (p,)
    information : ndarray, shape (p, p)
        Expectation of the second derivatives.
    """

    value: float
    gradient: Array
    information: Array


def descend(
    loss: Callable[[Array], Loss],
    start: Array,
    low: Array,
    high: Array,
    *,
    fixed: int | None = None,
    gain: float = 1e-6,
    longest: float = 2.0,
) -> tuple[Array, Loss]:
    """Least loss from a start on, within bounds.

    Parameters
    ----------
    loss : callable
        Loss at a point.
    start : ndarray, shape (p,)
        Put within the bounds.
    low, high : ndarray, shape (p,)
        The bounds.
    fixed : int, optional
        Parameter that stays as it is.
    gain : float
        The descent ends where a step promises, or has brought, less.
    longest : float
        Step of any parameter.

    Returns
    -------
    tuple of ndarray and Loss
        The point, and the loss there.
    """
    at = np.clip(start, low, high)
    here = loss(at)
    damping = 1e-3
    while damping < 1e6:
        free = ~((at <= low) & (here.gradient > 0) | (at >= high) & (here.gradient < 0))
        free[[] if fixed is None else fixed] = False
        matrix = here.information[np.ix_(free, free)]
        matrix += np.diag(damping * np.diag(matrix) + 1e-9)
        step = np.zeros_like(at)
        step[free] = -np.linalg.solve(matrix, here.gradient[free])
        if -here.gradient @ step / 2 < gain:
            break
        there = np.clip(at + np.clip(step, -longest, longest), low, high)
        candidate = loss(there)
        if candidate.value > here.value:
            damping *= 10
            continue
        gained = here.value - candidate.value
        at, here = there, candidate
        damping /= 10
        if gained < gain:
            break
    return at, here
