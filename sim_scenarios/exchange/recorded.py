"""A recording as a system: the Playback FMU with the recording in it, and what it is fed to."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from sim_scenarios.archives import read_archive, write_archive
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import signals
from sim_scenarios.exchange.forms import FORMS
from sim_scenarios.exchange.reference import OUTPUT_INTERVAL
from sim_scenarios.exchange.system import PLANT, Plan, System, connected_system
from sim_scenarios.fmus import PLAYBACK, Fmu, Fmus, Number
from sim_scenarios.names import file_name
from sim_scenarios.recordings import reference as references
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.feed import SAME_MOMENT, Feed, feed
from sim_scenarios.recordings.replay import believed, parts_of, values_of
from sim_scenarios.recordings.start import Start, beginning
from sim_scenarios.recordings.tables import Recording, ReferenceTable

CHECKED: Final = 60.0
"""Longest stretch of which there are reference results [s]: their inputs are text, a row for each step."""


def playback(template: Fmu, folder: Path, fed: Feed, truth: ReferenceTable | None) -> Fmu:
    """The Playback FMU with a recording.

    Parameters
    ----------
    template : Fmu
        Playback as it is built.
    folder : Path
        Where it is written, in all versions of FMI.
    fed : Feed
        What it plays.
    truth : ReferenceTable or None
        What it puts out as the truth.

    Returns
    -------
    Fmu
        FMI 2; the FMI 3 one lies in `fmi3` beside it.
    """
    content = signals.content(fed, truth)
    for form in FORMS:
        built = form.archive(template)
        place = folder / built.relative_to(template.path.parent)
        write_archive(place, {**read_archive(built), signals.FILE: content})
    return Fmu(folder / template.path.name)


def of_recording(
    recording: Recording,
    start: Start,
    folder: Path,
    *,
    task: Filter,
    settings: Mapping[str, object],
    fmus: Fmus,
    step: float | None = None,
) -> System:
    """FMUs of a recording; the first filter starts as in `recordings.replay`.

    Parameters
    ----------
    recording : Recording
        What is played.
    start : Start
        What is known at the start.
    folder : Path
        Where the Playback FMU is written.
    task : Filter
        What the recording goes through.
    settings : mapping
        Parameters by name, of the filters as for `recordings.replay`, or of Playback.
    fmus : Fmus
        Playback as it is built, and the filters.
    step : float, optional
        Communication step [s]; by default one in which no two samples come.

    Returns
    -------
    System

    Raises
    ------
    InputError
        When the recording lacks what is needed, or a setting is wrong.
    """
    begun, parts, template = beginning(recording, start), parts_of(task, fmus), fmus[PLAYBACK]
    of_source: dict[str, Number] = {"recording.skip": template.start("recording.skip")}
    of_filters = {}
    if "recording.skip" in settings:
        raise InputError(
            f"recording.skip = {settings['recording.skip']}: an exported filter starts where its recording "
            "begins; set it in the tool, and initial.* of the filter to what holds then"
        )
    if step is not None and not (np.isfinite(step) and step > 0):
        raise InputError(f"step = {step:g}: must be positive [s]")
    for name, value in settings.items():
        if template.has_parameter(name):
            of_source |= template.assignments(name, value)
        else:
            of_filters[name] = value
    values, _ = values_of(parts, recording, begun, of_filters)
    fed = feed(believed(recording, values), begun.time)
    source = playback(template, folder, fed, recording.reference)
    step = signals.suitable_step(fed.time) if step is None else step
    steps = int(np.ceil((fed.time[-1] - fed.time[0] - SAME_MOMENT) / step)) + 1  # the filter is one behind
    row = max(1, round(OUTPUT_INTERVAL / step))
    checked = min(steps // row, round(CHECKED / OUTPUT_INTERVAL)) * row or steps
    plan = Plan(
        file_name(recording.name), f"{recording.name}, {begun.words}", steps * step, step, checked * step
    )
    truth = {} if recording.reference is None else references.at(recording.reference, fed.time)
    told = ["recording.time", *(name for name, column in truth.items() if np.isfinite(column).any())]
    return connected_system(plan, {PLANT: source, **parts}, {PLANT: of_source, **values}, told)
