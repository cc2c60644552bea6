"""`truenorth replay`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sim_scenarios.cli.beginning import (
    COURSE_SPEED,
    LEVELLING,
    CourseSpeed,
    Heading,
    HeadingSigma,
    Levelling,
    StartsAt,
    Through,
    Where,
    begin,
)
from sim_scenarios.cli.options import AsJson, Output, Settings, SettingsFile, axes, settings
from sim_scenarios.cli.results import Results, storing
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
from sim_scenarios.folders import filled
from sim_scenarios.recordings.choices import Filter, Format

if TYPE_CHECKING:
    import xarray as xr


def replay_recording(
    file: Annotated[
        Path,
        typer.Argument(
            help="The recording: its description (recording.toml), or one file that has it all.",
            show_default=False,
        ),
    ],
    filter_: Through = Filter.alignment,
    heading: Heading = None,
    heading_sigma: HeadingSigma = None,
    start: StartsAt = Where.first,
    course_speed: CourseSpeed = COURSE_SPEED,
    levelling: Levelling = LEVELLING,
    zero_velocity: Annotated[
        bool, typer.Option("--zero-velocity", help="The vehicle stands still: aid with fixes of velocity 0.")
    ] = False,
    position: Annotated[
        str,
        typer.Option(
            help="Where it stands or starts: latitude [deg], longitude [deg], height [m].",
            metavar="LAT,LON,HEIGHT",
            show_default=False,
        ),
    ] = "",
    sigma: Annotated[float, typer.Option(help="Sigma of the zero velocity [m/s].")] = 0.02,
    rate: Annotated[float, typer.Option(help="Rate of the zero-velocity fixes [Hz].")] = 1.0,
    outages_: Annotated[
        float | None,
        typer.Option("--outages", help="Withhold the fixes for so long [s], at the end of every period."),
    ] = None,
    every: Annotated[float, typer.Option(help="That period [s].")] = 180.0,
    reference: Annotated[
        Path | None,
        typer.Option(help="File with a reference, in the place of the recording's own.", show_default=False),
    ] = None,
    evaluate_after: Annotated[
        float | None,
        typer.Option(
            help="Seconds after the start from which on the result is judged; by default 60, or half of a "
            "shorter recording.",
            show_default=False,
        ),
    ] = None,
    smooth: Annotated[
        bool,
        typer.Option(
            "--smooth",
            help="Smooth the navigation too, by all fixes, those that come later included. It stands beside "
            "the filter's, and is what --export writes.",
        ),
    ] = False,
    export_: Annotated[
        list[Format] | None,
        typer.Option(
            "--export", help="Write the navigation in this format too. Repeatable.", show_default=False
        ),
    ] = None,
    output: Output = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(
            "--axis",
            metavar="NAME=VALUE,VALUE...",
            help="Values of a filter parameter; repeat it for others. Every combination is a filter, and all "
            "of them are put beside each other.",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[  # noqa: ARG001
        int | None,
        typer.Option(
            help="Accepted as by `run`, without effect: a recording has no random streams.",
            show_default=False,
        ),
    ] = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    as_json: AsJson = False,
) -> None:
    r"""Align on a recording, navigate, or navigate after an alignment.

    The file describes a recording (*recording.toml*; `truenorth import` drafts one), or is one: in a format
    that is known by itself, or a CSV file with a header and the columns *time* [s, end of the interval],
    *delta_angle_x, _y, _z* [rad] and *delta_velocity_x, _y, _z* [m/s] (right, forward, up; increments over
    the interval, not rates). GNSS comes from the columns *gnss_velocity_east, _north, _up* [m/s],
    *gnss_latitude, gnss_longitude* [deg], *gnss_height* [m] and, if present, *gnss_time* [s], which are empty
    in rows without a fix; or from `--zero-velocity` at a `--position`. Where the recording has a reference,
    errors are those against it.

    For example:

        truenorth replay ship.csv.gz --heading 45 --heading-sigma 15
        truenorth replay parked.csv.gz --heading 100.6 --zero-velocity \
            --position "34.246048,108.909664,380" \
            --set prior.gyro_bias_sigma="0.02 deg/h" \
            --set prior.accelerometer_bias_sigma="0.1 mg" \
            --set process.angle_random_walk="0.001 deg/h^0.5"
        truenorth replay recording.toml --filter navigation --start course --outages 60 --every 180
        truenorth replay recording.toml --filter align_then_navigate --export kml
        truenorth replay recording.toml --filter navigation --start course --smooth --outages 60
        truenorth replay recording.toml --filter navigation --start course --outages 60 \
            --axis error_model=loose,full_state --axis corrector=standard,igg

    Exit code 0 when the filter reports convergence at the end; with --axis, when all filters do.
    """
    from sim_scenarios import report  # slow: xarray, scipy
    from sim_scenarios.matrix import combinations
    from sim_scenarios.metrics.status import status_at_end
    from sim_scenarios.names import file_name
    from sim_scenarios.recordings import outages, side_by_side, smoothing
    from sim_scenarios.recordings.exports import check, export
    from sim_scenarios.recordings.replay import replay
    from sim_scenarios.recordings.zero_velocity import ZeroVelocity

    with refusing_bad_input():
        results = Results(output)
        for form in export_ or []:
            check(form)
        place = _position(position) if position or zero_velocity else None
        begun = begin(heading, heading_sigma, start, course_speed, levelling, place)
        aiding = ZeroVelocity(place, sigma, rate) if zero_velocity and place else None
        conditions: dict[str, Any] = {
            "start": begun,
            "filter": filter_,
            "zero_velocity": aiding,
            "outages": None if outages_ is None else outages.Outages(outages_, every),
            "reference": reference,
            "evaluate_after": evaluate_after,
            "smooth": smooth,
            "set": settings(set_, set_from),
        }
        name = file_name(f"replay-{file.name.split('.')[0]}")
        if axis:
            if export_:
                raise InputError(f"--export {export_[0].value}: is of one filter; leave out --axis")
            with results.folder(name) as folder:
                ok = _side_by_side(file, combinations(axes(axis)), conditions, folder, as_json)
            raise typer.Exit(0 if ok else 1)
        with progress(file.name) as advance:
            run = replay(file, **conditions, progress=advance)

        def written(data: xr.Dataset, folder: Path) -> Path:
            best = smoothing.solution(data) if smoothing.is_smoothed(data) else data
            for form in export_ or []:
                export(best, folder / f"track.{form.value}")
            return report.report_replay(data, folder)

    files = refusing_bad_input()(partial(results.write, run, written, name))
    converged = report.replay_converged(run)
    headings = report.heading_table(run)
    ends, both = outages.ends(run), report.filtered_and_smoothed(run)
    smoothed_ends = outages.ends(both["smoothed"]) if both else None
    if as_json:
        keys = ("time_s", "heading_deg", "sigma_deg")
        rows = [dict(zip(keys, map(float, row), strict=False)) for row in headings[1:]]
        about = {"recording": str(file), "converged": converged, "status": status_at_end(run)}
        print_json({**about, "headings": rows, **_figures(run), **files()})
    else:
        say_messages(run)
        print_table(headings)
        if ends:
            print_table(outages.table(ends, smoothed_ends))
        if both:
            print_table(side_by_side.table(both))
        print_verdict(report.replay_sentence(run), converged)
        figures = {**report.heading_at_end(run), **report.replay_figures(run)}
        print_pairs({**figures, "Report": lambda: files()["report"]})
    raise typer.Exit(0 if converged else 1)


def _side_by_side(
    file: Path,
    filters: Mapping[str, Mapping[str, object]],
    conditions: dict[str, Any],
    folder: Path,
    as_json: bool,
) -> bool:
    """Replay several filters and show them; whether all report convergence."""
    from sim_scenarios import report
    from sim_scenarios.metrics.status import status_at_end
    from sim_scenarios.names import file_names
    from sim_scenarios.recording import save
    from sim_scenarios.recordings import side_by_side, smoothing

    with progress(file.name) as advance:
        runs = side_by_side.replays(file, filters, progress=advance, **conditions)
    names = {label: f"{name}.nc" for label, name in file_names(runs).items()}
    with storing(folder), filled(folder, anew=True) as draft:
        report.report_replays(runs, draft)
        for label, run in runs.items():
            save(run, draft / names[label])
    page = str(folder / "report.html")
    converged = {label: report.replay_converged(run) for label, run in runs.items()}
    if as_json:
        told = {
            label: {
                "converged": converged[label],
                "status": status_at_end(run),
                **_figures(run),
                "recording": str(folder / names[label]),
            }
            for label, run in runs.items()
        }
        print_json({"recording": str(file), "filters": told, "report": page})
    else:
        say_messages(side_by_side.together(runs))
        print_table(side_by_side.table(smoothing.beside(runs)))
        print_verdict(report.replays_sentence(runs), all(converged.values()))
        print_pairs({"Report": page})
    return all(converged.values())


def _figures(run: xr.Dataset) -> dict[str, Any]:
    """What the result was worth, for machines."""
    from sim_scenarios.recordings import comparison, outages, smoothing

    referred, ends = comparison.against_reference(run), outages.ends(run)
    smoothed = _figures(smoothing.solution(run)) if smoothing.is_smoothed(run) else None
    return {
        "against_fixes": comparison.against_fixes(run).figures(),
        **({} if referred is None else {"against_reference": referred.figures()}),
        **({"outages": outages.figures(ends)} if ends else {}),
        **({} if smoothed is None else {"smoothed": smoothed}),
    }


def _position(text: str) -> tuple[float, float, float]:
    try:
        latitude, longitude, height = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"--position '{text}': write LATITUDE,LONGITUDE,HEIGHT in deg, deg, m, such as 34.2,108.9,380"
        ) from None
    return latitude, longitude, height
