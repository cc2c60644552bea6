"""The command `truenorth`: every subcommand is one function call of the package and a report."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
import xarray as xr
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from sim_scenarios import recorded_imu, recording, report, simulation
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.metrics import judge
from sim_scenarios.scenario import shipped, toml_value
from sim_scenarios.units import ARCMIN, DEGREE

app = typer.Typer(
    name="truenorth",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    add_completion=False,
)

Scenario = Annotated[
    str,
    typer.Argument(
        help="Name of a shipped scenario (`truenorth list`), or path of a TOML file.", show_default=False
    ),
]
Output = Annotated[
    Path | None,
    typer.Option("--output", "-o", help="Folder of the report.", show_default="truenorth-results/..."),
]
Seed = Annotated[
    int | None, typer.Option(help="Seed of every random stream.", show_default="of the scenario")
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Set a parameter of an FMU or an entry of the scenario; SI units, or with a unit. Repeatable.",
        show_default=False,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, and nothing else there.")
]


@app.callback()
def truenorth() -> None:
    """Put inertial alignment filters to the test.

    A plant FMU makes the signals of an IMU and a GNSS receiver, a filter FMU finds the heading.

    For example:

        truenorth list                           what there is to run
        truenorth run swaying_ship               one run, one verdict, one report
        truenorth compare swaying_ship_printed   several filters, the same signals
        truenorth bound zigzag                   how well any filter could do
        truenorth replay imu.csv --heading 100   a recorded IMU through the filter

    Each command explains itself: `truenorth run --help`. Exit code: 0 converged, 1 not converged, 2 bad
    input.
    """


@app.command("list")
def list_scenarios(as_json: AsJson = False) -> None:
    """List the scenarios that come with the package."""
    scenarios = shipped()
    if as_json:
        print(json.dumps(scenarios, indent=2))
        return
    table = Table(box=None, pad_edge=False)
    table.add_column("scenario", style="bold")
    table.add_column("what happens")
    for name, description in scenarios.items():
        table.add_row(name, description)
    _console().print(table)


@app.command("run")
def run_scenario(
    scenario: Scenario,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Run a scenario with its filter and judge the heading.

    For example:

        truenorth run swaying_ship
        truenorth run swaying_ship --seed 7
        truenorth run swaying_ship --set prior.heading_sigma="20 deg"
        truenorth run zigzag --set corrector=standard --set gnss.rate=5
        truenorth run my_ship.toml --output results --json

    Exit code 0 when the heading converged, 1 when it did not.
    """
    with _refusing_bad_input():
        with _progress(f"{scenario}") as progress:
            run = simulation.run(scenario, seed=seed, set=_settings(set_), progress=progress)
        verdict = judge(run)
        page, files = _results(
            run, report.report_run, output, f"{run.attrs['scenario']}-seed{run.attrs['seed']}"
        )
    result = {"scenario": run.attrs["scenario"], "seed": run.attrs["seed"], **verdict.to_json(), **files}
    if as_json:
        print(json.dumps(result, indent=2))
    else:
        _say_messages(run)
        console = _console()
        colour = "green" if verdict.converged else "red"
        console.print(f"[bold {colour}]{report.sentence(verdict)}[/]")
        start, stop = run.attrs["evaluation.start"], run.attrs["evaluation.stop"]
        _print_pairs(
            console,
            {
                f"heading RMSE, {start:g} to {stop:g} s": f"{verdict.heading_rmse / ARCMIN:.2f} arcmin",
                "Cramer-Rao bound": f"{verdict.bound / ARCMIN:.2f} arcmin",
                "converged": "yes" if verdict.converged else "no",
                "report": str(page),
            },
        )
    raise typer.Exit(0 if verdict.converged else 1)


