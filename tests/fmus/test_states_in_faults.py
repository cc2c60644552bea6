"""A filter saved in the middle of a fault goes on, in another instance, as if nothing had been."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from archives import STEP
from calls import OK, Fmu, Number, run

FILTERS = ("AlignmentFilter", "NavigationFilter")
STEPS = 12_000
BEGIN, MIDDLE, END = 6_000, 6_300, 6_800

Row = dict[str, Number]
Fault = Callable[[int, Row, list[Row]], Row]


def changed(row: Row, **values: Number) -> Row:
    return {**row, **{name.replace("__", "."): value for name, value in values.items()}}


def silence(_: int, __: Row, before: list[Row]) -> Row:
    return before[-1]


def nan(_: int, row: Row, __: list[Row]) -> Row:
    return {**row, "imu.delta_angle[2]": float("nan")}


def stuck(_: int, row: Row, before: list[Row]) -> Row:
    return {**row, "imu.delta_angle[3]": before[BEGIN - 1]["imu.delta_angle[3]"]}


def zeros(_: int, row: Row, __: list[Row]) -> Row:
    return {**row, **{n: 0.0 for n in row if n.startswith(("imu.delta_angle", "imu.delta_velocity"))}}


def set_back(_: int, row: Row, __: list[Row]) -> Row:
    return changed(row, imu__time=row["imu.time"] - 5.0, gnss__time=row["gnss.time"] - 5.0)


def counted_by_ten(_: int, row: Row, __: list[Row]) -> Row:
    return changed(row, imu__sample=10 * int(row["imu.sample"]))


def early_fix(_: int, row: Row, __: list[Row]) -> Row:
    return changed(row, gnss__time=row["gnss.time"] + 0.5 * STEP)


def jump(_: int, row: Row, __: list[Row]) -> Row:
    return {
        **row,
        "gnss.velocity[1]": row["gnss.velocity[1]"] + 30.0,
        "gnss.latitude": row["gnss.latitude"] + 1e-4,
    }


def hung(_: int, row: Row, before: list[Row]) -> Row:
    place = {n: v for n, v in before[BEGIN - 1].items() if n.startswith(("gnss.l", "gnss.h", "gnss.v"))}
    return {**row, **place}


FAULTS = [silence, nan, stuck, zeros, set_back, counted_by_ten, early_fix, jump, hung]


@pytest.fixture(scope="module")
def ship(fmus: dict[str, Fmu]) -> list[Row]:
    with fmus["TruthPlant"].instance() as plant:
        plant.start(**{"gnss.rate": 10.0})
        rows = []
        for index in range(STEPS):
            assert plant.step(index * STEP, STEP) == OK
            rows.append(plant.read())
        return rows


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
@pytest.mark.parametrize("name", FILTERS)
def test_a_state_saved_in_a_fault_continues_bit_for_bit(
    name: str, fault: Fault, fmus: dict[str, Fmu], ship: list[Row]
) -> None:
    fmu = fmus[name]
    signals: list[Row] = []
    for index, row in enumerate(ship):
        signals.append(fault(index, row, signals) if BEGIN <= index < END else row)
    models = {"AlignmentFilter": (1, 5), "NavigationFilter": (1, 3)}[name]
    for model in models:
        with fmu.instance() as one, fmu.instance() as other:
            parameters: dict[str, Number] = {"error_model": model, "gate.patience": 5}
            one.start(**parameters)
            run(one, signals, 0, MIDDLE, STEP)
            state = one.serialise()
            expected = run(one, signals, MIDDLE, STEPS, STEP)
            status, handle = other.deserialise(state)
            assert status == OK, other.journal.last
            assert other.restore(handle) == OK
            assert run(other, signals, MIDDLE, STEPS, STEP) == expected
