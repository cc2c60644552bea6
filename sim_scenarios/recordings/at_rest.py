"""What a stretch at rest says of the sensors: Allan deviations, and the noises that explain them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from sim_scenarios.recordings import noise_fit
from sim_scenarios.recordings.allan import CONFIDENCE, AllanCurve, allan_curve
from sim_scenarios.recordings.noise_fit import NoiseFit
from sim_scenarios.recordings.stretches import Stretch

Array = NDArray[np.float64]

SENSORS: Final = ("gyro", "accelerometer")


@dataclass(frozen=True)
class SensorAtRest:
    """A triad at rest; u is rad for gyros, m/s for accelerometers.

    Attributes
    ----------
    curves : tuple of AllanCurve
        Of the axes right, forward, up.
    joint : NoiseFit
        Of the noises that the axes share.
    axes : tuple of NoiseFit
        Of each axis alone: the same model if the axes are alike, else the best of each.
    alike : bool
        Whether the likelihoods do not contradict that the axes share their noises.
    mean : ndarray, shape (3,)
        Mean rate or force [u/s].
    """

    curves: tuple[AllanCurve, ...]
    joint: NoiseFit
    axes: tuple[NoiseFit, ...]
    alike: bool
    mean: Array

    @property
    def told(self) -> tuple[NoiseFit, ...]:
        """What holds: the joint noises if the axes are alike, else those of each."""
        return (self.joint,) if self.alike else self.axes


@dataclass(frozen=True)
class AtRest:
    """Both triads over a stretch from one time to another [s]."""

    begin: float
    end: float
    sensors: dict[str, SensorAtRest]


def at_rest(stretch: Stretch) -> AtRest:
    """Noises of the sensors of a vehicle that stands."""
    increments = (stretch.imu.delta_angle, stretch.imu.delta_velocity)
    sensors = {
        name: _sensor(values, stretch.period) for name, values in zip(SENSORS, increments, strict=True)
    }
    return AtRest(stretch.begin, stretch.end, sensors)


def _sensor(increments: Array, period: float) -> SensorAtRest:
    rates, h = noise_fit.block_means(increments, period)
    joint = noise_fit.fit(rates, h)
    axes = tuple(noise_fit.fit(axis[:, None], h, [joint.model]) for axis in rates.T)
    gain = 2 * (joint.loss - sum(axis.loss for axis in axes))
    alike = bool(gain < chi2.ppf(CONFIDENCE, (len(axes) - 1) * len(joint.estimates)))
    return SensorAtRest(
        curves=tuple(allan_curve(axis, period) for axis in increments.T),
        joint=joint,
        axes=axes if alike else tuple(noise_fit.fit(axis[:, None], h) for axis in rates.T),
        alike=alike,
        mean=increments.mean(axis=0) / period,
    )
