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
    from sim_scenarios.campaigns import campaign
    from sim_scenarios.errors import InputError, SimulationError
    from sim_scenarios.exchange import export
    from sim_scenarios.metrics import Verdict, judge
    from sim_scenarios.recorded_imu import Start, ZeroVelocity, replay
    from sim_scenarios.recording import load, save
    from sim_scenarios.simulation import bound, compare, run

__all__ = [
    "InputError",
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
    "run",
    "save",
]

_HOMES = {
    "campaigns": ("campaign",),
    "errors": ("InputError", "SimulationError"),
    "exchange": ("export",),
    "metrics": ("Verdict", "judge"),
    "recorded_imu": ("Start", "ZeroVelocity", "replay"),
    "recording": ("load", "save"),
    "simulation": ("bound", "compare", "run"),
}


def __getattr__(name: str) -> object:
    """What the package offers, imported when it is first asked for: `truenorth --help` needs none of it."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
