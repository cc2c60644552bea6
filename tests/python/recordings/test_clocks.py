"""Stamps of different beginnings on one clock."""

from __future__ import annotations

from datetime import datetime, timezone

import numpy as np
import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.clocks import Stamps, leap_seconds, on_one_clock, unwrapped
from sim_scenarios.recordings.readers.contents import Clock

MOMENT = datetime(2025, 1, 1, 19, 34, 18, tzinfo=timezone.utc)
OF_DAY = 19 * 3600 + 34 * 60 + 18.0
# From the calendar alone: 2025-01-01 is a Wednesday, 18 leap seconds ahead of UTC.
UNIX = MOMENT.timestamp()
GPS = (MOMENT - datetime(1980, 1, 6, tzinfo=timezone.utc)).total_seconds() + 18
TIME = np.arange(100.0)

SAME_MOMENT = {
    Clock.GPS: GPS,
    Clock.UNIX: UNIX,
    Clock.GPS_WEEK: 3 * 86400 + OF_DAY + 18,
    Clock.GPS_DAY: OF_DAY + 18,
    Clock.UTC_DAY: OF_DAY,
}


def stamps(clock: Clock, epoch: float, time: np.ndarray = TIME, offset: float = 0.0) -> Stamps:
    return Stamps(f"{clock.value}.csv", clock, epoch, time, offset)


@pytest.mark.parametrize("one", SAME_MOMENT)
@pytest.mark.parametrize("other", SAME_MOMENT)
def test_the_same_moment_is_the_same_on_every_clock(one: Clock, other: Clock) -> None:
    first, second = on_one_clock([stamps(one, SAME_MOMENT[one]), stamps(other, SAME_MOMENT[other])])
    np.testing.assert_array_equal(first, second)
    if one.dated or other.dated or one is not Clock.GPS_WEEK:
        assert first[0] in (OF_DAY + 18, 3 * 86400 + OF_DAY + 18)
    if one.dated or other.dated:
        assert first[0] == OF_DAY + 18


@pytest.mark.parametrize(
    ("date", "seconds"), [("1980-01-06", 0), ("1999-01-01", 13), ("2016-12-31", 17), ("2017-01-01", 18)]
)
def test_leap_seconds_are_those_of_the_date(date: str, seconds: int) -> None:
    """Of the table in IERS Bulletin C: GPS time minus UTC."""
    assert leap_seconds(datetime.fromisoformat(date).replace(tzinfo=timezone.utc).timestamp()) == seconds


@pytest.mark.parametrize(("clock", "length"), [(Clock.GPS_WEEK, 604800.0), (Clock.GPS_DAY, 86400.0)])
def test_a_week_and_a_day_go_on_where_they_begin_again(clock: Clock, length: float) -> None:
    time = (length - 50 + TIME) % length
    np.testing.assert_array_equal(unwrapped(time, clock), length - 50 + TIME)
    np.testing.assert_array_equal(unwrapped(time, Clock.GPS), time)


def test_a_table_of_the_new_week_belongs_to_that_of_the_old_one() -> None:
    old, new = on_one_clock(
        [stamps(Clock.GPS_WEEK, 604750.0), Stamps("new.csv", Clock.GPS_WEEK, 0.0, np.arange(5.0, 40.0))]
    )
    assert old[0] == 604750
    assert new[0] == 604805


def test_stamps_of_nobodys_clock_stay_and_go_together() -> None:
    one, other = on_one_clock([stamps(Clock.OWN, 0.0), stamps(Clock.OWN, 0.0, offset=3.5)])
    np.testing.assert_array_equal(one, TIME)
    np.testing.assert_array_equal(other, TIME + 3.5)


def test_a_clock_that_nobody_names_is_asked_for() -> None:
    with pytest.raises(
        InputError, match=r"own.csv: its stamps \(0 to 99 s\) count from something.*say clock = "
    ):
        on_one_clock([stamps(Clock.GPS, GPS), stamps(Clock.OWN, 0.0)])


@pytest.mark.parametrize(
    ("shift", "words"),
    [
        (110.0, "offset = -18, that is 18 s, which are the leap seconds"),
        (2 * 3600.0, "offset = -7200, that is 2 h"),
        (-86400.0, "offset = 86400, that is 1 days"),
        (3 * 86400.0 - 20, "offset = -259200, that is 3 days"),
        (1024 * 604800.0, "offset = -619315200, that is 1024 weeks"),
        (1800.0, "do not overlap on one clock"),
    ],
)
def test_spans_that_do_not_meet_are_refused_with_what_would_join_them(shift: float, words: str) -> None:
    with pytest.raises(InputError) as refused:
        on_one_clock([stamps(Clock.GPS, GPS), Stamps("late.pos", Clock.GPS, GPS + shift, TIME)])
    sentence = str(refused.value)
    assert words in sentence
    assert "gps.csv (70476 to 70575 s)" in sentence
    assert f"late.pos ({70476 + shift:.10g} to {70575 + shift:.10g} s)" in sentence
    assert ("offset" in sentence) == (shift != 1800.0)
