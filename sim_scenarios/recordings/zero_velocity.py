"""Fixes of a vehicle that stands, made up in the place of a receiver's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.feed import before_first
from sim_scenarios.recordings.tables import FixTable, ImuTable
from sim_scenarios.units import DEGREE


@dataclass(frozen=True)
class ZeroVelocity:
    """Fixes of a vehicle that stands: latitude [deg], longitude [deg], height [m]; sigma [m/s], rate [Hz]."""

    position: tuple[float, float, float]
    sigma: float = 0.02
    rate: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what is no quantity."""
        for name, value in vars(self).items():
            if not np.isfinite(value).all():
                raise InputError(f"{name} = {value}: must be finite")
        if self.rate <= 0 or self.sigma <= 0:
            raise InputError("zero-velocity fixes need a rate and a sigma greater than 0")

    def fixes(self, imu: ImuTable) -> FixTable:
        """Fixes from the start of an IMU's samples to their end.

        Raises
        ------
        InputError
            When the fixes come faster than the samples.
        """
        period = stamps.period(imu.time)
        if self.rate * period > 1 + 1e-6:
            raise InputError(
                f"rate = {self.rate:g} Hz: must be at most that of the recording, {1 / period:g} Hz"
            )
        start = before_first(imu)
        time = start + np.arange(np.floor((imu.time[-1] - start) * self.rate + 1e-6) + 1) / self.rate
        latitude, longitude, height = self.position
        shape = (len(time), 3)
        return FixTable(
            time=time,
            position=np.broadcast_to([latitude * DEGREE, longitude * DEGREE, height], shape),
            velocity=np.zeros(shape),
            position_sigma=np.zeros(shape),
            velocity_sigma=np.full(shape, self.sigma),
        )
