"""Instances that must not come to life, and the reasons given."""

from __future__ import annotations

import pytest
from calls import CO_SIMULATION, MODEL_EXCHANGE, Callbacks, Fmu, Journal, Logger

REFUSED = {
    "another guid": ({"guid": b"{00000000-0000-0000-0000-000000000000}"}, "different builds"),
    "empty guid": ({"guid": b""}, "different builds"),
    "no name": ({"name": None}, "instanceName is NULL or empty"),
    "empty name": ({"name": b""}, "instanceName is NULL or empty"),
    "another kind": ({"kind": 2}, "fmuType = 2: must be fmi2ModelExchange (0) or fmi2CoSimulation (1)"),
    "no kind": ({"kind": -1}, "fmuType = -1: must be fmi2ModelExchange (0) or fmi2CoSimulation (1)"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(fmu: Fmu, case: str) -> None:
    arguments, reason = REFUSED[case]
    journal = Journal()
    assert fmu.instantiate(callbacks=journal.callbacks, **arguments) is None
    assert len(journal.lines) == 1
    assert journal.lines[0].category == "logStatusError"
    assert reason in journal.last


def test_null_guid(fmu: Fmu) -> None:
    journal = Journal()
    assert fmu.library.fmi2Instantiate(b"x", CO_SIMULATION, None, None, journal.callbacks, 0, 0) is None
    assert "fmuGUID = NULL" in journal.last


def test_no_callbacks(fmu: Fmu) -> None:
    assert fmu.instantiate(callbacks=None) is None
    assert fmu.instantiate(callbacks=Callbacks(Logger(), None, None, None, None)) is None


@pytest.mark.parametrize("kind", [CO_SIMULATION, MODEL_EXCHANGE])
def test_accepted(fmu: Fmu, kind: int) -> None:
    journal = Journal()
    handle = fmu.instantiate(kind=kind, callbacks=journal.callbacks, logging=True)
    assert handle
    assert not journal.lines
    fmu.library.fmi2FreeInstance(handle)
