"""A vehicle of somebody else's in an exported system: the Playback FMU plays its motion into the plant.

Playback holds where the vehicle is at the end of each communication step, and its `truth.*` go into the
plant's `external.*`, stamped with `imu.time`; rates are not told, and the plant interpolates them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.exchange.recorded import playback
from sim_scenarios.exchange.system import VEHICLE, Component, Connection, System
from sim_scenarios.fmus import Fmu
from sim_scenarios.recordings.feed import Feed
from sim_scenarios.recordings.tables import ReferenceTable
from sim_scenarios.timeline import instants
from sim_scenarios.vehicles import Vehicle
from sim_scenarios.vehicles.motion import STATE

TOLD: Final = dict(
    zip(
        STATE,
        (
            *("imu.time", "truth.latitude", "truth.longitude", "truth.height"),
            *(f"truth.velocity[{i}]" for i in (1, 2, 3)),
            *("truth.roll", "truth.pitch", "truth.heading"),
        ),
        strict=False,
    )
)
"""Output of Playback that goes into each input of the plant."""
SKIP: Final = "recording.skip"
"""Set as it is: an exported FMU has start values, or it would be taken for one that lost them."""


def with_vehicle(system: System, vehicle: Vehicle, template: Fmu, folder: Path) -> System:
    """The system of a scenario with what moves its plant.

    Parameters
    ----------
    system : System
        Plant with an external motion, and filters.
    vehicle : Vehicle
        Known until the system stops.
    template : Fmu
        Playback as it is built.
    folder : Path
        Where the Playback FMU is written.

    Returns
    -------
    System
    """
    time = instants(system.stop, system.step)
    states = vehicle.states(time)
    motion = ReferenceTable(time, states[:, 7:10], states[:, 1:4], states[:, 4:7])
    nothing = np.zeros(len(time))
    increments = [f"imu.delta_{what}[{i}]" for what in ("angle", "velocity") for i in (1, 2, 3)]
    columns = {"imu.sample": np.arange(len(time)), "imu.time": time, **dict.fromkeys(increments, nothing)}
    played = playback(template, folder, Feed(time, columns), motion)
    first = {name: float(states[0, STATE.index(name)]) for name in TOLD}
    plant = replace(system.plant, values={**system.plant.values, **first}, inputs=list(TOLD))
    return replace(
        system,
        plant=plant,
        vehicle=Component(VEHICLE, played, {SKIP: template.start(SKIP)}, [], list(TOLD.values())),
        connections=[Connection(VEHICLE, plant.name, TOLD), *system.connections],
    )
