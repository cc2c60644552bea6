"""`truenorth compare`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Final

import typer

from sim_scenarios import toml
from sim_scenarios.cli.options import AsJson, Output, Seed, Settings, SettingsFile, axes, scenarios, settings
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
from sim_scenarios.errors import InputError

Scenarios = Annotated[
    list[str],
    typer.Argument(
        help="Names of shipped scenarios (`truenorth list`), or paths of TOML files.",
        show_default=False,
        autocompletion=scenarios,
    ),
]
Axes = Annotated[
    list[str] | None,
    typer.Option(
        "--axis",
        metavar="NAME=VALUE,VALUE...",
        help="Values of a filter parameter; repeat it for others. Every combination is a filter. "
        "Without it, the filters are those that the scenario compares.",
        show_default=False,
    ),
]
EXPLANATION: Final = (
    "One run, over the evaluation window: `truenorth campaign` tells how far it scatters. "
    "/ EKF: over the nominal EKF on the same signals. !: the filter did not converge, or did not navigate."
)


def compare_filters(
    scenarios: Scenarios,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    axis: Axes = None,
    as_json: AsJson = False,
) -> None:
    """Run filters on the same signals: one table, one picture.

    For example:

        truenorth compare swaying_ship_printed
        truenorth compare overconfident_prior --seed 3 --set robust.gamma=1.5

    Of several scenarios, or with --axis, it makes a matrix: every filter in every scenario, with the ratio of
    its error to that of the nominal EKF, which has the linearised predictor and the standard corrector and is
    otherwise what the scenario says:

        truenorth compare swaying_ship waves gnss_outliers
        truenorth compare flight_constant_speed flight_outliers flight_accelerometer_fault
            --axis error_model=loose,full_state --axis corrector=standard,igg,adaptive_factor

    On a recording, `truenorth replay` with --axis compares filters.

    Exit code 0 when every filter converged.
    """
    with refusing_bad_input():
        for scenario in scenarios:
            _refuse_recording(scenario)
        if len(scenarios) > 1 or axis:
            ok = _matrix(scenarios, axes(axis), output, seed, settings(set_, set_from), as_json)
        else:
            ok = _comparison(scenarios[0], output, seed, settings(set_, set_from), as_json)
    raise typer.Exit(0 if ok else 1)


def _refuse_recording(name: str) -> None:
    """Say with which command filters are compared on a recording."""
    path = Path(name)
    if toml.exists(path) and (path.suffix not in ("", ".toml") or "imu" in toml.read(path)):
        raise InputError(
            f"{name} is a recording: truenorth replay {name} --axis NAME=VALUE,VALUE... puts filters beside "
            "each other on it"
        )


def _comparison(scenario: str, output: Output, seed: Seed, changed: dict[str, object], as_json: bool) -> bool:
    from sim_scenarios import matrix, report, simulation  # slow: xarray, matplotlib

    results = Results(output)
    with progress(scenario) as advance:
        runs = simulation.compare(scenario, seed=seed, set=changed, progress=advance)
    verdicts = matrix.judged(runs)
    name = f"{runs.attrs['scenario']}-seed{runs.attrs['seed']}-comparison"
    files = refusing_bad_input()(partial(results.write, runs, report.report_comparison, name))
    if as_json:
        about = {"scenario": runs.attrs["scenario"], "seed": runs.attrs["seed"]}
        filters = {label: verdict.to_json() for label, verdict in verdicts.items()}
        print_json({**about, "filters": filters, **files()})
    else:
        say_messages(runs)
        print_table(report.comparison_table(verdicts))
        print_notes(runs.attrs["notes"])
        print_pairs({**report.comparison_figures(runs), "Report": lambda: files()["report"]})
    return all(verdict.ok for verdict in verdicts.values())


def _matrix(
    scenarios: list[str],
    chosen: dict[str, list[object]],
    output: Output,
    seed: Seed,
    changed: dict[str, object],
    as_json: bool,
) -> bool:
    from sim_scenarios import matrix, report
    from sim_scenarios.metrics.verdict import known

    verdicts, files = {}, {}
    with Results(output).folder("matrix") as folder, progress("matrix") as advance:
        for runs in matrix.matrix(scenarios, chosen, seed=seed, settings=changed, progress=advance):
            name = str(runs.attrs["scenario"])
            verdicts[name] = matrix.judged(runs)
            files[name] = Results(folder / name).write(runs, report.report_comparison, name)
    table = matrix.Matrix(verdicts)
    if as_json:
        print_json(
            {
                name: {
                    "filters": {
                        label: {**verdict.to_json(), "over_nominal_ekf": known(table.ratio(name, label))}
                        for label, verdict in row.items()
                    },
                    **files[name],
                }
                for name, row in verdicts.items()
            }
        )
    else:
        print_table(table.table())
        print_notes(EXPLANATION)
        print_pairs({f"Report, {name}": written["report"] for name, written in files.items()})
    return all(verdict.ok for row in verdicts.values() for verdict in row.values())
