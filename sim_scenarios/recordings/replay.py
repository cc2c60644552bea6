"""A recording through the filters."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import ExitStack, closing
from dataclasses import replace as changed
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording as results
from sim_scenarios.cosimulation import (
    AlignmentSource,
    Progress,
    Recorded,
    RecordedSource,
    Sink,
    Source,
    simulate,
)
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, Fmu, Fmus, Number, no_such_parameter
from sim_scenarios.instance import Instance
from sim_scenarios.recordings import checks, fixes, smoothing
from sim_scenarios.recordings import reference as references
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.description import load
from sim_scenarios.recordings.feed import Feed, feed
from sim_scenarios.recordings.outages import Outages, within
from sim_scenarios.recordings.start import Beginning, Start, beginning
from sim_scenarios.recordings.tables import FixTable, Recording, ReferenceTable
from sim_scenarios.recordings.zero_velocity import ZeroVelocity
from sim_scenarios.stepping import Order
from sim_scenarios.version import product_version

Array = NDArray[np.float64]
Values = dict[str, dict[str, Number]]
"""Parameters of the filters by scalar name, by the filter's part."""

RECORDING_PERIOD: Final = 0.1  # s
SETTLING: Final = 60.0
"""Seconds that a filter is given before it is judged."""
ANY_HEADING: Final[Mapping[str, object]] = {
    "error_model": "invariant",
    "predictor": "linearised",
    "corrector": "standard",
}
"""An AlignmentFilter that needs no heading to start from."""
LEAST_SIGMAS: Final[Mapping[str, str]] = {
    "position": "measurement.position_sigma",
    "height": "measurement.height_sigma",
    "velocity": "measurement.velocity_sigma",
}
"""Parameters below which, where they are told, no recorded fix is believed: a receiver does not know of late
stamps, of how its antenna moves and of errors that do not change from fix to fix."""
NO_COARSE_STAGE: Final = (
    "no fix has both position and velocity whole, as the coarse stage needs: the alignment begins without it "
    "(coarse.enabled = false)"
)


def replay(
    recording: Recording | str | Path,
    start: Start | None = None,
    *,
    filter: Filter | str = Filter.alignment,  # noqa: A002  (the word of the command line)
    zero_velocity: ZeroVelocity | None = None,
    outages: Outages | None = None,
    reference: str | Path | None = None,
    evaluate_after: float | None = None,
    smooth: bool = False,
    set: Mapping[str, object] | None = None,  # noqa: A002
    progress: Progress = lambda _: None,
    fmus: Fmus | None = None,
) -> xr.Dataset:
    """Align on a recording, navigate, or navigate after an alignment.

    Parameters
    ----------
    recording : Recording, str or Path
        A recording, or what `recordings.load` reads as one.
    start : Start, optional
        What is known at the start.
    filter : Filter or str
        "alignment", "navigation" or "align_then_navigate". An alignment of which neither heading nor error
        model is told uses the invariant model, which needs none; so does one before navigation.
    zero_velocity : ZeroVelocity, optional
        Fixes of zero velocity in the place of recorded GNSS.
    outages : Outages, optional
        Times in which the filter gets no fix.
    reference : str or Path, optional
        File with a reference in the place of the recording's own.
    evaluate_after : float, optional
        Seconds after the start from which on the result is judged; by default 60, or half of what there is.
    smooth : bool
        Smooth the navigation too.
    set : mapping, optional
        Parameters by name, in SI units or with a unit. Of an alignment before navigation, those of
        AlignmentFilter begin with `alignment.`, those of NavigationFilter with `filter.`; without either they
        are for both where both have them. Sigmas that recorded fixes have of their own are raised to those of
        `measurement.*` of the (navigation) filter, where these are told. By default an alignment has no
        coarse stage where no fix is whole.
    progress : callable
        Called with the completed share.
    fmus : Fmus, optional
        Those that are loaded already, to load them once for many recordings.

    Returns
    -------
    xarray.Dataset
        As that of `sim_scenarios.run`. Besides, over the dimension `receiver` the fixes of the recording,
        over `outage` begin and end of the outages, and the `lever_arm` (axis3). A reference is the truth. The
        attribute `epoch` is that of the recording, where its date is known. What is smoothed begins with
        `smoothed.`; `smoothing.solution` puts it in the place of the filter's.

    Raises
    ------
    InputError
        When the recording lacks what is needed, or a setting is wrong.
    """
    task, start, fmus = Filter(filter), start or Start(), fmus or Fmus()
    if not isinstance(recording, Recording):
        recording = load(Path(recording))
    if zero_velocity is not None:
        recording = changed(recording, gnss=zero_velocity.fixes(recording.imu))
    if reference is not None:
        told, on_reference = references.of_file(Path(reference), recording)
        recording = changed(recording, reference=told, remarks=(*recording.remarks, *on_reference))
    begun = beginning(recording, start)
    parts = parts_of(task, fmus)
    values, without_coarse_stage = values_of(parts, recording, begun, set or {})
    if smooth:
        smoothing.check(parts["filter"], values["filter"], recording)
    if zero_velocity is None:
        recording = believed(recording, values)
    fed = feed(recording, begun.time)
    windows = outages.windows(begun.time, float(fed.time[-1])) if outages else np.empty((0, 2))
    if recording.gnss is not None and len(windows):
        received = fixes.selected(recording.gnss, ~within(recording.gnss.time, windows))
        fed = feed(changed(recording, gnss=received), begun.time)
    remarks = [remark for remark in (*checks.doubts(recording), fed.remark, without_coarse_stage) if remark]
    lasts = float(fed.time[-1] - fed.time[0])
    if evaluate_after is None:
        evaluate_after = min(SETTLING, lasts / 2)
    elif not 0 <= evaluate_after < lasts:
        raise InputError(
            f"evaluate_after = {evaluate_after:g} s: must be at least 0 and less than the {lasts:g} s that "
            f"{recording.name} lasts from the start on"
        )
    data, said = _run(parts, values, fed, recording.reference, smooth, fmus, progress)
    data = _with_receiver(data, recording.gnss, fed, windows)
    arm = [values["filter"].get(f"gnss.lever_arm[{i}]", 0.0) for i in (1, 2, 3)]
    data["lever_arm"] = ("axis3", np.array(arm, dtype=float), {"units": "m"})
    data.attrs = {
        "recording": recording.name,
        "description": f"{recording.name}, {begun.words}",
        "filter_fmu": parts["filter"].name,
        "evaluation.start": float(fed.time[0]) + evaluate_after,
        "evaluation.stop": float(fed.time[-1]),
        "settings": json.dumps(
            {
                part: {name: fmu.variables[name].display(value) for name, value in values[part].items()}
                for part, fmu in parts.items()
            }
        ),
        "versions": json.dumps(
            {
                "truenorth": product_version() or "not installed (checkout)",
                **{fmu.name: fmu.guid for fmu in parts.values()},
            }
        ),
        "messages": json.dumps([f"{recording.name}: {remark}" for remark in remarks] + said),
        **({} if recording.epoch is None else {"epoch": recording.epoch}),
    }
    return data


