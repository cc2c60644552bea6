"""What a recording goes through, and what its result is written as: words of the command line."""

from __future__ import annotations

from sim_scenarios.stepping import Choice


class Filter(Choice):
    """What a recording goes through."""

    alignment = "alignment"
    navigation = "navigation"
    align_then_navigate = "align_then_navigate"


class Format(Choice):
    """Kind of a file, and its ending."""

    csv = "csv"
    gpx = "gpx"
    kml = "kml"
    mcap = "mcap"
    pos = "pos"
