"""Pictures of sensors at rest: measured Allan deviations, and those of the noises that were found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from sim_scenarios.plots.style import BODY_AXES, COLOURS, INK, figure
from sim_scenarios.recordings.allan import allan_deviation
from sim_scenarios.recordings.at_rest import AtRest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS: Final = {"gyro": "rad/s", "accelerometer": "m/s2"}


def allan(rest: AtRest) -> Figure:
    """Allan deviation of each axis with its 95 % interval, and that of the fitted noises."""
    with figure(rows=1, columns=2, height=4.6) as (drawn, panels):
        for axes, (sensor, triad) in zip(panels, rest.sensors.items(), strict=True):
            for name, colour, curve in zip(BODY_AXES, COLOURS, triad.curves, strict=False):
                axes.fill_between(curve.tau, curve.lower, curve.upper, color=colour, alpha=0.18, lw=0)
                axes.plot(curve.tau, curve.deviation, ".-", color=colour, lw=1.0, label=name)
            tau = np.geomspace(triad.curves[0].tau[0], triad.curves[0].tau[-1], 200)
            if triad.alike:
                deviation = allan_deviation(triad.joint.sizes, tau)
                axes.plot(tau, deviation, "--", color=INK, label="noises of all axes")
            else:
                for name, colour, fit in zip(BODY_AXES, COLOURS, triad.axes, strict=False):
                    deviation = allan_deviation(fit.sizes, tau)
                    axes.plot(tau, deviation, "--", color=colour, lw=1.2, label=f"noises of {name}")
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xlabel("averaging time [s]")
            axes.set_ylabel(UNITS[sensor])
            axes.set_title(f"Allan deviation: {sensor}")
            axes.legend(loc="best")
        drawn.suptitle(f"At rest from {rest.begin:g} to {rest.end:g} s; bands: 95 % intervals", y=0.995)
        return drawn
