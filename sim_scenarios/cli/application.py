"""The command as a whole: what it says of itself, and the options that all subcommands have."""

from __future__ import annotations

from typing import Annotated

import typer

from sim_scenarios.cli.commands import APPEARANCE, Commands
from sim_scenarios.cli.terminal import Volume, speak

app = typer.Typer(name="truenorth", cls=Commands, **APPEARANCE)


def _show_version(wanted: bool) -> None:
    if wanted:
        from sim_scenarios.version import product_version

        print(f"truenorth {product_version() or 'of a checkout that is not installed'}")
        raise typer.Exit


@app.callback()
def truenorth(
    quiet: Annotated[
        bool, typer.Option("--quiet", "-q", help="No progress, and nothing of what the FMUs say.")
    ] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="All that the FMUs say.")] = False,
    version: Annotated[  # noqa: ARG001  (it has ended the command)
        bool, typer.Option("--version", help="Print the version.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Put inertial alignment and navigation filters to the test.

    A plant FMU makes the signals of an IMU and a GNSS receiver, a filter FMU finds heading or position.

    For example:

        truenorth list                           what there is to run
        truenorth run swaying_ship               one run, one verdict, one report
        truenorth compare swaying_ship_printed   several filters, the same signals
        truenorth campaign zigzag -n 100         many runs, and what they say together
        truenorth paper zhou                     what a paper prints, and what is found
        truenorth bands zigzag -n 10             whether the filters keep their bands
        truenorth bound zigzag                   how well any filter could do
        truenorth import imu.csv gnss.pos        the description of a recording, drafted by looking
        truenorth replay imu.csv --heading 100   a recorded IMU through the filter
        truenorth derive imu.csv                 noise of sensors and fixes, from a recording
        truenorth parameters gyro                what can be set, its unit and its meaning
        truenorth export swaying_ship            for other tools: FMUs, SSP, OSP, reference results
        truenorth verify FOLDER                  whether an export is whole and still gives its results

    Each command explains itself: `truenorth run --help`. Exit code: 0 converged, or done; 1 not
    converged, or found wrong; 2 bad input; 130 interrupted; 143 terminated.
    """
    speak(Volume.quiet if quiet else Volume.verbose if verbose else Volume.normal)
