"""Variables as each version of FMI has them, and SSP with it: scalars in FMI 2, arrays in FMI 3."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from sim_scenarios.errors import InputError
from sim_scenarios.exchange.system import Component, Connection
from sim_scenarios.fmus import Fmu, Number, Variable


@dataclass(frozen=True)
class Entry:
    """A variable of one version.

    Attributes
    ----------
    name : str
    elements : list of Variable
        Its scalars, in row-major order.
    shape : tuple of int
        Empty for a scalar.
    """

    name: str
    elements: list[Variable]
    shape: tuple[int, ...]

    @property
    def kind(self) -> str:
        """Real, Integer, Boolean or Enumeration."""
        return self.elements[0].kind

    @property
    def unit(self) -> str | None:
        """Unit of all elements; None where they differ or have none."""
        units = {element.unit.name for element in self.elements}
        return units.pop() if self.kind == "Real" and len(units) == 1 else None

    def text(self, written: Callable[[Variable, Number], str], values: Mapping[str, Number]) -> str:
        """Values of the elements, by scalar name, separated by blanks."""
        return " ".join(written(element, values[element.name]) for element in self.elements)


@dataclass(frozen=True)
class Form:
    """A version of FMI with the version of SSP that describes its systems.

    Attributes
    ----------
    name : str
        Folder of the FMUs.
    ssp : str
        Version of SSP.
    arrays : bool
        Whether variables are arrays.
    types : mapping of str to str
        What SSP calls the types.
    """

    name: str
    ssp: str
    arrays: bool
    types: Mapping[str, str]

    @property
    def fmi(self) -> str:
        """Version of FMI."""
        return self.name.removeprefix("fmi")

    @property
    def suffix(self) -> str:
        """Of the names of files that FMI 2 has, too."""
        return f"_{self.name}" if self.arrays else ""

    def place(self, file: str) -> str:
        """Path of a file of FMI 2 in this version: below a folder of its own."""
        folder, _, name = file.rpartition("/")
        return f"{folder}/{self.name}/{name}" if self.arrays else file

    def archive(self, fmu: Fmu) -> Path:
        """The FMU in this version."""
        path = fmu.path.parent / self.name / fmu.path.name if self.arrays else fmu.path
        if not path.is_file():
            raise InputError(f"{path} is missing; run `make fmus` to build it")
        return path

    def entries(self, component: Component, names: Iterable[str]) -> list[Entry]:
        """Variables that the scalars of these names belong to."""
        fmu = component.fmu
        if not self.arrays:
            return [Entry(name, [fmu.variables[name]], ()) for name in names]
        arrays = dict.fromkeys(name.partition("[")[0] for name in names)
        return [
            Entry(
                array, [fmu.variables[scalar] for scalar in fmu.arrays[array]], _shape(fmu.arrays[array][-1])
            )
            for array in arrays
        ]

    def connections(self, connection: Connection) -> dict[str, str]:
        """Output of the one component by input of the other."""
        if not self.arrays:
            return dict(connection.outputs)
        return {end.partition("[")[0]: start.partition("[")[0] for end, start in connection.outputs.items()}


FMI2 = Form("fmi2", "1.0", False, {kind: kind for kind in ("Real", "Integer", "Boolean", "Enumeration")})
FMI3 = Form(
    "fmi3",
    "2.0",
    True,
    {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean", "Enumeration": "Enumeration"},
)
FORMS = (FMI2, FMI3)


def _shape(last: str) -> tuple[int, ...]:
    """Shape of the array of which this is the name of the last scalar."""
    _, bracket, indices = last.rstrip("]").partition("[")
    return tuple(map(int, indices.split(","))) if bracket else ()
