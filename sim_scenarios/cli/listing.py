"""`truenorth list`."""

from __future__ import annotations

from sim_scenarios.cli.options import AsJson
from sim_scenarios.cli.terminal import print_json, print_names
from sim_scenarios.scenario import shipped


def list_scenarios(as_json: AsJson = False) -> None:
    """List the scenarios that come with the package."""
    scenarios = shipped()
    if as_json:
        print_json(scenarios)
    else:
        print_names([["scenario", "what happens"], *([name, text] for name, text in scenarios.items())])
