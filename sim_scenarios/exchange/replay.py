"""An FMU fed with the inputs of its own reference experiment, and how far its outputs are from it."""

from __future__ import annotations

import csv
import io
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelVariable
from numpy.typing import NDArray

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu

Array = NDArray[np.float64]

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
ATOM = 1e-6
"""Largest value up to which an output counts as zero but for rounding, in SI units."""
_WORDS = {"true": "1", "false": "0"}
_ACCESS = {
    "Real": "Real",
    "Integer": "Integer",
    "Enumeration": "Integer",
    "Boolean": "Boolean",
    "Float64": "Float64",
    "Int32": "Int32",
}


@dataclass(frozen=True)
class Experiment:
    """The reference experiment in an FMU: columns by the names of its variables, a row for each instant."""

    stop: float
    step: float
    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]


def experiment(members: Mapping[str, bytes]) -> Experiment:
    """The first experiment of an FMU."""
    if f"{FOLDER}/experiments.xml" not in members:
        raise InputError("there is no reference experiment in it; it is not from `truenorth export`")
    found = ET.fromstring(members[f"{FOLDER}/experiments.xml"])[0]
    tables = {part.tag: members[f"{FOLDER}/{part.get('source')}"] for part in found}
    return Experiment(
        float(found.attrib["stopTime"]),
        float(found.attrib["stepSize"]),
        _columns(tables["Stimuli"]) if "Stimuli" in tables else {},
        _columns(tables["References"]),
    )


def difference(archive: Path, given: Experiment) -> float:
    """Largest difference of an output, of its largest value in the reference, but at least of ATOM."""
    fmu = Fmu(archive)
    with closing(_Slave(fmu, given)) as slave:
        worst = 0.0
        instants = given.outputs["time"]
        row = 0
        for index in range(round(given.stop / given.step) + 1):
            time = index * given.step
            if row < len(instants) and abs(time - instants[row]) < given.step / 2:
                for name, value in slave.outputs().items():
                    reference = given.outputs[name]
                    worst = max(worst, _apart(value, reference, row))
                row += 1
            if index * given.step < given.stop - given.step / 2:
                slave.step(index, time, given.step)
    if row < len(instants):
        return math.inf
    return worst


def _apart(value: Array, reference: Array, row: int) -> float:
    """Largest difference of a value from a row: none where both are no number, infinite where one is."""
    finite = reference[np.isfinite(reference)]
    scale = max(float(np.abs(finite).max(initial=0.0)), ATOM)
    off = np.abs(value - reference[row]) / scale
    off[np.isnan(value) & np.isnan(reference[row])] = 0.0
    return float(np.max(np.nan_to_num(off, nan=np.inf), initial=0.0))


class _Slave:
    """An instance for co-simulation, of FMI 2 or FMI 3, that begins with its own start values."""

    def __init__(self, fmu: Fmu, given: Experiment) -> None:
        arguments = {
            "guid": str(fmu.model.guid or fmu.model.instantiationToken),
            "modelIdentifier": fmu.model.coSimulation.modelIdentifier,
            "unzipDirectory": str(fmu.folder),
            "instanceName": fmu.name,
            "libraryPath": str(fmu.library),
        }
        self._stop = given.stop
        self._modern = str(fmu.model.fmiVersion).startswith("3")
        self._instance: Any = (FMU3Slave if self._modern else FMU2Slave)(**arguments)
        self._instance.instantiate()
        variables = {str(v.name): v for v in fmu.model.modelVariables}
        self._inputs = [
            _Group(kind, names, variables, given.inputs)
            for kind, names in _by_access(given.inputs, variables)
        ]
        self._outputs = [
            _Group(kind, names, variables, given.outputs)
            for kind, names in _by_access(given.outputs, variables)
        ]
        if not self._modern:
            self._instance.setupExperiment(startTime=0.0, stopTime=given.stop)
            self._instance.enterInitializationMode()
        else:
            self._instance.enterInitializationMode(startTime=0.0, stopTime=given.stop)
        self._feed(0)
        self._instance.exitInitializationMode()

    def step(self, index: int, time: float, step: float) -> None:
        """Take the inputs of a row and make the step that begins there."""
        self._feed(index)
        self._instance.doStep(currentCommunicationPoint=time, communicationStepSize=step)

    def outputs(self) -> dict[str, Array]:
        """Values of all outputs of the reference, arrays flat."""
        return {
            name: value for group in self._outputs for name, value in group.read(self._instance, self._modern)
        }

    def close(self) -> None:
        """Terminate and free the instance."""
        self._instance.terminate()
        self._instance.freeInstance()

    def _feed(self, index: int) -> None:
        for group in self._inputs:
            group.write(self._instance, index)


class _Group:
    """Variables that are read or set with one call."""

    def __init__(
        self,
        access: str,
        names: Sequence[str],
        variables: Mapping[str, ModelVariable],
        table: Mapping[str, Array],
    ) -> None:
        self._access = access
        self._names = names
        self._references = [int(variables[name].valueReference) for name in names]
        self._sizes = [table[name].shape[1] for name in names]
        self._rows = np.hstack([table[name] for name in names])

    def write(self, instance: Any, index: int) -> None:
        """Set the values of a row."""
        row = self._rows[index]
        values = row.tolist() if self._access in ("Real", "Float64") else row.astype(int).tolist()
        getattr(instance, f"set{self._access}")(self._references, values)

    def read(self, instance: Any, modern: bool) -> list[tuple[str, Array]]:
        """Values by name."""
        size = {"nValues": sum(self._sizes)} if modern else {}
        values = np.array(getattr(instance, f"get{self._access}")(self._references, **size), dtype=float)
        parts = np.split(values, np.cumsum(self._sizes)[:-1])
        return list(zip(self._names, parts, strict=True))


def _by_access(
    table: Mapping[str, Array], variables: Mapping[str, ModelVariable]
) -> list[tuple[str, list[str]]]:
    """Names of a table, the time left out, by the function that reads and sets them."""
    groups: dict[str, list[str]] = {}
    for name in table:
        if name != "time":
            groups.setdefault(_ACCESS[str(variables[name].type)], []).append(name)
    return list(groups.items())


def _columns(table: bytes) -> dict[str, Array]:
    """Columns by name; a row of each has the elements of an array, or one value."""
    header, *rows = csv.reader(io.StringIO(table.decode()))
    columns = {
        name: np.array([[_WORDS.get(part, part) for part in text.split()] for text in column], dtype=float)
        for name, column in zip(header, zip(*rows, strict=True), strict=True)
    }
    return {**columns, "time": columns["time"][:, 0]}
