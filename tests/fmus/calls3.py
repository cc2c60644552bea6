"""FMI 3.0 through FMPy, with arrays taken apart into the scalars that FMI 2 knows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import fmpy
from calls import Number
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription, ModelVariable

KINDS = {"Float64": "Float64", "Int32": "Int32", "Enumeration": "Int64", "Boolean": "Boolean"}


def scalar_names(variable: ModelVariable) -> list[str]:
    """Names that the elements have in FMI 2, the last index running fastest."""
    sizes = [int(dimension.start) for dimension in variable.dimensions]
    if not sizes:
        return [variable.name]
    indices = product(*(range(1, size + 1) for size in sizes))
    return [f"{variable.name}[{','.join(map(str, index))}]" for index in indices]


def _starts(variable: ModelVariable) -> dict[str, Number]:
    """Start values of the elements; none for an output."""
    if variable.start is None:
        return {}
    names, texts = scalar_names(variable), variable.start.split()
    convert = {"Float64": float, "Boolean": lambda text: text == "true"}.get(variable.type, int)
    return dict(zip(names, map(convert, texts), strict=True))


@dataclass(frozen=True)
class Fmu3:
    """An unpacked FMI 3 FMU."""

    archive: Path
    folder: Path
    description: ModelDescription

    @classmethod
    def load(cls, archive: Path, folder: Path) -> Fmu3:
        fmpy.extract(archive, unzipdir=str(folder))
        return cls(archive, folder, fmpy.read_model_description(archive))

    @property
    def arguments(self) -> dict[str, str]:
        """What FMPy needs to load the binary."""
        return {
            "guid": self.description.instantiationToken,
            "unzipDirectory": str(self.folder),
            "modelIdentifier": self.description.modelName,
            "instanceName": "instance",
        }

    def of(self, causality: str) -> list[ModelVariable]:
        return [v for v in self.description.modelVariables if v.causality == causality]

    def slave(self) -> FMU3Slave:
        """An instance for co-simulation."""
        fmu = FMU3Slave(**self.arguments)
        fmu.instantiate()
        return fmu

    def model(self) -> FMU3Model:
        """An instance for model exchange."""
        fmu = FMU3Model(**self.arguments)
        fmu.instantiate()
        return fmu


class Ports3:
    """Variables that are read or written in one call a type, by the names of their scalars."""

    def __init__(self, fmu: FMU3Slave | FMU3Model, variables: Iterable[ModelVariable]) -> None:
        self.fmu = fmu
        self.groups: dict[str, tuple[list[int], list[str]]] = {}
        self.starts: dict[str, Number] = {}
        for variable in variables:
            references, names = self.groups.setdefault(KINDS[variable.type], ([], []))
            references.append(variable.valueReference)
            names += scalar_names(variable)
            self.starts |= _starts(variable)

    def filled(self, values: dict[str, Number]) -> dict[str, Number]:
        """Start values of all scalars, with those of `values` that are here in their place."""
        return {name: values.get(name, start) for name, start in self.starts.items()}

    def read(self) -> dict[str, Number]:
        values: dict[str, Number] = {}
        for kind, (references, names) in self.groups.items():
            get = getattr(self.fmu, f"get{kind}")
            values |= zip(names, get(references, nValues=len(names)), strict=True)
        return values

    def write(self, values: dict[str, Number]) -> None:
        """Set what is named; all variables of a type must be."""
        for kind, (references, names) in self.groups.items():
            getattr(self.fmu, f"set{kind}")(references, [values[name] for name in names])
