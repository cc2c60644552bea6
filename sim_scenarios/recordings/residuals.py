"""What a recording at rest holds besides its mean: the noise of the sensors, and what shakes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps
from sim_scenarios.recordings.description import load

Array = NDArray[np.float64]


def residuals(path: Path, period: float, span: float) -> dict[str, Array]:
    """What the increments of a recording at rest have besides their mean over a span of time.

    Of a vehicle that stands it is the noise of the sensors and what shakes them, without biases, the Earth
    and what changes more slowly than over the span.

    Parameters
    ----------
    path : Path
        Of what `recordings.load` reads.
    period : float
        Of the samples [s]; a recording with another one is refused.
    span : float
        [s]

    Returns
    -------
    dict of str to ndarray, shape (samples,)
        By the names of the IMU's signals.
    """
    imu = load(path).imu
    found = stamps.period(imu.time)
    if abs(found - period) > 1e-3 * period:
        raise InputError(f"{path}: a sample every {found:g} s, where {period:g} s are needed")
    names = [f"imu.delta_{kind}[{i}]" for kind in ("angle", "velocity") for i in (1, 2, 3)]
    increments = pd.DataFrame(np.hstack((imu.delta_angle, imu.delta_velocity)), columns=names)
    rest = increments - increments.rolling(round(span / period), center=True, min_periods=1).mean()
    return {name: rest[name].to_numpy() for name in names}
