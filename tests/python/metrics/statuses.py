"""The states that a filter can be in, as its FMU declares them."""

from __future__ import annotations

from sim_scenarios.fmus import ALIGNMENT_FILTER, load

ITEMS = load(ALIGNMENT_FILTER).variables["status"].items
FLAGS = {"flag_values": list(ITEMS.values()), "flag_meanings": " ".join(ITEMS)}
GOOD = {"aligning", "converged"}
BAD = sorted((value, name) for name, value in ITEMS.items() if name not in GOOD)
