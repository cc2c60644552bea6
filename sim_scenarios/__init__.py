"""Scenarios that put the TrueNorth FMUs to the test.

Whatever the command `truenorth` does is one function call here::

    import sim_scenarios

    run = sim_scenarios.run("swaying_ship", seed=7, set={"prior.heading_sigma": "20 deg"})
    print(sim_scenarios.judge(run))
    run["heading_error"].plot()

and `sim_scenarios.report.report_run(run, folder)` writes the page with the pictures.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sim_scenarios import report
    from sim_scenarios.errors import InputError, SimulationError
    from sim_scenarios.exchange import export
    from sim_scenarios.metrics import Verdict, judge
    from sim_scenarios.recording import load, save
    from sim_scenarios.recordings.outages import Outages
    from sim_scenarios.recordings.replay import replay
    from sim_scenarios.recordings.start import Start
    from sim_scenarios.recordings.zero_velocity import ZeroVelocity
    from sim_scenarios.scenario_bound import bound
    from sim_scenarios.simulation import compare, run
    from sim_scenarios.studies.campaign import campaign

__all__ = [
    "InputError",
    "Outages",
    "SimulationError",
    "Start",
    "Verdict",
    "ZeroVelocity",
    "bound",
    "campaign",
    "compare",
    "export",
    "judge",
    "load",
    "replay",
    "report",
    "run",
    "save",
]

_HOMES = {
    "errors": ("InputError", "SimulationError"),
    "exchange": ("export",),
    "metrics": ("Verdict", "judge"),
    "recording": ("load", "save"),
    "recordings.outages": ("Outages",),
    "recordings.replay": ("replay",),
    "recordings.start": ("Start",),
    "recordings.zero_velocity": ("ZeroVelocity",),
    "scenario_bound": ("bound",),
    "simulation": ("compare", "run"),
    "studies.campaign": ("campaign",),
}
_MODULES = ("report",)


def __getattr__(name: str) -> object:
    """What the package offers, imported when it is first asked for: `truenorth --help` needs none of it."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
