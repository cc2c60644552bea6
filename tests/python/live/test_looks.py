"""A run that is watched gives the same results, shows what it records, and keeps to its pace."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLANT, Fmus, load
from sim_scenarios.live.looks import Look, watch

SHORT: dict[str, object] = {"duration": 40.0, "evaluation.start": 20.0, "evaluation.stop": 40.0}
AT_ONCE = 1e9


@pytest.fixture(scope="module")
def seen(fmus: Fmus) -> tuple[xr.Dataset, list[Look]]:
    looks: list[Look] = []
    run = sim_scenarios.run("zigzag", seed=3, set=SHORT, watch=watch(looks.append, 100.0), fmus=fmus)
    return run, looks


def test_the_results_are_the_same(seen: tuple[xr.Dataset, list[Look]], fmus: Fmus) -> None:
    xr.testing.assert_identical(seen[0], sim_scenarios.run("zigzag", seed=3, set=SHORT, fmus=fmus))


def test_a_look_is_what_is_recorded(seen: tuple[xr.Dataset, list[Look]]) -> None:
    run, looks = seen
    assert (looks[0].time, looks[-1].time) == (0.0, 40.0)
    assert len(looks) > 3
    for look in looks:
        row = run.sel(time=look.time, method="nearest")
        assert float(row["time"]) == pytest.approx(look.time)
        assert look.heading == float(row["nav.heading"])
        assert look.heading_sigma == float(row["heading_sigma"])
        assert look.heading_error == pytest.approx(float(row["heading_error"]), abs=1e-12)
        names = row["status"].attrs["flag_meanings"].split()
        assert look.status == names[int(row["status"]) - 1]
        off = np.array(look.place) - look.true_place
        np.testing.assert_allclose(off, row["position_error"].values[:2], atol=1e-3)
    assert looks[0].true_place == (0.0, 0.0)
    assert math.dist(looks[-1].true_place, looks[0].true_place) > 50  # it is under way


def test_a_run_keeps_to_its_pace(fmus: Fmus) -> None:
    looks: list[tuple[float, Look]] = []

    def show(look: Look) -> None:
        looks.append((time.monotonic(), look))

    sim_scenarios.run("zigzag", set=SHORT, watch=watch(show, 40.0), fmus=fmus)
    begun = looks[0][0]
    assert all(now - begun >= look.time / 40.0 - 1e-3 for now, look in looks)
    assert 5 <= len(looks) <= 12  # ten a second, of those that a busy machine gets to


def test_an_alignment_is_watched_until_it_hands_over() -> None:
    all_fmus = Fmus({name: load(name) for name in (PLANT, ALIGNMENT_FILTER, NAVIGATION_FILTER)})
    looks: list[Look] = []
    run = sim_scenarios.run("align_then_navigate", watch=watch(looks.append, AT_ONCE), fmus=all_fmus)
    before = [look for look in looks if look.time < float(run["hand_over_time"])]
    for look in before[1:]:
        row = run.sel(time=look.time, method="nearest")
        assert look.heading == float(row["alignment.nav.heading"])
    last = looks[-1]
    assert last.heading == float(run["nav.heading"][-1])
    assert last.status == "converged"


@pytest.mark.parametrize("pace", [0.0, -1.0, math.inf, math.nan])
def test_a_pace_that_is_none_is_refused(pace: float) -> None:
    with pytest.raises(InputError, match="must be greater than 0"):
        watch(print, pace)
