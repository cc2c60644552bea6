"""The subcommands together."""

from __future__ import annotations

import typer

from sim_scenarios.cli.bound import show_bound
from sim_scenarios.cli.campaign import run_campaign
from sim_scenarios.cli.compare import compare_filters
from sim_scenarios.cli.export import export_scenario
from sim_scenarios.cli.listing import list_scenarios
from sim_scenarios.cli.paper import reproduce_paper
from sim_scenarios.cli.replay import replay_recording
from sim_scenarios.cli.run import run_scenario
from sim_scenarios.cli.verify import verify_export

app = typer.Typer(
    name="truenorth",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    add_completion=False,
)


@app.callback()
def truenorth() -> None:
    """Put inertial alignment and navigation filters to the test.

    A plant FMU makes the signals of an IMU and a GNSS receiver, a filter FMU finds heading or position.

    For example:

        truenorth list                           what there is to run
        truenorth run swaying_ship               one run, one verdict, one report
        truenorth compare swaying_ship_printed   several filters, the same signals
        truenorth campaign zigzag -n 100         many runs, and what they say together
        truenorth paper zhou                     what a paper prints, and what is found
        truenorth bound zigzag                   how well any filter could do
        truenorth replay imu.csv --heading 100   a recorded IMU through the filter
        truenorth export swaying_ship            for other tools: FMUs, SSP, OSP, reference results
        truenorth verify FOLDER                  whether an export is whole and still gives its results

    Each command explains itself: `truenorth run --help`. Exit code: 0 converged, or done; 1 not
    converged, or found wrong; 2 bad input; 130 interrupted; 143 terminated.
    """


app.command("list")(list_scenarios)
app.command("run")(run_scenario)
app.command("compare")(compare_filters)
app.command("campaign")(run_campaign)
app.command("paper")(reproduce_paper)
app.command("bound")(show_bound)
app.command("replay")(replay_recording)
app.command("export")(export_scenario)
app.command("verify")(verify_export)
