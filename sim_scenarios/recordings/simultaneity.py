"""Whether what bears the same stamp was so at the same time: velocities and positions, an IMU and fixes.

Receivers smooth their velocities, and hosts stamp samples when they arrive: both are late by a tenth of a
second now and then, at 15 m/s more than a metre. It shows in how well one goes with the other. Velocities u
of fixes that held s later than stamped go with positions p if

    p(t) = integral of u until t - s, and a constant.

An IMU whose samples held s later than stamped goes with the velocities v of an antenna at the lever arm l if,
whatever its axes, its attitude and its biases are,

    v(t) = A V(t - s) + polynomial of t,    V = integral of C f, and C (w x l),

with C the attitude from the beginning of a window on, as the gyros w say. Over a window, A and the polynomial
are those of least squares. The lag is the one that is most likely for all windows: each component in each
window has a noise of its own, so that with m fixes in it its loss is m / 2 times the logarithm of the sum of
squares that is left. The sigma follows from how the gradient scatters from window to window.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios.earth import displacement
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.fixes import velocities
from sim_scenarios.recordings.tables import Array, FixTable, ImuTable

WINDOW: Final = 10.0
"""Length of a window [s]: gyros of any grade keep the attitude so long."""
LEAST_FIXES: Final = 15
"""In a window, which is longer where there were fewer."""
WINDOWS: Final = (12, 60)
"""Least and largest number of windows; of more, those in which the velocity changes most are looked at."""
LEAST_CHANGE: Final = 0.2
"""Root mean square of the changes of velocity from fix to fix in a window, per second [m/s2]."""
LONGEST: Final = 0.5
"""Lag that is looked for [s]; what is later contradicts physics, see `checks`."""
STEP: Final = 0.02
"""Of the search [s]."""
SPANS: Final = {"velocities": 0.015, "imu": 0.06}
"""Lags about the best over which a parabola is laid [s]; on shorter ones vibration makes the loss rough."""
ROUNDS: Final = 5
FACTOR: Final = 3.3
"""Sigmas that a lag must have to be told: one in a thousand is by chance."""
EVIDENCE: Final = (3.0, 2.0)
"""By how much a lag must be likelier than those at the ends of the search: logarithm of the likelihood in an
average window, and standard deviations of that mean. Noise alone has its best lag anywhere."""
LEAST: Final = 0.03
"""Lag that is worth being told [s]; what is less is within what sensors and receivers do."""
EXACT: Final = 1e-6
"""What is left of a component in a window [m], [m/s] counts as no less than this."""


@dataclass(frozen=True)
class Lag:
    """How much later than stamped something held [s], and the sigma."""

    value: float
    sigma: float

    @property
    def is_certain(self) -> bool:
        """Whether it is not by chance, and worth being told."""
        return abs(self.value) > max(LEAST, FACTOR * self.sigma)


def of_velocities(gnss: FixTable) -> Lag | None:
    """Lag of the velocities of fixes behind their positions; None where nothing shows it.

    Components that are never measured, such as the vertical one of NMEA, are left out.
    """
    up = np.isfinite(gnss.position[:, 2]).any() and np.isfinite(gnss.velocity[:, 2]).any()
    axes = slice(3 if up else 2)
    known = np.isfinite(np.hstack((gnss.position[:, axes], gnss.velocity[:, axes]))).all(axis=1)
    time, said = gnss.time[known], gnss.velocity[known][:, axes]
    rows = _windows(time, said)
    if len(rows) < WINDOWS[0]:
        return None
    place = np.nan_to_num(gnss.position[known])
    way = displacement(place, place[:1])[:, axes]
    middles = (said[1:] + said[:-1]) / 2 * np.diff(time)[:, None]
    from scipy.interpolate import CubicHermiteSpline  # slow

    summed = CubicHermiteSpline(time, np.concatenate((0 * said[:1], np.cumsum(middles, axis=0))), said)
    constant = np.ones((*rows.shape, 1))

    def left(lag: float) -> Array:
        return _without(way[rows] - summed(time[rows] - lag), constant)

    return _most_likely(left, SPANS["velocities"])


def of_imu(imu: ImuTable, gnss: FixTable, lever_arm: tuple[float, float, float]) -> Lag | None:
    """Lag of an IMU behind the fixes of an antenna; None where nothing shows it.

    Parameters
    ----------
    imu : ImuTable
        Of which whole windows without gaps are used.
    gnss : FixTable
        With velocities that held at their stamps.
    lever_arm : tuple of float
        From the IMU to the antenna, in its axes [m].
    """
    if not ((np.diff(imu.time) > 0).all() and (np.diff(gnss.time) > 0).all()):
        return None
    velocity = velocities(gnss)
    known = np.isfinite(velocity).all(axis=1)
    known &= (gnss.time > imu.time[0] + 2 * LONGEST) & (gnss.time < imu.time[-1] - 2 * LONGEST)
    time, velocity = gnss.time[known], velocity[known]
    rows = _windows(time, velocity)
    if len(rows) < WINDOWS[0]:
        return None
    longest = float(np.max(time[rows[:, -1]] - time[rows[:, 0]])) + 3 * LONGEST
    first = np.searchsorted(imu.time, time[rows[:, 0]] - 1.5 * LONGEST)
    samples = first[:, None] + np.arange(int(longest / stamps.period(imu.time)) + 2)
    samples = np.minimum(samples, len(imu.time) - 1)
    steady = ~stamps.gaps(imu.time)[samples].any(axis=1)
    steady &= np.isfinite(imu.delta_angle + imu.delta_velocity)[samples].all(axis=(1, 2))
    rows, samples = rows[steady], samples[steady]
    if len(rows) < WINDOWS[0]:
        return None
    clock, felt = imu.time[samples], _felt(imu, samples, np.array(lever_arm))
    since = (time[rows] - time[rows[:, :1]])[..., None] / WINDOW
    polynomial = np.concatenate((since**0, since, since**2), axis=-1)

    def left(lag: float) -> Array:
        at = time[rows] - lag
        moved = np.array([[np.interp(t, c, v) for v in f.T] for t, c, f in zip(at, clock, felt, strict=True)])
        return _without(velocity[rows], np.concatenate((np.swapaxes(moved, 1, 2), polynomial), axis=-1))

    return _most_likely(left, SPANS["imu"])


def _felt(imu: ImuTable, samples: NDArray[np.int64], lever_arm: Array) -> Array:
    """Velocity of the antenna but for gravity, in axes that do not turn, from each window's beginning on.

    Of samples of shape (w, k); shape (w, k, 3).
    """
    turns = Rotation.from_rotvec(imu.delta_angle[samples].reshape(-1, 3)).as_matrix()
    turns = turns.reshape(*samples.shape, 3, 3)
    C = np.empty_like(turns)
    C[:, 0] = np.eye(3)
    for k in range(1, samples.shape[1]):
        C[:, k] = C[:, k - 1] @ turns[:, k]
    rate = imu.delta_angle[samples] / stamps.intervals(imu.time)[samples][..., None]
    middle = (C + np.roll(C, 1, axis=1)) / 2
    middle[:, 0] = C[:, 0]
    force = np.cumsum((middle @ imu.delta_velocity[samples][..., None])[..., 0], axis=1)
    arm: Array = (C @ np.cross(rate, lever_arm)[..., None])[..., 0]
    return force + arm


def _windows(time: Array, velocity: Array) -> NDArray[np.int64]:
    """Rows of the fixes of windows without gaps, shape (windows, fixes); none if stamps stand still."""
    if len(time) < LEAST_FIXES or not (np.diff(time) > 0).all():
        return np.empty((0, 0), dtype=np.int64)
    size = max(round(WINDOW / stamps.period(time)), LEAST_FIXES)
    rows = np.arange(0, len(time) - size + 1, size)[:, None] + np.arange(size)
    rows = rows[~stamps.gaps(time)[rows[:, 1:]].any(axis=1)]
    rows = rows[time[rows[:, -1]] - time[rows[:, 0]] <= 2 * WINDOW]
    change = np.linalg.norm(np.diff(velocity[rows], axis=1), axis=2) / np.diff(time[rows], axis=1)
    size_of_change = np.sqrt(np.mean(change**2, axis=1))
    most = np.sort(np.argsort(size_of_change)[::-1][: WINDOWS[1]])
    chosen: NDArray[np.int64] = rows[most[size_of_change[most] > LEAST_CHANGE]]
    return chosen


def _without(target: Array, regressors: Array) -> Array:
    """Targets without what regressors explain, window by window."""
    Q = np.linalg.qr(regressors)[0]
    rest: Array = target - Q @ (np.swapaxes(Q, 1, 2) @ target)
    return rest


def _most_likely(left: Callable[[float], Array], span: float) -> Lag | None:
    """Lag that leaves the likeliest residuals, of shape (windows, fixes, axes).

    None if it is beyond the search, or no likelier than one at its ends.
    """

    def losses(lag: float) -> Array:
        rest = left(lag)
        of_windows: Array = rest.shape[1] / 2 * np.log(np.mean(rest**2, axis=1) + EXACT**2).sum(axis=1)
        return of_windows

    lags = STEP * np.arange(-round(LONGEST / STEP), round(LONGEST / STEP) + 1)
    at = float(min(lags, key=lambda lag: losses(float(lag)).sum()))
    around = np.linspace(-span, span, 7)
    for _ in range(ROUNDS):
        near = np.array([losses(at + off) for off in around])
        half_curvature, gradient, _ = np.polyfit(around, near, 2)
        if half_curvature.sum() <= 0 or abs(at) >= LONGEST:
            return None
        at -= float(gradient.sum() / (2 * half_curvature.sum()))
    best, (least, deviations) = losses(at), EVIDENCE
    for end in (-LONGEST, LONGEST):
        more = losses(end) - best
        if more.mean() < max(least, deviations * more.std(ddof=1) / np.sqrt(len(more))):
            return None
    if abs(at) >= LONGEST:
        return None
    return Lag(at, float(np.linalg.norm(gradient - gradient.mean()) / (2 * half_curvature.sum())))