def believed(recording: Recording, values: Values) -> Recording:
    """Recording whose fixes are no surer than `measurement.*` of the (navigation) filter is told."""
    if recording.gnss is None:
        return recording
    least = {kind: values["filter"].get(name) for kind, name in LEAST_SIGMAS.items()}
    return changed(recording, gnss=fixes.no_surer_than(recording.gnss, **least))


def parts_of(task: Filter, fmus: Fmus) -> dict[str, Fmu]:
    """The FMUs by their part: `filter`, and perhaps the `alignment` before it."""
    if task is Filter.alignment:
        return {"filter": fmus[ALIGNMENT_FILTER]}
    navigation = {"filter": fmus[NAVIGATION_FILTER]}
    return navigation if task is Filter.navigation else {"alignment": fmus[ALIGNMENT_FILTER], **navigation}


def values_of(
    parts: Mapping[str, Fmu], recording: Recording, begun: Beginning, settings: Mapping[str, object]
) -> tuple[Values, str]:
    """Parameters of the filters: what the recording tells, then the user's settings; and a remark or none.

    Raises
    ------
    InputError
        When a setting is of none of them, or the recording lacks what a model needs.
    """
    told: Values = {part: {} for part in parts}
    for name, value in settings.items():
        owners, parameter = _owners(name, parts)
        for owner in owners:
            told[owner] |= parts[owner].assignments(parameter, value)
    arms = {
        f"{sensor}.lever_arm[{i}]": x
        for sensor, arm in vars(recording.lever_arms).items()
        for i, x in enumerate(arm, start=1)
        if x
    }
    first, fmu = next(iter(parts.items()))
    known = begun.values
    told_heading = begun.knows_heading and len(parts) == 1
    if fmu.name == ALIGNMENT_FILTER and not told_heading and "error_model" not in told[first]:
        for name, item in ANY_HEADING.items():
            known = {**known, **fmu.assignments(name, item)}
    values = {part: {**arms, **(known if part == first else {}), **told[part]} for part in parts}
    if any(f"initial.{name}" not in values[first] for name in ("latitude", "longitude", "height")):
        raise InputError(
            f"{recording.name}: no fix has a position; record GNSS, tell the position, or use zero-velocity "
            "fixes at a position"
        )
    _check_models(parts, values, begun)
    if not _begins_coarsely(fmu, values[first]) or "coarse.enabled" in told[first]:
        return values, ""
    if recording.gnss is not None and fixes.is_whole(recording.gnss).any():
        return values, ""
    values[first] |= fmu.assignments("coarse.enabled", False)
    return values, NO_COARSE_STAGE


def _begins_coarsely(fmu: Fmu, values: Mapping[str, Number]) -> bool:
    """Whether a filter has a coarse stage, which takes whole fixes alone."""
    if fmu.name != ALIGNMENT_FILTER:
        return False
    model = values.get("error_model", fmu.start("error_model"))
    return model == fmu.variables["error_model"].items["invariant"]


