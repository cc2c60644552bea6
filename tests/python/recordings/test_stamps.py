"""Stamps as loggers write them: what is a gap, what a sample covers, and the sensor's own clock."""

from __future__ import annotations

import numpy as np
import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings import stamps

UNIX = 1_764_363_403.0


def host_stamps(rate: float, seconds: float, scatter: float, seed: int = 1) -> np.ndarray:
    """Stamps of a host that is late by up to `scatter` periods, in order."""
    rng = np.random.default_rng(seed)
    count = np.arange(1, round(rate * seconds) + 1)
    return np.maximum.accumulate((count + scatter * rng.uniform(size=len(count))) / rate)


AS_WRITTEN = {
    "300 Hz, microseconds": np.round(np.arange(1, 180_001) / 300, 6),
    "400 Hz, milliseconds": np.round(np.arange(1, 60_001) / 400, 3),
    "187.5 Hz, milliseconds: steps of 5, 5, 6": np.round(np.arange(1, 56_251) / 187.5, 3),
    "1 kHz, seconds since 1970": UNIX + np.arange(1, 60_001) / 1000,
    "152 Hz, a host that is late by up to half a period": host_stamps(152.0, 134.0, 0.5),
    "100 Hz in packets of four": np.repeat(np.arange(1, 2501) / 25, 4) + np.tile([0, 1e-4, 2e-4, 3e-4], 2500),
    "100 Hz, drifting by 1 %": np.cumsum(np.linspace(0.01, 0.0101, 60_000)),
}


@pytest.mark.parametrize("time", AS_WRITTEN.values(), ids=AS_WRITTEN.keys())
def test_ordinary_stamps_have_no_gap(time: np.ndarray) -> None:
    assert not stamps.gaps(time).any()
    assert not stamps.missed(time).any()
    assert stamps.period(time) == pytest.approx((time[-1] - time[0]) / (len(time) - 1))
    assert np.sum(stamps.intervals(time)) == pytest.approx(time[-1] - time[0] + stamps.period(time))


@pytest.mark.parametrize("lost", [1, 2, 30, 5000])
@pytest.mark.parametrize("name", ["300 Hz, microseconds", "187.5 Hz, milliseconds: steps of 5, 5, 6"])
def test_what_was_cut_out_is_the_gap(name: str, lost: int) -> None:
    whole = AS_WRITTEN[name]
    time = np.delete(whole, slice(20_000, 20_000 + lost))
    np.testing.assert_array_equal(np.flatnonzero(stamps.gaps(time)), [20_000])
    assert stamps.missed(time)[20_000] == lost


def test_gaps_near_each_other_and_near_the_ends_are_found() -> None:
    lost = [2, 50, 53, 900, 997]
    time = np.delete(np.arange(1000) * 0.01, lost)
    assert stamps.missed(time).sum() == len(lost)
    np.testing.assert_array_equal(np.flatnonzero(stamps.gaps(time)), np.array(lost) - np.arange(len(lost)))


def test_few_samples_suffice() -> None:
    np.testing.assert_array_equal(stamps.missed(np.array([1.0, 1.01, 1.02, 1.06, 1.07])), [0, 0, 0, 3, 0])
    np.testing.assert_array_equal(stamps.missed(np.array([1.0, 1.01])), [0, 0])


def test_inside_a_gap_a_sample_covers_one_period() -> None:
    time = np.array([1.0, 1.01, 1.02, 1.06, 1.072])
    np.testing.assert_allclose(stamps.intervals(time), [0.032 / 3, 0.01, 0.01, 0.032 / 3, 0.012])


@pytest.mark.parametrize("grid", [1e-3, 4e-3])
def test_a_steady_clock_is_found_behind_coarse_stamps(grid: float) -> None:
    true = np.arange(1, 12_001) / 187.3 * (1 + 20e-6)
    coarse = np.floor(true / grid) * grid
    steady = stamps.on_a_steady_clock(coarse)
    error = steady - true
    assert np.std(error) < 0.1 * np.std(coarse - true)
    assert np.abs(np.diff(steady) - np.diff(true)).max() < 0.1 * grid


def test_late_packets_do_not_draw_the_steady_clock() -> None:
    true = np.arange(1, 6001) * 0.01
    late = true.copy()
    late[::50] += 0.009
    assert np.abs(stamps.on_a_steady_clock(late) - true).max() < 1e-4


def test_a_gap_stays_one_on_a_steady_clock() -> None:
    true = np.delete(np.arange(1, 4001) * 0.01, slice(1500, 1700))
    steady = stamps.on_a_steady_clock(np.round(true + 0.002 * np.sin(true * 1e4), 3))
    assert stamps.missed(steady)[1500] == 200
    assert np.abs(steady - true).max() < 1e-3


def test_what_is_no_steady_sensor_is_refused() -> None:
    with pytest.raises(InputError, match="are not those of a sensor that samples steadily"):
        stamps.on_a_steady_clock(np.concatenate([np.arange(1000) * 0.01, 10 + np.arange(1000) * 0.2]))
