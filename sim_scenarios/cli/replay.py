"""`truenorth replay`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios import recorded_imu, report
from sim_scenarios.cli.options import AsJson, Output, Settings, settings
from sim_scenarios.cli.results import Results
from sim_scenarios.cli.terminal import (
    print_json,
    print_pairs,
    print_table,
    print_verdict,
    progress,
    refusing_bad_input,
    say_messages,
)
from sim_scenarios.errors import InputError
from sim_scenarios.metrics.verdict import status_at_end
from sim_scenarios.names import file_name
from sim_scenarios.units import DEGREE


def replay_recording(
    file: Annotated[
        Path, typer.Argument(help="CSV file of the recording (.csv or .csv.gz).", show_default=False)
    ],
    heading: Annotated[
        float, typer.Option(help="Heading to start from [deg], clockwise from north.", show_default=False)
    ],
    heading_sigma: Annotated[float, typer.Option(help="Sigma of that heading [deg].")] = 10.0,
    zero_velocity: Annotated[
        bool, typer.Option("--zero-velocity", help="The vehicle stands still: aid with fixes of velocity 0.")
    ] = False,
    position: Annotated[
        str,
        typer.Option(
            help="Where it stands: latitude [deg], longitude [deg], height [m].",
            metavar="LAT,LON,HEIGHT",
            show_default=False,
        ),
    ] = "",
    sigma: Annotated[float, typer.Option(help="Sigma of the zero velocity [m/s].")] = 0.02,
    rate: Annotated[float, typer.Option(help="Rate of the zero-velocity fixes [Hz].")] = 1.0,
    levelling: Annotated[
        float, typer.Option(help="Seconds at the start whose mean specific force gives roll and pitch.")
    ] = 1.0,
    output: Output = None,
    seed: Annotated[  # noqa: ARG001
        int | None,
        typer.Option(
            help="Accepted as by `run`, without effect: a recording has no random streams.",
            show_default=False,
        ),
    ] = None,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    r"""Align on a recorded IMU.

    The file has a header and the columns *time* [s, end of the interval], *delta_angle_x, _y, _z* [rad] and
    *delta_velocity_x, _y, _z* [m/s] (right, forward, up; increments over the interval, not rates). GNSS comes
    from the columns *gnss_velocity_east, _north, _up* [m/s], *gnss_latitude, gnss_longitude* [deg],
    *gnss_height* [m] and, if present, *gnss_time* [s], which are empty in rows without a fix; or from
    `--zero-velocity` at a `--position`.

    For example:

        truenorth replay ship.csv.gz --heading 45 --heading-sigma 15
        truenorth replay parked.csv.gz --heading 100.6 --zero-velocity \
            --position "34.246048,108.909664,380" \
            --set prior.gyro_bias_sigma="0.02 deg/h" \
            --set prior.accelerometer_bias_sigma="0.1 mg" \
            --set process.angle_random_walk="0.001 deg/h^0.5"

    Exit code 0 when the filter reports convergence at the end.
    """
    with refusing_bad_input():
        results = Results(output)
        start = recorded_imu.Start(heading * DEGREE, heading_sigma * DEGREE, levelling)
        aiding = recorded_imu.ZeroVelocity(_position(position), sigma, rate) if zero_velocity else None
        with progress(file.name) as advance:
            run = recorded_imu.replay(file, start, zero_velocity=aiding, set=settings(set_), progress=advance)
        files = results.write(run, report.report_replay, file_name(f"replay-{file.name.split('.')[0]}"))
    converged = report.replay_converged(run)
    headings = report.heading_table(run)
    if as_json:
        keys = ("time_s", "heading_deg", "sigma_deg")
        rows = [dict(zip(keys, map(float, row), strict=False)) for row in headings[1:]]
        about = {"recording": str(file), "converged": converged, "status": status_at_end(run)}
        print_json({**about, "headings": rows, **files})
    else:
        say_messages(run)
        print_table(headings)
        print_verdict(report.replay_sentence(run), converged)
        print_pairs({**report.heading_at_end(run), "Report": files["report"]})
    raise typer.Exit(0 if converged else 1)


def _position(text: str) -> tuple[float, float, float]:
    try:
        latitude, longitude, height = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"--position '{text}': write LATITUDE,LONGITUDE,HEIGHT in deg, deg, m, such as 34.2,108.9,380"
        ) from None
    return latitude, longitude, height
