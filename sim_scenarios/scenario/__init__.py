"""Scenario files: what moves, what measures, what filters, how long, and what counts as converged.

A scenario is a TOML file. Parameters of the FMUs stand in its tables `plant` and `filter` under the FMU's own
names; `filter_fmu` names the filter's FMU, `compare` names variants of the filter. `filter_fmu` may be the
path of an FMU of somebody else's (`ports` says what it must have), and a filter of `compare` may have a
`filter_fmu` of its own; such a filter is told nothing but what its entry says. A scenario with a table
`alignment` has an AlignmentFilter with these parameters, which starts from the initial error and hands over
to its NavigationFilter. A quantity is a number in SI units or a text with one of the display units that the
FMU declares for it ("10 deg", "0.05 deg/h", "1 mg"). Nothing unknown is accepted. A file that `extends` a
shipped scenario states only what differs; its table `compare` replaces the whole comparison.

The vehicle may be one of somebody else's (`vehicles`): `trajectory` is a file of how it moves, `waypoints`
are places that it goes past. What the plant says of motion besides is not for it.
"""

from sim_scenarios.scenario.loading import load_scenario
from sim_scenarios.scenario.tables import Scenario

__all__ = ["Scenario", "load_scenario"]
