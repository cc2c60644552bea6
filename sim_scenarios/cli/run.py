"""`truenorth run`."""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from sim_scenarios.cli.options import AsJson, Output, Scenario, Seed, Settings, SettingsFile, settings
from sim_scenarios.cli.results import Results
from sim_scenarios.cli.terminal import (
    print_json,
    print_pairs,
    print_verdict,
    progress,
    refusing_bad_input,
    say_messages,
)
from sim_scenarios.errors import InputError


def run_scenario(
    scenario: Scenario,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    live: Annotated[
        bool,
        typer.Option("--live", help="Show the run while it goes on, here and on a page of this machine."),
    ] = False,
    pace: Annotated[
        float | None,
        typer.Option(
            help="With --live: seconds of the run in one on the clock.",
            show_default="as many as make it last half a minute",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a scenario with its filter and judge the heading, or the navigation.

    For example:

        truenorth run swaying_ship
        truenorth run swaying_ship --seed 7
        truenorth run swaying_ship --set prior.heading_sigma="20 deg"
        truenorth run zigzag --set corrector=standard --set gnss.rate=5
        truenorth run zigzag --live --pace 10                # heading, sigma, status and track meanwhile
        truenorth run my_ship --output results --json        # my_ship.toml of this folder

    Exit code 0 when the heading converged (or the horizontal position kept its limit), 1 when it did not.
    """
    from sim_scenarios import report, simulation  # slow: xarray, matplotlib
    from sim_scenarios.metrics import judge

    with refusing_bad_input():
        if pace is not None and not live:
            raise InputError(f"--pace {pace:g}: goes with --live alone")
        results = Results(output)
        simulate = partial(simulation.run, scenario, seed=seed, set=settings(set_, set_from))
        if live:
            from sim_scenarios.cli.live import watched

            with watched(scenario, pace) as watch:
                run = simulate(watch=watch)
        else:
            with progress(scenario) as advance:
                run = simulate(progress=advance)
        verdict = judge(run)
        name = f"{run.attrs['scenario']}-seed{run.attrs['seed']}"
    files = refusing_bad_input()(partial(results.write, run, report.report_run, name))
    if as_json:
        about = {"scenario": run.attrs["scenario"], "seed": run.attrs["seed"]}
        print_json({**about, **verdict.to_json(), **files()})
    else:
        say_messages(run)
        print_verdict(verdict.sentence(), verdict.ok)
        start, stop = run.attrs["evaluation.start"], run.attrs["evaluation.stop"]
        window = {"Evaluated": f"{start:g} to {stop:g} s"}
        figures = report.run_figures(run, verdict)
        print_pairs({**window, **figures, "Report": lambda: files()["report"]})
    raise typer.Exit(0 if verdict.ok else 1)
