"""The FMUs connected by hand, with FMPy alone: plant and filter, outputs to the inputs of equal name.

The folder of the FMUs is taken from TRUENORTH_FMUS, else it is that of `make fmus`.
"""

import os
from math import degrees, pi, radians
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
from fmpy.fmi2 import FMU2Slave

FMUS = Path(os.environ.get("TRUENORTH_FMUS", Path(__file__).parents[1] / "build" / "fmus"))
STEP, STOP = 0.1, 600.0  # s; ten IMU periods
FOLDER = TemporaryDirectory()


class Component:
    """An FMU in co-simulation, its variables by name."""

    def __init__(self, name: str, parameters: dict[str, float]) -> None:
        """Instance in initialisation mode, with its parameters."""
        path = FMUS / f"{name}.fmu"
        model = fmpy.read_model_description(path)
        self.variables = {variable.name: variable for variable in model.modelVariables}
        self.slave = FMU2Slave(
            guid=model.guid,
            unzipDirectory=fmpy.extract(path, FOLDER.name + f"/{name}"),
            modelIdentifier=model.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.instantiate()
        self.write(parameters)
        self.slave.setupExperiment(startTime=0.0, stopTime=STOP)
        self.slave.enterInitializationMode()

    def names(self, causality: str) -> list[str]:
        """Names of its inputs, outputs or parameters."""
        return [name for name, variable in self.variables.items() if variable.causality == causality]

    def read(self, names: list[str]) -> dict[str, float]:
        """Values by name."""
        return {name: self._call("get", name)[0] for name in names}

    def write(self, values: dict[str, float]) -> None:
        """Set values by name."""
        for name, value in values.items():
            self._call("set", name, [value])

    def _call(self, verb: str, name: str, *values: list[float]) -> list[float]:
        variable = self.variables[name]
        kind = "Integer" if variable.type == "Enumeration" else variable.type
        return getattr(self.slave, f"{verb}{kind}")([variable.valueReference], *values)


plant = Component("TruthPlant", {"seed": 7})
plant.slave.exitInitializationMode()

# The filter starts from what a coarse alignment would hand over: here the truth, but for 10 deg of heading.
attitude, position = ("roll", "pitch", "heading"), ("latitude", "longitude", "height")
wanted = [*attitude, *position, *(f"velocity[{i}]" for i in (1, 2, 3))]
truth = plant.read([f"truth.{name}" for name in wanted])
start = {name.replace("truth.", "initial."): value for name, value in truth.items()}
start["initial.heading"] += radians(10)
alignment = Component("AlignmentFilter", start)
signals = [name for name in alignment.names("input") if name in plant.variables]
alignment.write(plant.read(signals))
alignment.slave.exitInitializationMode()

for step in range(round(STOP / STEP)):
    plant.slave.doStep(step * STEP, STEP)
    alignment.write(plant.read(signals))
    alignment.slave.doStep(step * STEP, STEP)

heading, sigma = alignment.read(["nav.heading", "heading_sigma"]).values()
error = (heading - plant.read(["truth.heading"])["truth.heading"] + pi) % (2 * pi) - pi
print(f"Heading error {60 * degrees(error):+.2f} arcmin, sigma {60 * degrees(sigma):.2f} arcmin at the end")
for component in (plant, alignment):
    component.slave.terminate()
    component.slave.freeInstance()
