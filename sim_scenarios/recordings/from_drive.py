"""What a drive says of fixes and sensors: the sigmas with which the innovations of a filter are most likely.

With innovations e of sigma s, as a filter predicts it, the loss over the logarithms of the parameters is

    sum over fixes and components of  ln s + e^2 / (2 s^2).

Its derivatives are taken by replays with each parameter a little larger. The components of a fix are taken as
if they were independent: the estimates stay unbiased, and the intervals come from how the gradient scatters
from one piece of the drive to the next (a sandwich), so that they hold for innovations that are correlated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import binom, norm
from scipy.stats import t as student

from sim_scenarios.cosimulation import Progress
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings.allan import CONFIDENCE
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.fixes import selected, velocities
from sim_scenarios.recordings.noise_fit import CHANCE, Estimate
from sim_scenarios.recordings.replay import replay as replayed
from sim_scenarios.recordings.scoring import Loss, descend
from sim_scenarios.recordings.stamps import period
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.tables import FixTable, ImuTable, Recording
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

FACTORS: Final[Mapping[str, float]] = {
    "measurement.position_sigma": 1.0,
    "measurement.height_sigma": 1.0,
    "measurement.velocity_sigma": 0.2,
    "process.angle_random_walk": 5e-4,
    "process.velocity_random_walk": 1e-2,
}
"""Parameters that are sought, and from where [SI]: rather too large, so that no filter is lost."""
PRIORS: Final[Mapping[str, float]] = {
    "prior.gyro_bias_sigma": 0.2 * DEGREE,
    "prior.accelerometer_bias_sigma": 0.2,
}
"""Of a sensor of which nothing is known [SI]."""
FILTER: Final[Mapping[str, object]] = {
    "error_model": "loose",
    "predictor": "linearised",
    "corrector": "standard",
    "gate.enabled": False,
}
COURSE_ABOVE: Final = 3.0
"""Speed from which on the course is a heading to start with [m/s]."""
FIX_SPACING: Final = 3.0
"""Least time between fixes that are used [s]: errors of fixes, and of a sensor that is shaken, are alike for
a second or so, and noise as a filter takes it only over longer times."""
IMU_SPACING: Final = 0.05
"""Increments are joined to intervals of about this length, for speed [s]."""
SETTLING: Final = 60.0
"""Time after the start whose innovations show the prior rather than the noise [s]."""
FEWEST: Final = 100
"""Fixes that are needed after it."""
PIECES: Final = 30
"""Of the drive, over which the gradient scatters."""
_RANGE: Final = 1e4
_LITTLE: Final = 0.05
"""Step of a logarithm for a derivative."""
_UNSEEN: Final = 1.0
"""Sigma of a logarithm from which on a parameter has not been seen."""


class ShortDriveError(InputError):
    """A drive has too few fixes to tell noises."""


@dataclass(frozen=True)
class Innovations:
    """Of one replay.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Of the fixes [s].
    residual, sigma : ndarray, shape (n, m)
        Innovations and their sigmas in SI units; a sigma of 0 means not measured.
    """

    time: Array
    residual: Array
    sigma: Array

    @property
    def standardised(self) -> Array:
        """Innovations over their sigmas, of what was measured, shape (k,)."""
        measured = self.sigma > 0
        ratio: Array = self.residual[measured] / self.sigma[measured]
        return ratio

    @property
    def tail(self) -> float:
        """Factor on the sigmas with which as many innovations are beyond 3 of them as of Gaussian ones.

        1 unless there are more by more than chance: a gate would refuse too many fixes.
        """
        sizes, share = np.abs(self.standardised), 2 * norm.sf(3.0)
        beyond = int(np.count_nonzero(sizes > 3.0))
        if binom.sf(beyond - 1, len(sizes), share) > CHANCE:
            return 1.0
        return float(np.quantile(sizes, 1 - share)) / 3.0


Replay = Callable[[Mapping[str, float]], Innovations]
"""Innovations of a filter with parameters by name [SI]; of the same fixes whatever the parameters."""


@dataclass(frozen=True)
class DriveFit:
    """Most likely parameters.

    Attributes
    ----------
    estimates : dict of str to Estimate
        In SI units, by name of parameter. With a lower end of 0 the innovations do not show it.
    innovations : Innovations
        With these parameters.
    loss : float
        Negative logarithm of their likelihood.
    """

    estimates: dict[str, Estimate]
    innovations: Innovations
    loss: float


def fit(replay: Replay, start: Mapping[str, float], progress: Progress = lambda _: None) -> DriveFit:
    """Parameters with which the innovations are most likely.

    Parameters
    ----------
    replay : callable
        See `Replay`.
    start : mapping of str to float
        Parameters to be sought, and where to begin.
    progress : callable
        Called with a rough share of the work.
    """
    names, begin = list(start), np.log(list(start.values()))
    rounds = 0

    def innovations(at: Array) -> Innovations:
        return replay(dict(zip(names, np.exp(at).tolist(), strict=True)))

    def pieces(at: Array) -> tuple[Array, Array, Array]:
        """Losses and gradients of every fix, and the information."""
        here = innovations(at)
        measured = here.sigma > 0
        e, s = here.residual, np.where(measured, here.sigma, 1.0)
        by_e, by_log_s = np.zeros((2, len(names), *e.shape))
        for i in range(len(names)):
            there = innovations(at + _LITTLE * np.eye(len(names))[i])
            by_e[i] = (there.residual - e) / _LITTLE
            by_log_s[i] = np.log(np.where(measured, there.sigma, 1.0) / s) / _LITTLE
        by_e, z = np.where(measured, by_e / s, 0.0), np.where(measured, e / s, 0.0)
        losses = np.sum(np.log(s) + z**2 / 2, axis=1)
        gradients = np.sum(by_log_s * (measured - z**2) + by_e * z, axis=2)
        information = 2 * np.einsum("ikc,jkc->ij", by_log_s, by_log_s) + np.einsum("ikc,jkc->ij", by_e, by_e)
        return losses, gradients, information

    def loss(at: Array) -> Loss:
        nonlocal rounds
        losses, gradients, information = pieces(at)
        rounds += 1
        progress(1 - 0.8**rounds)
        return Loss(float(losses.sum()), gradients.sum(axis=1), information)

    low, high = begin - np.log(_RANGE), begin + np.log(_RANGE)
    at, _ = descend(loss, begin, low, high, gain=0.05, longest=1.5)
    losses, gradients, information = pieces(at)
    scatter = np.array([part.sum(axis=1) for part in np.array_split(gradients, PIECES, axis=1)])
    inverse = np.linalg.inv(information + 1e-9 * np.eye(len(names)))
    sigma = np.sqrt(np.diag(inverse @ (scatter.T @ scatter) @ inverse))
    sigma = np.maximum(sigma, np.sqrt(np.diag(inverse)))
    width = student.ppf((1 + CONFIDENCE) / 2, PIECES - 1) * np.where(sigma < _UNSEEN, sigma, np.inf)
    estimates = {
        name: Estimate(*np.exp([value, value - reach, value + reach]).tolist())
        for name, value, reach in zip(names, at, width, strict=True)
    }
    progress(1.0)
    return DriveFit(estimates, innovations(at), float(losses.sum()))


@dataclass(frozen=True)
class FromDrive:
    """What a drive from one time to another [s] says.

    Attributes
    ----------
    fit : DriveFit
        Of `FACTORS`.
    biases : dict of str to ndarray, shape (2, 3)
        Bias at the end of each axis of "gyro" and "accelerometer", and its sigma [SI].
    believes : bool
        Whether the innovations are likelier with the sigmas that fixes tell, raised where they are below
        those of `fit`, than with those of `fit` alone. False where fixes tell none.
    """

    begin: float
    end: float
    fit: DriveFit
    biases: dict[str, Array]
    believes: bool


def moves(recording: Recording) -> bool:
    """Whether some fix is fast enough for its course to be a heading to start with."""
    if recording.gnss is None:
        return False
    speed = np.linalg.norm(velocities(recording.gnss)[:, :2], axis=1)
    return bool(np.any(speed >= COURSE_ABOVE))


def from_drive(
    recording: Recording,
    start: Start | None = None,
    *,
    told: Mapping[str, float] | None = None,
    progress: Progress = lambda _: None,
    fmus: Fmus | None = None,
) -> FromDrive:
    """Noise of fixes and sensors on a drive.

    Parameters
    ----------
    recording : Recording
        With fixes. What they say of their own sigmas counts where the innovations are likelier with it.
    start : Start, optional
        By default with the course of the first fix that is fast enough.
    told : mapping of str to float, optional
        Other parameters of the NavigationFilter [SI].
    progress : callable
        Called with a rough share of the work.
    fmus : Fmus, optional
        Those that are loaded already.

    Raises
    ------
    InputError
        When there are too few fixes, or the filter cannot start.
    """
    if recording.gnss is None:
        raise InputError(f"{recording.name}: has no fixes, and only they tell of a drive")
    gnss = _spaced(recording.gnss)
    variants = [_untold(gnss), gnss] if gnss.position_sigma.any() or gnss.velocity_sigma.any() else [gnss]
    recording = replace(recording, imu=_joined(recording.imu), reference=None)
    start, fmus = start or Start(course_above=COURSE_ABOVE), fmus or Fmus()
    settings = {**FILTER, **PRIORS, **(told or {})}
    drives = [_Drive(replace(recording, gnss=variant), start, settings, fmus) for variant in variants]

    def of_part(i: int) -> Progress:
        return lambda done: progress((i + done) / len(drives))

    fits = [fit(drive.innovations, FACTORS, of_part(i)) for i, drive in enumerate(drives)]
    best = min(range(len(fits)), key=lambda i: fits[i].loss)
    data = drives[best].run({name: estimate.value for name, estimate in fits[best].estimates.items()})
    biases = {
        sensor: np.array([data[f"{sensor}_bias{of}"].values[-1] for of in ("", "_sigma")])
        for sensor in ("gyro", "accelerometer")
    }
    time = fits[best].innovations.time
    return FromDrive(float(time[0]), float(time[-1]), fits[best], biases, best > 0)


@dataclass(frozen=True)
class _Drive:
    """A recording through the filter."""

    recording: Recording
    start: Start
    settings: Mapping[str, object]
    fmus: Fmus

    def run(self, parameters: Mapping[str, float]) -> xr.Dataset:
        """Replay; the start is known as well as the worst fix."""
        gnss = self.recording.gnss
        worst = np.zeros(3) if gnss is None else np.max(gnss.position_sigma, axis=0)
        prior = {
            f"prior.{name}": max(parameters[f"measurement.{name}"], float(np.max(sigma)))
            for name, sigma in (("position_sigma", worst[:2]), ("height_sigma", worst[2:]))
        }
        told = {**prior, **self.settings, **parameters}
        return replayed(self.recording, self.start, filter=Filter.navigation, set=told, fmus=self.fmus)

    def innovations(self, parameters: Mapping[str, float]) -> Innovations:
        """After the settling."""
        data = self.run(parameters)
        time = data["fix_time"].values
        settled = time > float(data["time"].values[0]) + SETTLING
        if np.count_nonzero(settled) < FEWEST:
            raise ShortDriveError(
                f"{self.recording.name}: the drive from {data['time'].values[0]:g} s on has "
                f"{np.count_nonzero(settled)} fixes, {FIX_SPACING:g} s apart, after {SETTLING:g} s of it; "
                f"at least {FEWEST} are needed"
            )
        residual, sigma = (data[name].values[settled] for name in ("innovation", "innovation_sigma"))
        return Innovations(time[settled], residual, sigma)


def _untold(gnss: FixTable) -> FixTable:
    """Fixes without sigmas of their own."""
    nothing = np.zeros_like(gnss.position_sigma)
    return replace(gnss, position_sigma=nothing, velocity_sigma=nothing)


def _spaced(gnss: FixTable) -> FixTable:
    """Fixes with some time between them."""
    chosen, last = np.zeros(len(gnss.time), dtype=bool), -np.inf
    for row, time in enumerate(gnss.time.tolist()):
        if time > last + FIX_SPACING * (1 - 1e-3):
            chosen[row], last = True, time
    return selected(gnss, chosen)


def _joined(imu: ImuTable) -> ImuTable:
    """Increments over longer intervals."""
    size = max(1, round(IMU_SPACING / period(imu.time)))
    groups = len(imu.time) // size

    def summed(increments: Array) -> Array:
        total: Array = increments[: groups * size].reshape(groups, size, 3).sum(axis=1)
        return total

    time = imu.time[size - 1 : groups * size : size]
    return ImuTable(time, summed(imu.delta_angle), summed(imu.delta_velocity))
