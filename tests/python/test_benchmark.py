"""The benchmark: every part of a run is counted, and nothing twice."""

import time

from sim_scenarios.benchmark import Clock, replay_speed, shares
from sim_scenarios.fmus import Fmus


def test_clock_adds_up() -> None:
    clock = Clock()
    sleep = clock.timed("sleep", time.sleep)
    start = time.perf_counter()
    for _ in range(3):
        sleep(0.01)
    assert 0.03 <= clock.spent["sleep"] < time.perf_counter() - start
    assert clock.timed("sum", sum)([1, 2]) == 3


def test_shares_of_a_run(fmus: Fmus) -> None:
    start = time.perf_counter()
    parts = shares("swaying_ship", fmus)
    elapsed = time.perf_counter() - start
    assert set(parts) == {"plant step", "filter step", "get and set", "loop and recording"}
    assert all(spent > 0 for spent in parts.values())
    assert sum(parts.values()) < elapsed


def test_the_speed_of_a_replay_is_that_of_the_clock(fmus: Fmus) -> None:
    start = time.perf_counter()
    speeds = replay_speed(fmus, seconds=20.0)
    elapsed = time.perf_counter() - start
    assert set(speeds) == {"alignment", "navigation"}
    assert sum(20.0 / speed for speed in speeds.values()) < elapsed
