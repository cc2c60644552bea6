"""Weeks and seconds of a week."""

from __future__ import annotations

from datetime import datetime, timedelta

import pytest

from sim_scenarios.recordings.readers import gps_time


@pytest.mark.parametrize("of_week", [0.0, 10.0, 302400.0, 604799.0])
@pytest.mark.parametrize("leap", [0, 18])
def test_the_week_of_a_date_whatever_the_leap_seconds(of_week: float, leap: int) -> None:
    date = datetime(1980, 1, 6) + timedelta(weeks=2350, seconds=of_week - leap)
    assert gps_time.week_at(date, of_week) == 2350
