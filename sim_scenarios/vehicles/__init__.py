"""Vehicles of somebody else's that move TruthPlant: known at points in time, by a file or by waypoints."""

from sim_scenarios.vehicles.motion import Points, Vehicle

__all__ = ["Points", "Vehicle"]
