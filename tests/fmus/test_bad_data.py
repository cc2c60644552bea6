"""Bad input data of a filter: the step succeeds, the item is counted and logged, the estimate stays."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from archives import FILTERS, STEP
from calls import OK, Fmu, Instance, Number, run

COUNTERS = {
    *("rejected_samples", "rejected_fixes", "missed_samples", "clock_disagreements", "aid.gnss.rejected"),
}
OF_LAST_FIX = "measurement_weight["  # whatever became of it
OF_THE_CLOCK = ".silent_for"  # which goes on
WARM_UP = 350  # the next fix comes at 400

SAMPLES: dict[str, dict[str, Number]] = {
    "angle not finite": {"imu.delta_angle[2]": math.nan},
    "force infinite": {"imu.delta_velocity[1]": math.inf},
    "time not finite": {"imu.time": math.nan},
    "older than the last": {"imu.sample": WARM_UP - 10, "imu.time": 1.0},
    "impossible rate": {"imu.delta_angle[1]": 50.0},
}
FIXES: dict[str, dict[str, Number]] = {
    "velocity not finite": {"gnss.velocity[1]": math.inf},
    "time not finite": {"gnss.time": math.inf},
    "from the future": {"gnss.time": 1e4},
    "older than the last": {"gnss.time": 0.5},
    "beyond a pole": {"gnss.latitude": 2.0},
    "impossible longitude": {"gnss.longitude": 100.0},
    "impossible speed": {"gnss.velocity[2]": 1e6},
}


@pytest.fixture(params=FILTERS)
def running(
    request: pytest.FixtureRequest, fmus: dict[str, Fmu], signals: list[dict[str, Number]]
) -> Iterator[Instance]:
    """A filter that has used a few fixes, logging on."""
    with fmus[request.param].instance(logging=True) as instance:
        known = ("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity[1]", "velocity[2]")
        instance.start(**{f"initial.{name}": signals[0][f"truth.{name}"] for name in known})
        run(instance, signals, 0, WARM_UP, STEP)
        assert instance.read()["used_fixes"] == WARM_UP // 100
        yield instance


def feed(instance: Instance, values: dict[str, Number]) -> dict[str, Number]:
    """One step at WARM_UP; the outputs after it."""
    instance.inputs.assign(values)
    assert instance.inputs.write(instance) == OK
    assert instance.step(WARM_UP * STEP, STEP) == OK, instance.journal.last
    return instance.read()


def estimate(outputs: dict[str, Number]) -> dict[str, Number]:
    return {
        name: value
        for name, value in outputs.items()
        if name not in COUNTERS and not name.startswith(OF_LAST_FIX) and not name.endswith(OF_THE_CLOCK)
    }


@pytest.mark.parametrize("case", SAMPLES)
def test_bad_sample(running: Instance, signals: list[dict[str, Number]], case: str) -> None:
    before = running.read()
    lines = len(running.journal.lines)
    after = feed(running, {**signals[WARM_UP], **SAMPLES[case]})
    assert estimate(after) == estimate(before)
    assert after["rejected_samples"] == before["rejected_samples"] + 1
    new = running.journal.lines[lines:]
    assert len(new) == 1
    assert (new[0].status, new[0].category, new[0].format) == (OK, "logEvents", "%s")
    assert "rejected" in new[0].text


@pytest.mark.parametrize("case", FIXES)
def test_bad_fix(running: Instance, signals: list[dict[str, Number]], case: str) -> None:
    """The IMU sample of the step is a repetition, so that the fix alone could change the estimate."""
    before = running.read()
    lines = len(running.journal.lines)
    now = (WARM_UP) * STEP
    fix = {"gnss.sample": before["used_fixes"] + 2, "gnss.time": now, **FIXES[case]}
    after = feed(running, {**signals[WARM_UP - 1], **fix})
    assert estimate(after) == estimate(before)
    assert after["rejected_fixes"] == before["rejected_fixes"] + 1
    new = running.journal.lines[lines:]
    assert len(new) == 1
    assert (new[0].status, new[0].category) == (OK, "logEvents")
    assert f"fix {before['used_fixes'] + 2}" in new[0].text


def test_a_good_fix_does_change_the_estimate(running: Instance, signals: list[dict[str, Number]]) -> None:
    """Control of the test above."""
    before = running.read()
    fix = {
        "gnss.sample": before["used_fixes"] + 2,
        "gnss.time": WARM_UP * STEP,
        "gnss.velocity[1]": signals[WARM_UP - 1]["gnss.velocity[1]"]
        + 1e-3,  # one alike would be of a receiver that hangs
    }
    after = feed(running, {**signals[WARM_UP - 1], **fix})
    assert estimate(after) != estimate(before)
    assert after["used_fixes"] == before["used_fixes"] + 1


def test_the_run_goes_on_after_bad_data(running: Instance, signals: list[dict[str, Number]]) -> None:
    feed(running, {**signals[WARM_UP], **SAMPLES["angle not finite"]})
    run(running, signals, WARM_UP + 1, 1000, STEP)
    outputs = running.read()
    assert outputs["used_fixes"] == 10
    assert all(math.isfinite(value) for value in outputs.values())
