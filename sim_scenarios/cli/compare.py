"""`truenorth compare`."""

from __future__ import annotations

import typer

from sim_scenarios import report, simulation
from sim_scenarios.cli.options import AsJson, Output, Scenario, Seed, Settings, settings
from sim_scenarios.cli.results import Results
from sim_scenarios.cli.terminal import (
    print_json,
    print_notes,
    print_pairs,
    print_table,
    progress,
    refusing_bad_input,
    say_messages,
)
from sim_scenarios.metrics import judge


def compare_filters(
    scenario: Scenario,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Run the filters that a scenario names on the same signals: one table, one picture.

    For example:

        truenorth compare swaying_ship_printed
        truenorth compare overconfident_prior --seed 3 --set robust.gamma=1.5

    Exit code 0 when every filter converged.
    """
    with refusing_bad_input():
        results = Results(output)
        with progress(scenario) as advance:
            runs = simulation.compare(scenario, seed=seed, set=settings(set_), progress=advance)
        verdicts = {str(label): judge(runs.sel(filter=label)) for label in runs["filter"].values}
        name = f"{runs.attrs['scenario']}-seed{runs.attrs['seed']}-comparison"
        files = results.write(runs, report.report_comparison, name)
    if as_json:
        about = {"scenario": runs.attrs["scenario"], "seed": runs.attrs["seed"]}
        filters = {label: verdict.to_json() for label, verdict in verdicts.items()}
        print_json({**about, "filters": filters, **files})
    else:
        say_messages(runs)
        print_table(report.comparison_table(verdicts))
        print_notes(runs.attrs["notes"])
        print_pairs({**report.about_bound(runs), "Report": files["report"]})
    raise typer.Exit(0 if all(verdict.ok for verdict in verdicts.values()) else 1)
