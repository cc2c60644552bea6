"""`truenorth parameters`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Final

import typer

from sim_scenarios.cli.options import AsJson
from sim_scenarios.cli.terminal import console, print_json, print_names, refusing_bad_input
from sim_scenarios.errors import InputError

if TYPE_CHECKING:
    from sim_scenarios.fmus import Fmu

TITLES: Final = ["parameter", "unit", "default", "tunable", "meaning"]


@dataclass(frozen=True)
class Parameter:
    """What is to be known of a parameter.

    Attributes
    ----------
    name : str
    elements : int
        Of an array; 1 of a scalar.
    unit : str
        In which its default is shown; "1" where it has none.
    units : list of str
        In which it may be given, that of the FMU first.
    default : list of str
        Of every element, or the one that all have.
    choices : list of str
        Items of an enumeration.
    tunable : bool
        Whether it may be set between steps.
    meaning : str
    """

    name: str
    elements: int
    unit: str
    units: list[str]
    default: list[str]
    choices: list[str]
    tunable: bool
    meaning: str

    def row(self) -> list[str]:
        """Cells of its line in a table."""
        return [
            self.name if self.elements == 1 else f"{self.name} ({self.elements})",
            "" if self.unit == "1" else self.unit,
            ", ".join(self.default),
            "yes" if self.tunable else "",
            ": ".join([self.meaning, *([", ".join(self.choices)] if self.choices else [])]),
        ]


def list_parameters(
    fmu: Annotated[
        str,
        typer.Argument(help="TruthPlant, Playback, AlignmentFilter or NavigationFilter.", show_default="all"),
    ] = "",
    word: Annotated[
        str, typer.Argument(help="A part of the name, or of what it means.", show_default="all parameters")
    ] = "",
    as_json: AsJson = False,
) -> None:
    """List what can be set of the FMUs: unit, default and meaning of every parameter.

    These are the names that `--set` takes, and that the tables *plant* and *filter* of a scenario hold.
    Without an FMU, the word is looked for in all of them.

    For example:

        truenorth parameters gyro
        truenorth parameters AlignmentFilter robust
        truenorth parameters TruthPlant --json
    """
    from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLANT, PLAYBACK, load

    names = (PLANT, PLAYBACK, ALIGNMENT_FILTER, NAVIGATION_FILTER)
    with refusing_bad_input():
        if fmu not in names and word:
            raise InputError(f"there is no FMU '{fmu}'; there are {', '.join(names)}")
        chosen, wanted = ([fmu], word) if fmu in names else (names, fmu)
        found = {name: _parameters(load(name), wanted) for name in chosen}
        if not any(found.values()):
            raise InputError(f"no parameter of {', '.join(chosen)} has '{wanted}' in its name or meaning")
    if as_json:
        print_json({name: [asdict(one) for one in parameters] for name, parameters in found.items()})
        return
    for name, parameters in found.items():
        if parameters:
            console().print(name, style="bold")
            print_names([TITLES, *(one.row() for one in parameters)])
            print()


def _parameters(fmu: Fmu, wanted: str) -> list[Parameter]:
    """Parameters with a word in their name or description."""
    made = (_parameter(fmu, name) for name in fmu.parameter_names())
    return [one for one in made if wanted.lower() in f"{one.name} {one.meaning}".lower()]


def _parameter(fmu: Fmu, name: str) -> Parameter:
    scalars = [fmu.variables[scalar] for scalar in fmu.arrays[name]]
    first = scalars[0]
    unit = first.display_unit or first.unit.name
    defaults = [scalar.display(fmu.start(scalar.name)).removesuffix(f" {unit}") for scalar in scalars]
    return Parameter(
        name=name,
        elements=len(scalars),
        unit=unit,
        units=[first.unit.name, *first.unit.display],
        default=defaults[:1] if len(set(defaults)) == 1 else defaults,
        choices=list(first.items),
        tunable=first.tunable,
        meaning=first.description,
    )