@app.command("compare")
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
    with _refusing_bad_input():
        with _progress(f"{scenario}") as progress:
            runs = simulation.compare(scenario, seed=seed, set=_settings(set_), progress=progress)
        verdicts = {str(label): judge(runs.sel(filter=label)) for label in runs["filter"].values}
        page, files = _results(
            runs,
            report.report_comparison,
            output,
            f"{runs.attrs['scenario']}-seed{runs.attrs['seed']}-comparison",
        )
    converged = all(verdict.converged for verdict in verdicts.values())
    if as_json:
        filters = {label: verdict.to_json() for label, verdict in verdicts.items()}
        print(
            json.dumps(
                {"scenario": runs.attrs["scenario"], "seed": runs.attrs["seed"], "filters": filters, **files},
                indent=2,
            )
        )
    else:
        _say_messages(runs)
        console = _console()
        _print_table(console, report.comparison_table(verdicts))
        if runs.attrs["notes"]:
            console.print(runs.attrs["notes"].strip().replace("\n", " "), style="italic")
        bound = f"{runs.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin"
        _print_pairs(console, {"Cramer-Rao bound": bound, "report": str(page)})
    raise typer.Exit(0 if converged else 1)


@app.command("bound")
def show_bound(
    scenario: Scenario,
    output: Output = None,
    seed: Seed = None,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Show how well any filter could know the heading in a scenario.

    The posterior Cramer-Rao bound along the true trajectory; no filter runs.

    For example:

        truenorth bound zigzag
        truenorth bound waves --set gnss.velocity_sigma=0.02 --set gnss.rate=10
    """
    with _refusing_bad_input():
        data = simulation.bound(scenario, seed=seed, set=_settings(set_))
        page, files = _results(data, report.report_bound, output, f"{data.attrs['scenario']}-bound")
    if as_json:
        arcmin = data["bound.heading_sigma"].values / ARCMIN
        figures = {
            "bound_arcmin": data.attrs["bound.heading_rms"] / ARCMIN,
            "time_s": data["bound_time"].values.tolist(),
        }
        print(
            json.dumps(
                {
                    "scenario": data.attrs["scenario"],
                    **figures,
                    "heading_sigma_arcmin": arcmin.tolist(),
                    **files,
                },
                indent=2,
            )
        )
        return
    console = _console()
    _print_table(console, report.bound_table(data))
    start, stop = data.attrs["evaluation.start"], data.attrs["evaluation.stop"]
    rms = f"{data.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin"
    _print_pairs(console, {f"RMS over {start:g} to {stop:g} s": rms, "report": str(page)})


@app.command("replay")
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
    *delta_velocity_x, _y, _z* [m/s] (right, forward, up). GNSS comes from the columns *gnss_velocity_east,
    _north, _up* [m/s], *gnss_latitude, gnss_longitude* [deg], *gnss_height* [m] and, if present, *gnss_time*
    [s], which are empty in rows without a fix; or from `--zero-velocity` at a `--position`.

    For example:

        truenorth replay ship.csv.gz --heading 45 --heading-sigma 15
        truenorth replay parked.csv.gz --heading 100.6 --zero-velocity \
            --position "34.246048,108.909664,380" \
            --set prior.gyro_bias_sigma="0.02 deg/h" \
            --set prior.accelerometer_bias_sigma="0.1 mg" \
            --set process.angle_random_walk="0.001 deg/h^0.5"

    Exit code 0 when the filter reports convergence at the end.
    """
    with _refusing_bad_input():
        start = recorded_imu.Start(heading * DEGREE, heading_sigma * DEGREE, levelling)
        aiding = recorded_imu.ZeroVelocity(_position(position), sigma, rate) if zero_velocity else None
        with _progress(file.name) as progress:
            run = recorded_imu.replay(
                file, start, zero_velocity=aiding, set=_settings(set_), progress=progress
            )
        page, files = _results(run, report.report_replay, output, f"replay-{file.name.split('.')[0]}")
    converged = bool(run["converged"].values[-1])
    headings = report.heading_table(run)
    if as_json:
        keys = ("time_s", "heading_deg", "sigma_deg")
        rows = [dict(zip(keys, map(float, row), strict=False)) for row in headings[1:]]
        print(
            json.dumps({"recording": str(file), "converged": converged, "headings": rows, **files}, indent=2)
        )
    else:
        _say_messages(run)
        console = _console()
        _print_table(console, headings)
        final, sigma_at_end = (float(run[n].values[-1]) / DEGREE for n in ("nav.heading", "heading_sigma"))
        _print_pairs(
            console,
            {
                "heading at the end": f"{final:.3f} +- {sigma_at_end:.3f} deg",
                "converged": "yes" if converged else "no",
                "report": str(page),
            },
        )
    raise typer.Exit(0 if converged else 1)


@contextmanager
def _refusing_bad_input() -> Iterator[None]:
    """Turn what the user can mend into a sentence and exit code 2."""
    try:
        yield
    except (InputError, SimulationError) as error:
        typer.echo(f"truenorth: {error}", err=True)
        raise typer.Exit(2) from None


@contextmanager
def _progress(title: str) -> Iterator[Callable[[float], None]]:
    """Progress on standard error: a bar on a terminal, else a line for each quarter."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _quarters(title)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        last = time.monotonic()

        def advance(share: float) -> None:
            nonlocal last
            if (now := time.monotonic()) - last > 0.05 or share >= 1:
                last = now
                bar.update(task, completed=share)

        yield advance


def _quarters(title: str) -> Callable[[float], None]:
    reported = 0

    def advance(share: float) -> None:
        nonlocal reported
        if (quarter := int(4 * share)) > reported:
            reported = quarter
            print(f"{title}: {25 * quarter} %", file=sys.stderr, flush=True)

    return advance


def _settings(given: list[str] | None) -> dict[str, object]:
    """Settings NAME=VALUE; a value is read as in a scenario file, a bare text needs no quotes."""
    settings: dict[str, object] = {}
    for setting in given or []:
        name, equals, text = setting.partition("=")
        if not equals or not name.strip():
            raise InputError(f"--set {setting}: write NAME=VALUE")
        settings[name.strip()] = toml_value(text)
    return settings


def _position(text: str) -> tuple[float, float, float]:
    try:
        latitude, longitude, height = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"--position '{text}': write LATITUDE,LONGITUDE,HEIGHT in deg, deg, m, such as 34.2,108.9,380"
        ) from None
    return latitude, longitude, height


def _results(
    data: xr.Dataset, write: Callable[[xr.Dataset, Path], Path], output: Path | None, name: str
) -> tuple[Path, dict[str, Any]]:
    """Write report and recording; the path of the page, and the paths for machines."""
    folder = output or Path("truenorth-results") / name
    try:
        page = write(data, folder)
        recording.save(data, folder / "recording.nc")
    except OSError as error:
        raise InputError(f"--output {folder}: {error.strerror}") from None
    return page, {"report": str(page), "recording": str(folder / "recording.nc")}


def _console() -> Console:
    """Standard output; wide where it is not a terminal, so that a log keeps its lines."""
    console = Console()
    return console if console.is_terminal else Console(width=160)


def _say_messages(data: xr.Dataset, most: int = 5) -> None:
    messages = json.loads(data.attrs["messages"])
    console = Console(stderr=True, highlight=False)
    for message in messages[:most]:
        console.print(message, style="dim", markup=False)
    if len(messages) > most:
        console.print(f"... and {len(messages) - most} more messages, in the report", style="dim")


def _print_table(console: Console, rows: list[list[str]]) -> None:
    table = Table(box=None, pad_edge=False)
    for i, title in enumerate(rows[0]):
        table.add_column(title.replace("[", r"\["), justify="right" if i else "left")
    for row in rows[1:]:
        table.add_row(*row)
    console.print(table)


def _print_pairs(console: Console, pairs: dict[str, str]) -> None:
    width = max(map(len, pairs))
    for name, value in pairs.items():
        console.print(f"{name:<{width}}  {value}", soft_wrap=True, highlight=False, markup=False)


if __name__ == "__main__":
    app()
