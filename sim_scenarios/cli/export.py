"""`truenorth export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios.cli.options import AsJson, Scenario, Seed, Settings, SettingsFile, settings
from sim_scenarios.cli.results import Results, storing
from sim_scenarios.cli.terminal import print_json, print_pairs, refusing_bad_input
from sim_scenarios.exchange import STEP, export
from sim_scenarios.names import file_name


def export_scenario(
    scenario: Scenario,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder to write.", show_default="truenorth-export/SCENARIO"),
    ] = None,
    seed: Seed = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    step: Annotated[float, typer.Option(help="Communication step of the exported system [s].")] = STEP,
    as_json: AsJson = False,
) -> None:
    """Write a scenario for other tools: FMUs, SSP, OSP, parameters, reference results.

    For example:

        truenorth export swaying_ship
        truenorth export zigzag --output partner --seed 7 --step 0.01
    """
    with refusing_bad_input():
        folder = output or Path("truenorth-export") / file_name(Path(scenario).stem)
        Results(folder)
        with storing(folder):
            system = export(scenario, folder, seed=seed, set=settings(set_, set_from), step=step)
    files = {"ssp": str(folder / f"{system.name}.ssp"), "readme": str(folder / "README.md")}
    if as_json:
        print_json({"scenario": system.name, "communication_step": system.step, **files})
    else:
        print_pairs({"Scenario": system.name, "System": files["ssp"], "Read first": files["readme"]})
