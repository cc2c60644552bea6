"""A vehicle simulation of one's own drives TruthPlant, and a filter aligns on what its IMU measures (FMPy).

The vehicle is a dozen lines: a ship that sails an S over the ellipsoid, rolls and pitches, known 20 times a
second. It stamps its states (`external.time`), so that the plant, whose IMU has 100 Hz, is in time with it;
rates are not told and interpolated. The folder of the FMUs is taken from TRUENORTH_FMUS, else it is that of
`make fmus`.
"""

import os
from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
from fmpy.simulation import instantiate_fmu

FMUS = Path(os.environ.get("TRUENORTH_FMUS", Path(__file__).parents[1] / "build" / "fmus"))
STEP, STOP = 0.05, 600.0  # s
EXTERNAL = 4  # motion.kind
FOLDER = TemporaryDirectory()


def vehicle(time: float) -> dict[str, float]:
    """Where the ship is, how fast, and how it lies: the part that is your own."""
    slow, swell = 2 * pi / 300, 2 * pi / 8  # rad/s
    latitude = 0.55 + 6e-7 * time
    longitude = 2.06 + 1e-5 * (1 - cos(slow * time))
    north_rate, east_rate = 6e-7, 1e-5 * slow * sin(slow * time)  # rad/s
    flatness = 1 - 0.00669437999014 * sin(latitude) ** 2
    normal = 6378137.0 / sqrt(flatness)  # m, radii of curvature of the ellipsoid
    meridian = normal * (1 - 0.00669437999014) / flatness
    north, east = meridian * north_rate, normal * cos(latitude) * east_rate
    attitude = (radians(8) * sin(swell * time), radians(4) * sin(0.8 * swell * time), atan2(east, north))
    named = {"position": (latitude, longitude, 0.0), "velocity": (east, north, 0.0), "attitude": attitude}
    state = {f"external.{name}[{i}]": v for name, values in named.items() for i, v in enumerate(values, 1)}
    return {"external.time": time} | state


class Component:
    """An FMU in initialisation mode, its variables by name."""

    def __init__(self, name: str, values: dict[str, float]) -> None:
        """Set `values` before it is initialised."""
        path = FMUS / f"{name}.fmu"
        model = fmpy.read_model_description(path)
        self.fmu = instantiate_fmu(fmpy.extract(path, f"{FOLDER.name}/{name}"), model)
        self.references = {variable.name: variable.valueReference for variable in model.modelVariables}
        self.integers = {v.name for v in model.modelVariables if v.type in ("Integer", "Enumeration")}
        self.write(values)
        self.fmu.setupExperiment(startTime=0.0, stopTime=STOP)
        self.fmu.enterInitializationMode()

    def read(self, *names: str) -> dict[str, float]:
        """Values by name."""
        get = {True: self.fmu.getInteger, False: self.fmu.getReal}
        return {name: get[name in self.integers]([self.references[name]])[0] for name in names}

    def write(self, values: dict[str, float]) -> None:
        """Set values by name."""
        put = {True: self.fmu.setInteger, False: self.fmu.setReal}
        for name, value in values.items():
            put[name in self.integers]([self.references[name]], [value])


plant = Component("TruthPlant", {"motion.kind": EXTERNAL} | vehicle(0.0))
plant.fmu.exitInitializationMode()

# A coarse alignment would find the attitude but for 10 deg of heading; the ship is just as true.
places = ("latitude", "longitude", "height")
vectors = [f"{name}[{i}]" for name in ("delta_angle", "delta_velocity") for i in (1, 2, 3)]
velocity = [f"velocity[{i}]" for i in (1, 2, 3)]
signals = [f"imu.{name}" for name in ("sample", "time", *vectors)]
signals += [f"gnss.{name}" for name in ("sample", "time", *places, *velocity)]
known = ("roll", "pitch", "heading", *places, *velocity)
truth = plant.read(*(f"truth.{name}" for name in known))
start = {f"initial.{name}": truth[f"truth.{name}"] for name in known}
start["initial.heading"] += radians(10)
alignment = Component("AlignmentFilter", start | plant.read(*signals))
alignment.fmu.exitInitializationMode()

for step in range(round(STOP / STEP)):
    begin = step * STEP
    plant.write(vehicle(begin + STEP))  # the vehicle goes first
    plant.fmu.doStep(begin, STEP)
    alignment.write(plant.read(*signals))
    alignment.fmu.doStep(begin, STEP)

ship = vehicle(STOP)
at = plant.read("truth.latitude", "truth.longitude").values()
off = 6.4e6 * hypot(*(value - ship[f"external.position[{i}]"] for i, value in enumerate(at, 1)))  # m
heading, sigma = alignment.read("nav.heading", "heading_sigma").values()
error = (heading - ship["external.attitude[3]"] + pi) % (2 * pi) - pi
refused = plant.read("external.rejected")["external.rejected"]
print(f"The plant refused {refused} states and ends {off:.1g} m from the ship")
print(f"Heading error {60 * degrees(error):+.2f} arcmin, sigma {60 * degrees(sigma):.2f} arcmin at the end")
for component in (plant, alignment):
    component.fmu.terminate()
    component.fmu.freeInstance()
