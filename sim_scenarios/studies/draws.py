"""Parameters that a campaign draws for every run, from the run's seed.

Each name has a random stream of its own: what is drawn for one depends neither on what else is drawn nor on
the case, so that cases with a draw of the same name are drawn alike, run by run. `--set` of the values that
the campaign stores repeats a run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal
from zlib import crc32

import numpy as np
from pydantic import Field, model_validator

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus, Number
from sim_scenarios.scenario import Scenario
from sim_scenarios.scenario.settings import setting_owner
from sim_scenarios.scenario.tables import Table, parts_of

STREAM: Final = 2
"""First number of the seeds of these streams, apart from that of the initial errors."""

Kind = Literal["uniform", "log_uniform", "choice"]
Range = tuple[Any, Any]


class Distribution(Table):
    """What a value is drawn from, as a campaign file says it: one of three kinds."""

    uniform: Range | None = None
    log_uniform: Range | None = None
    choice: Annotated[list[Any], Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _is_one(self) -> Distribution:
        if len(self.model_fields_set) != 1:
            raise ValueError("must be one of uniform, log_uniform, choice")
        return self

    @property
    def kind(self) -> Kind:
        """Which of them it is."""
        (kind,) = self.model_fields_set
        return kind  # type: ignore[return-value]

    @property
    def values(self) -> list[Any]:
        """First and last value of a range, or those to choose from."""
        return list(getattr(self, self.kind))


@dataclass(frozen=True)
class Draw:
    """A parameter that is drawn, checked against its FMU.

    Attributes
    ----------
    name : str
        As the campaign file has it: it is the name of the random stream.
    part : str
        Whose parameter it is: plant, filter or alignment.
    kind : str
        Of the distribution.
    values : tuple of dict of str to number
        First and last value of a range or the choices, in the FMU's units by scalar name.
    units : dict of str to str
        By scalar name.
    whole : bool
        Whether it is a whole number.
    """

    name: str
    part: str
    kind: Kind
    values: tuple[dict[str, Number], ...]
    units: dict[str, str]
    whole: bool

    def drawn(self, seed: int) -> dict[str, Number]:
        """Values by scalar name; the elements of an array lie at the same place of their ranges."""
        random = np.random.default_rng([STREAM, seed, crc32(self.name.encode())])
        if self.kind == "choice":
            return self.values[random.integers(len(self.values))]
        share, (first, last) = random.random(), self.values
        return {name: self._between(first[name], last[name], share) for name in first}

    def label(self, scalar: str) -> str:
        """Name with which `--set` sets one of the scalars."""
        return f"{self.part}.{scalar}" if self.name.startswith(f"{self.part}.") else scalar

    def _between(self, first: float, last: float, share: float) -> Number:
        if self.kind == "log_uniform":
            value = first * math.pow(last / first, share)
            return round(value) if self.whole else value
        if self.whole:
            return math.floor(first + share * (last - first + 1))
        return first + share * (last - first)


def draw(name: str, given: Distribution, scenario: Scenario, fmus: Fmus) -> Draw:
    """Draw of a parameter of a scenario; refuses what its FMU would."""
    parts = parts_of(scenario, fmus)
    part, parameter = setting_owner(name, parts)
    if part not in parts:
        raise InputError(f"draw: {name} is no parameter of an FMU; an entry of the scenario is not drawn")
    fmu = parts[part]
    try:
        values = tuple(fmu.assignments(parameter, value) for value in given.values)
    except InputError as error:
        raise InputError(f"draw: {error}") from None
    variables = {scalar: fmu.variables[scalar] for scalar in values[0]}
    kinds = {variable.kind for variable in variables.values()}
    if given.kind != "choice":
        _check_range(name, given, values, kinds)
    units = {scalar: variable.unit.name for scalar, variable in variables.items()}
    return Draw(name, part, given.kind, values, units, kinds == {"Integer"})


def _check_range(
    name: str, given: Distribution, values: tuple[Mapping[str, Number], ...], kinds: set[str]
) -> None:
    first, last = values
    said = f"draw: {name} = {given.kind} {given.values[0]} to {given.values[1]}"
    if kinds & {"Boolean", "Enumeration"}:
        raise InputError(f"{said}: has no values between; use choice")
    if any(first[scalar] >= last[scalar] for scalar in first):
        raise InputError(f"{said}: the first must be below the second")
    if given.kind == "log_uniform" and any(value <= 0 for value in first.values()):
        raise InputError(f"{said}: must be greater than 0")
