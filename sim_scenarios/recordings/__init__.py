"""Recordings of real vehicles: what a file says, in this product's units, axes and on one clock."""

from sim_scenarios.recordings.description import load
from sim_scenarios.recordings.tables import Recording

__all__ = ["Recording", "load"]
