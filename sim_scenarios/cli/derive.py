"""`truenorth derive`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim_scenarios.cli.options import AsJson, written
from sim_scenarios.cli.results import Results, storing
from sim_scenarios.cli.terminal import print_json, print_pairs, progress, refusing_bad_input, say
from sim_scenarios.fmus import NAVIGATION_FILTER
from sim_scenarios.units import DEGREE


def derive_noise(
    recording: Annotated[
        Path, typer.Argument(help="Recording file (.toml), or what `replay` takes.", show_default=False)
    ],
    begin: Annotated[
        float | None,
        typer.Option("--from", help="The vehicle stands from here on [s].", show_default="found"),
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", help="It stands until here [s].", show_default="found")
    ] = None,
    filter_fmu: Annotated[
        str, typer.Option("--filter", help="FMU whose parameters are told.")
    ] = NAVIGATION_FILTER,
    heading: Annotated[
        float | None,
        typer.Option(help="Heading at the start of the drive [deg].", show_default="first course"),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            parser=written,
            metavar="PATH",
            help="Folder of parameter file and picture.",
            show_default="truenorth-derived/...",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Derive the noise of sensors and fixes from a recording, as a file for `--set-from`.

    Where the vehicle stands, the Allan deviation of each axis tells white noise, bias instability and random
    walk. From a drive with fixes, the sigmas are told with which the innovations of a filter are most likely.
    Every value has a line of evidence and a 95 % interval.

    For example:

        truenorth derive parked.csv.gz --from 300 --to 600
        truenorth derive recording.toml --output derived
        truenorth replay recording.toml --filter navigation --set-from derived/noise.toml
    """
    from sim_scenarios.folders import filled  # slow: what follows needs matplotlib and xarray
    from sim_scenarios.names import file_name
    from sim_scenarios.plots.allan import allan
    from sim_scenarios.plots.style import png
    from sim_scenarios.recordings.checks import doubts
    from sim_scenarios.recordings.derive import derive
    from sim_scenarios.recordings.description import load
    from sim_scenarios.recordings.start import Start

    with refusing_bad_input():
        folder = output or Path("truenorth-derived") / file_name(recording.name.split(".")[0])
        Results(folder)
        start = None if heading is None else Start(heading=heading * DEGREE)
        loaded = load(recording)
        for doubt in doubts(loaded):
            say(f"truenorth: {doubt}")
        with progress(recording.name) as advance:
            derived = derive(loaded, begin, end, filter_fmu=filter_fmu, start=start, progress=advance)
        with storing(folder), filled(folder, anew=True) as draft:
            (draft / "noise.toml").write_text(derived.toml(), encoding="utf-8")
            if derived.rest is not None:
                (draft / "allan.png").write_bytes(png(allan(derived.rest)))
    if derived.unused is not None:
        say(f"truenorth: {derived.unused}: the stretch at rest alone is told")
    values = {finding.name: finding for finding in derived.findings if finding.value is not None}
    if as_json:
        print_json(
            {
                "recording": derived.recording,
                "parameters": {
                    name: {"value": finding.value, "evidence": list(finding.evidence)}
                    for name, finding in values.items()
                },
                "file": str(folder / "noise.toml"),
            }
        )
        return
    print_pairs(
        {
            **{
                name: derived.fmu.variables[name].display(finding.value)
                for name, finding in values.items()
                if finding.value is not None
            },
            "File": str(folder / "noise.toml"),
        }
    )
