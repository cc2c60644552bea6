"""Pictures of a campaign: each filter against its own band, and all runs in the share of runs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from sim_scenarios.studies import pictures
from sim_scenarios.studies.statistics import Course, consistency_course

TIME = np.arange(5.0)
RUNS = 10


def nis(channels: int) -> Course:
    """Of a filter whose NIS is what it should be in the mean; nothing at the beginning."""
    degrees = np.full((RUNS, len(TIME)), float(channels))
    degrees[:, 0] = 0
    return consistency_course(degrees.copy(), degrees)


@pytest.mark.parametrize(
    ("channels", "different", "word"), [([6, 6, 6], 1, "band"), ([6, 18, 6], 2, "bands"), ([], 0, "band")]
)
def test_a_filter_is_held_against_the_band_of_its_channels(
    channels: list[int], different: int, word: str
) -> None:
    courses = {f"filter {i}": nis(count) for i, count in enumerate(channels)}
    axes = Figure().add_subplot()
    case: Any = SimpleNamespace(time=TIME)
    pictures._consistency(case, courses, axes, "NIS")
    assert len(axes.collections) == different
    assert f"; {word}: 95 %" in axes.get_title()
    held = pictures.bands(list(courses.values()))
    assert [band.upper[1] for band in held] == [nis(count).upper[1] for count in dict.fromkeys(channels)]


def test_runs_that_stopped_are_in_the_share() -> None:
    one = SimpleNamespace(each=np.array([3.0, 1.0, 2.0]), runs=4)
    case: Any = SimpleNamespace(filters={"UKF": one}, counting="heading")
    axes = Figure().add_subplot()
    pictures._runs(case, axes)
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_ydata(), [25, 50, 75])
