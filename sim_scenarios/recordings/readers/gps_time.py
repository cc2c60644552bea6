"""Time of the satellites: weeks and seconds of a week since 1980-01-06, without leap seconds."""

from __future__ import annotations

from datetime import datetime
from typing import Final

WEEK: Final = 604800.0  # s
DAY: Final = 86400.0  # s
EPOCH: Final = datetime(1980, 1, 6)
SINCE_1970: Final = (EPOCH - datetime(1970, 1, 1)).total_seconds()
"""Their beginning on the clock of Unix [s]."""


def week_at(date: datetime, of_week: float) -> int:
    """Week of a second of the week, from a date that is right to three days, leap seconds or not."""
    return round(((date - EPOCH).total_seconds() - of_week) / WEEK)