def _owners(name: str, parts: Mapping[str, Fmu]) -> tuple[list[str], str]:
    """The parts that a setting is for, and its name there."""
    owners = [part for part, fmu in parts.items() if fmu.has_parameter(name)]
    if owners:
        return owners, name
    prefix, _, rest = name.partition(".")
    if prefix in parts:
        return [prefix], rest
    raise no_such_parameter(name, parts)


def _check_models(parts: Mapping[str, Fmu], values: Values, begun: Beginning) -> None:
    """Refuse a model that needs what the recording does not have."""
    part, fmu = next(iter(parts.items()))
    models = fmu.variables["error_model"].items
    chosen = {name: values[name].get("error_model", parts[name].start("error_model")) for name in parts}
    if not begun.knows_heading and chosen[part] != models["invariant"]:
        name = next(name for name, item in models.items() if item == chosen[part])
        raise InputError(
            f"the model {name} of {fmu.name} needs a heading to start from: tell it, start on the course, "
            "choose error_model=invariant, or align first (align_then_navigate)"
        )
    navigation = parts["filter"].variables["error_model"].items
    if "tight" in navigation and chosen["filter"] == navigation["tight"]:
        raise InputError("error_model = tight: needs channels of a receiver, and a recording has fixes alone")


def _run(
    parts: Mapping[str, Fmu],
    values: Values,
    fed: Feed,
    truth: ReferenceTable | None,
    smooth: bool,
    fmus: Fmus,
    progress: Progress,
) -> tuple[xr.Dataset, list[str]]:
    """Data set of the filter, and what the FMUs said."""
    fmu, start, stop = parts["filter"], float(fed.time[0]), float(fed.time[-1])
    with ExitStack() as stack:

        def initialised(part: str, source: Source) -> Sink:
            instance = stack.enter_context(closing(Instance(parts[part], part, values[part])))
            return Sink.initialised(instance, source, start, stop)

        source: RecordedSource | AlignmentSource
        source = RecordedSource(
            [fmu.variables[name] for name in fmu.inputs() if name in fed.columns], fed.columns
        )
        if "alignment" in parts:
            alignment = initialised("alignment", source)
            source = AlignmentSource(source, alignment, fmu, Order.gauss_seidel)
        sink = initialised("filter", source)
        recorded = simulate(
            source,
            [sink],
            fed.time,
            record_every=max(1, round(RECORDING_PERIOD / float(np.median(np.diff(fed.time))))),
            fix_outputs=results.fix_outputs(fmu),
            alignment_outputs=results.ALIGNMENT_OUTPUTS if "alignment" in parts else (),
            correction_outputs=smoothing.outputs(fmu) if smooth else (),
            progress=progress,
        )
        instances = (source.alignment, sink.instance)
        said = [str(message) for instance in instances if instance for message in instance.messages]
    data = _dataset(recorded, parts, truth, fmus)
    if smooth:
        data, remarks = smoothing.smoothed(data, recorded.corrections[0], fmu, values["filter"])
        said += remarks
    return data, said


def _dataset(
    recorded: Recorded, parts: Mapping[str, Fmu], truth: ReferenceTable | None, fmus: Fmus
) -> xr.Dataset:
    """Data set of what was recorded, with the errors against what a reference tells."""
    plant = None
    if truth is not None:
        recorded, plant = changed(recorded, truth=references.at(truth, recorded.time)), fmus.plant
    data = results.dataset(recorded, {"filter": parts["filter"]}, plant, parts.get("alignment"))
    errors = [*results.ERRORS, f"{results.ALIGNMENT}heading_error"]
    untold = [name for name in errors if name in data and not np.isfinite(data[name].values).any()]
    return results.of_filter(data.drop_vars(untold), "filter")


def _with_receiver(data: xr.Dataset, gnss: FixTable | None, fed: Feed, windows: Array) -> xr.Dataset:
    """Data set with all fixes of the recorded time, and the outages."""
    if gnss is None:
        return data
    known = fixes.selected(gnss, (gnss.time > fed.time[0]) & (gnss.time <= fed.time[-1]))
    data = data.assign_coords(
        receiver_time=("receiver", known.time, {"units": "s", "description": "Time of validity of the fix"})
    )
    data["receiver.position"] = (
        ("receiver", "axis3"),
        np.array(known.position),
        {"units": "rad rad m", "description": "Antenna: latitude, longitude, height"},
    )
    data["receiver.velocity"] = (
        ("receiver", "axis3"),
        fixes.velocities(known),
        {"units": "m/s", "description": "Antenna: east, north, up; of the positions where not measured"},
    )
    data["receiver.withheld"] = (
        "receiver",
        within(known.time, windows),
        {"description": "Whether the filter did not get the fix"},
    )
    if len(windows):
        for name, edge in zip(("outage_begin", "outage_end"), windows.T, strict=True):
            data = data.assign_coords({name: ("outage", edge, {"units": "s"})})
    return data
