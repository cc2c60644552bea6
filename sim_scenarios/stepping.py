"""Who steps plant and filters, and who steps first."""

from __future__ import annotations

from enum import Enum
from typing import Final, NoReturn

from sim_scenarios.errors import InputError


class Choice(str, Enum):
    """One of a few; its value stands for it wherever it is asked for."""

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        choices = ", ".join(one.value for one in cls)
        raise InputError(f"{cls.__name__.lower()} = {value!r}: must be one of {choices}")


EXPORTED_STEP: Final = 0.1
"""Communication step of an exported system [s]: ten IMU periods, so that slow importers take seconds."""


class Order(Choice):
    """Who steps first."""

    gauss_seidel = "gauss-seidel"
    jacobi = "jacobi"


class Master(Choice):
    """Who steps plant and filters."""

    auto = "auto"  # the compiled loop where it can
    compiled = "compiled"
    python = "python"

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        if value == "container":
            raise InputError("master = 'container': there is no container any more, but a loop: compiled")
        super()._missing_(value)
