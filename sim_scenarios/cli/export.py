"""`truenorth export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

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
from sim_scenarios.cli.options import AsJson, Seed, Settings, SettingsFile, scenarios, settings, written
from sim_scenarios.cli.results import Results, storing
from sim_scenarios.cli.terminal import print_json, print_pairs, refusing_bad_input
from sim_scenarios.errors import InputError
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.stepping import EXPORTED_STEP


def export_system(
    what: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|RECORDING",
            help="Name of a shipped scenario (`truenorth list`) or of a TOML file of one; or a recording, as "
            "for `truenorth replay`.",
            show_default=False,
            autocompletion=scenarios,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            parser=written,
            metavar="PATH",
            help="Folder to write.",
            show_default="truenorth-export/NAME",
        ),
    ] = None,
    seed: Seed = None,
    set_: Settings = None,
    set_from: SettingsFile = None,
    step: Annotated[
        float | None,
        typer.Option(
            help="Communication step of the exported system [s].",
            show_default=f"{EXPORTED_STEP}, or of a recording one in which no two samples come",
        ),
    ] = None,
    sign: Annotated[
        Path | None,
        typer.Option(
            metavar="KEY",
            help="PEM file of a private key (Ed25519) to sign the lists of checksums with, for `truenorth "
            "verify --signed-by`; needs the extra `sign`.",
        ),
    ] = None,
    filter_: Through = Filter.alignment,
    heading: Heading = None,
    heading_sigma: HeadingSigma = None,
    start: StartsAt = Where.first,
    course_speed: CourseSpeed = COURSE_SPEED,
    levelling: Levelling = LEVELLING,
    as_json: AsJson = False,
) -> None:
    """Write a scenario or a recording for other tools: FMUs, SSP, OSP, parameters, reference results.

    Of a recording (*recording.toml*, or a file that has it all), the FMU `Playback` puts out what was
    measured, and the filters start on it as in `truenorth replay`, whose options these are: `--filter`,
    `--heading`, `--heading-sigma`, `--start`, `--course-speed` and `--levelling`.

    For example:

        truenorth export swaying_ship
        truenorth export zigzag --output partner --seed 7 --step 0.01
        truenorth export recording.toml --filter navigation --start course

    At the end it prints what to tell the partner by another way than the folder goes, for `truenorth verify`.
    """
    from sim_scenarios.exchange import export, export_recording  # slow: xarray, scipy
    from sim_scenarios.exchange.verification import fingerprint
    from sim_scenarios.names import file_name
    from sim_scenarios.recordings.description import is_recording
    from sim_scenarios.recordings.start import Start

    with refusing_bad_input():
        recorded = is_recording(Path(what))
        if recorded and seed is not None:
            raise InputError(f"--seed: {what} is a recording, which has no random streams")
        begun = begin(heading, heading_sigma, start, course_speed, levelling)
        if not recorded and (filter_, begun) != (Filter.alignment, Start()):
            raise InputError(
                f"{what} is a scenario; --filter and the options of the start are for recordings"
            )
        folder = output or Path("truenorth-export") / file_name(Path(what).name.split(".")[0])
        Results(folder)
        given = settings(set_, set_from)
        with storing(folder):
            if recorded:
                system = export_recording(
                    what, folder, begun, filter=filter_, set=given, step=step, sign=sign
                )
            else:
                step = EXPORTED_STEP if step is None else step
                system = export(what, folder, seed=seed, set=given, step=step, sign=sign)
    told = fingerprint(folder)
    files = {"ssp": str(folder / f"{system.name}.ssp"), "readme": str(folder / "README.md")}
    kind = "recording" if recorded else "scenario"
    if as_json:
        print_json({kind: system.name, "communication_step": system.step, **files, "sha256": told})
    else:
        read = {"System": files["ssp"], "Read first": files["readme"], "To be told": f"--expect {told}"}
        print_pairs({kind.capitalize(): system.name, **read})
