"""Filters with any parameters that they accept, for 300 s: numbers to the end, and no lasting wrong promise.

What a parameter says of the world may be false; a filter that believes it may be sure of what is not so until
its innovations contradict it. What only tunes it is no excuse.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from sim_scenarios import simulation
from sim_scenarios.errors import SimulationError
from sim_scenarios.fmus import Fmu, Fmus, Number, Variable
from sim_scenarios.metrics import certainty
from sim_scenarios.scenario import load_scenario

DURATION = 300.0
SCENARIOS = ("zigzag", "flight_loose_tight")  # of AlignmentFilter and of NavigationFilter
MOST_CHANGED = 6
SHORT, LONG = 24, 2000
FOUND_OUT = 120.0  # a filter that was told something false says so within this time [s]
HIDDEN = 0.005  # but for a share of lies that no signal contradicts: an antenna higher than told is a height
CHANCE = 7 * 0.0027  # of the time of filters that were told the truth: seven components beyond three sigmas

OF_THE_WORLD = ("initial.", "gnss.lever_arm", "nonholonomic.", "standstill.", "imu.each_step")
SIGMAS = ("prior.", "process.", "measurement.", "variational_bayes.")
GUARDS = ("consistency.", "gate.")
STARTS: Mapping[str, Callable[[str], Number]] = {
    "Real": float,
    "Integer": int,
    "Enumeration": int,
    "Boolean": lambda text: text == "true",
}


@dataclass(frozen=True)
class Outcome:
    """What became of one set of parameters."""

    number: int
    values: Mapping[str, Number]
    kind: str  # truthful, lie, unguarded, refused, or failed and how
    sure: float = 0.0
    wrongly: float = 0.0
    longest: float = 0.0
    not_finite: tuple[str, ...] = ()


def value_of(variable: Variable, base: Number, rng: np.random.Generator) -> Number:
    """Half of them anywhere within the limits, their ends too; half within two decades of what is there."""
    if variable.kind == "Boolean":
        return bool(rng.integers(2))
    if variable.kind == "Enumeration":
        return int(rng.integers(1, len(variable.items) + 1))
    least, most = float(variable.min or 0.0), float(variable.max or 2**31 - 1)
    if base and rng.integers(2):
        value = float(base) * 10.0 ** rng.uniform(-2.0, 2.0)
    elif rng.integers(4) == 0:
        value = least if rng.integers(2) else most
    elif least < 0.0:
        value = rng.uniform(least, most)
    else:
        value = 10.0 ** rng.uniform(-12.0, math.log10(most))
    value = float(np.clip(value, least, most))
    return round(value) if variable.kind == "Integer" else value


def kind_of(values: Mapping[str, Number], base: Mapping[str, Number]) -> str:
    """Whether a filter with these parameters has an excuse."""
    if any(name.startswith(GUARDS) for name in values):
        return "unguarded"
    too_small = any(n.startswith(SIGMAS) and v < 0.5 * base.get(n, 0.0) for n, v in values.items())
    return "lie" if too_small or any(n.startswith(OF_THE_WORLD) for n in values) else "truthful"


def lost(run: xr.Dataset) -> Iterator[str]:
    """Outputs of the filter that are no number somewhere."""
    for name, values in run.data_vars.items():
        if values.dtype.kind == "f" and not np.isfinite(values.values).all():
            yield str(name)


def outcome(seed: int, number: int) -> Outcome:
    """Run one set."""
    fmus = Fmus()
    rng = np.random.default_rng([seed, number])
    settings = {
        "duration": DURATION, "evaluation.start": 0.0, "evaluation.stop": DURATION, "communication_step": 0.1,
        "imu.rate": 10.0,
    }  # fmt: skip
    loaded = load_scenario(SCENARIOS[number % 2], fmus, seed=int(rng.integers(1, 2**31)), settings=settings)
    fmu: Fmu = fmus[loaded.filter_fmu]
    declared = {name: v for name, v in fmu.variables.items() if v.causality == "parameter"}
    base = {**{name: STARTS[v.kind](v.start or "0") for name, v in declared.items()}, **loaded.filter}
    names = rng.choice(sorted(declared), size=rng.integers(1, MOST_CHANGED + 1), replace=False).tolist()
    values = {name: value_of(declared[name], base[name], rng) for name in names}
    kind = kind_of(values, base)
    try:
        recorded, _ = simulation.simulated(loaded, fmus, {"filter": {**loaded.filter, **values}})
    except SimulationError as error:
        named = any(name in str(error) for name in base)
        return Outcome(number, values, "refused" if named else f"failed: {error}")
    run = simulation.dataset(recorded, loaded, fmus, ["filter"]).squeeze("filter")
    sure = certainty.of_run(run)
    return Outcome(number, values, kind, sure.sure, sure.wrongly, sure.longest, tuple(lost(run)))


def check(outcomes: Sequence[Outcome]) -> None:
    """Hold outcomes against what a filter promises; one without its guards promises to put out numbers."""
    assert not [one for one in outcomes if one.not_finite or one.kind.startswith("failed")]
    kinds = Counter(one.kind for one in outcomes)
    assert kinds["truthful"] >= len(outcomes) / 8
    assert kinds["lie"] >= len(outcomes) / 3
    assert not [one for one in outcomes if one.kind == "truthful" and one.longest > FOUND_OUT]
    late = [one for one in outcomes if one.kind == "lie" and one.longest > FOUND_OUT]
    assert len(late) <= HIDDEN * kinds["lie"]


def test_no_accepted_parameters_keep_a_wrong_promise() -> None:
    check([outcome(1, number) for number in range(SHORT)])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_accepted_parameters_of_very_many(seed: int) -> None:
    outcomes = [outcome(seed, number) for number in range(LONG)]
    check(outcomes)
    truthful = [one for one in outcomes if one.kind == "truthful"]
    wrongly, sure = np.array([(one.wrongly, one.sure) for one in truthful]).T
    drawn = np.random.default_rng(0).integers(len(truthful), size=(1000, len(truthful)))
    share = wrongly[drawn].sum(axis=1) / sure[drawn].sum(axis=1)
    assert (
        np.quantile(share, 0.01) <= CHANCE
    )  # at 99 % confidence, one-sided; errors last, so whole runs are drawn
