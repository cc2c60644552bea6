"""What a run leaves behind: one labelled data set with units, and a file of it.

An xarray Dataset with the FMUs' own variable names, in the FMUs' units (SI and radians).

    dimension `filter`   the filters that saw the same signals, by label
    dimension `time`     periodic rows: truth, navigation, estimates and their sigmas, errors
    dimension `fix`      one row for each fix: innovation, NIS, weights; coordinate `fix_time`
    dimensions `axis3`, ...       components of vectors; `row12`, `column12` of matrices

Of an alignment that is handed over, `alignment.*` (time) are outputs and heading error, and `hand_over_time`
(filter) is when the filters begin to navigate; what they put out before is no estimate, and its error NaN.

A variable that not all filters have has the labels of those that do in its attribute `filters` (JSON); the
others have NaN there, or false. Errors of what no filter puts out are NaN.

Files are netCDF 3 (CF attributes), which scipy writes and everything reads.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import ScipyDataStore

from sim_scenarios import attitude
from sim_scenarios.cosimulation import Recorded
from sim_scenarios.earth import displacement
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu

FIX_OUTPUTS: Final = (
    "innovation",
    "innovation_sigma",
    "nis",
    "measurement_weight",
    "measurement_sigma_estimate",
    "adaptive.alpha",
    "robust.gamma_effective",
    "robust.feasible",
    "used_fixes",
    "rejected_fixes",
)
"""Outputs of a filter that change with a fix alone."""

ALIGNMENT_OUTPUTS: Final = ("nav.heading", "heading_sigma", "converged", "status")
"""Outputs that are recorded of an alignment that is handed over."""
ALIGNMENT: Final = "alignment."
"""Beginning of their names in a data set."""
HAND_OVER: Final = "hand_over_time"
ERRORS: Final = ("attitude_error", "heading_error", "position_error", "velocity_error")

Entry = tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]
"""A variable of a data set: dimensions, values, attributes."""


def fix_outputs(fmu: Fmu) -> list[str]:
    """Scalar outputs of a filter that belong to fixes."""
    return [scalar for name in FIX_OUTPUTS for scalar in fmu.arrays.get(name, [])]


def dataset(
    recorded: Recorded,
    filters: Mapping[str, Fmu],
    plant: Fmu | None = None,
    alignment: Fmu | None = None,
) -> xr.Dataset:
    """Data set of a simulation.

    Parameters
    ----------
    recorded : Recorded
        What the simulation left.
    filters : mapping of str to Fmu
        That of each filter, by label. FMUs declare units and descriptions.
    plant, alignment : Fmu, optional
        Of the truth, and of an alignment that is handed over.

    Returns
    -------
    xarray.Dataset
        With the errors of what the filter puts out (filter, time) where the truth is known, and `fix_used`
        (filter, fix), of filters that count the fixes that they use.
    """
    parts = [
        _with_fix_used({**_arrays(table, fmu, "time"), **_arrays(fixes, fmu, "fix")})
        for table, fixes, fmu in zip(recorded.filters, recorded.fixes, filters.values(), strict=True)
    ]
    variables = _side_by_side(dict(zip(filters, parts, strict=True)))
    if recorded.truth is not None and plant is not None:
        variables |= _arrays(recorded.truth, plant, "time")
    if recorded.alignment is not None and alignment is not None:
        outputs = _arrays(recorded.alignment, alignment, "time")
        variables |= {f"{ALIGNMENT}{name}": values for name, values in outputs.items()}
    result = xr.Dataset(
        variables,
        coords={
            "filter": list(filters),
            "time": ("time", recorded.time, {"units": "s", "description": "Time since the start"}),
            "fix_time": (
                "fix",
                recorded.fix_time,
                {"units": "s", "description": "Time of validity of the fix"},
            ),
        },
    )
    if recorded.truth is not None and plant is not None:
        result = result.assign(errors(result))
    return _handed_over(result) if recorded.alignment is not None and alignment is not None else result


def _with_fix_used(part: dict[str, Entry]) -> dict[str, Entry]:
    """Outputs of a filter, and which fixes it used."""
    if "used_fixes" not in part:
        return part
    _, count, _ = part["used_fixes"]
    used = np.diff(count, prepend=count.dtype.type(0)) > 0
    return {**part, "fix_used": (("fix",), used, {"description": "Whether the fix corrected the estimate"})}


def _side_by_side(parts: Mapping[str, dict[str, Entry]]) -> dict[str, Entry]:
    """Outputs of several filters, by label, in one data set."""
    names = dict.fromkeys(name for part in parts.values() for name in part)
    return {name: _stacked(name, parts) for name in names}


def _stacked(name: str, parts: Mapping[str, dict[str, Entry]]) -> Entry:
    """An output of several filters, some of which may lack it, or elements of it: NaN there, or false."""
    having = {label: part[name] for label, part in parts.items() if name in part}
    dimensions, widest, attributes = max(having.values(), key=lambda entry: entry[1].size)
    if any(values.ndim != widest.ndim for _, values, _ in having.values()):
        raise InputError(f"{name}: {', '.join(having)} have it as numbers and as arrays")

    def filled(values: NDArray[Any] | None) -> NDArray[Any]:
        if values is not None and values.shape == widest.shape:
            return values
        result = np.full(widest.shape, False if widest.dtype == bool else np.nan)
        if values is not None:
            result[tuple(map(slice, values.shape))] = values
        return result

    stacked = np.stack([filled(part[name][1] if name in part else None) for part in parts.values()])
    if len(having) < len(parts):
        attributes = {**attributes, "filters": json.dumps(list(having))}
    return ("filter", *dimensions), stacked, attributes


def under_way(data: xr.Dataset) -> xr.Dataset:
    """A run without what precedes the hand-over of an alignment, when no filter has an estimate."""
    if HAND_OVER not in data:
        return data
    rows: xr.Dataset = data.isel(time=data["time"].values >= data[HAND_OVER].min().values)
    return rows


def _handed_over(data: xr.Dataset) -> xr.Dataset:
    """Data set with the time of the hand-over, without errors of what was put out before, nor its fixes."""
    has_estimate = data["heading_sigma"] > 0  # a filter that waits for a start has no covariance
    time = data["time"].where(has_estimate).min("time")
    time.attrs = {"units": "s", "description": "First recorded time at which the filter navigates"}
    data = data.assign({HAND_OVER: time})
    if "truth.heading" in data:
        heading = attitude.wrap(data[f"{ALIGNMENT}nav.heading"].values - data["truth.heading"].values)
        description = "Heading of the alignment minus true heading"
        data = data.assign(
            {
                f"{ALIGNMENT}heading_error": ("time", heading, {"units": "rad", "description": description}),
                **{name: data[name].where(has_estimate) for name in ERRORS},
            }
        )
    seen = ((data["used_fixes"] > 0) | (data["rejected_fixes"] > 0)).any("filter")
    rows: xr.Dataset = data.isel(fix=seen.values)
    return rows


def errors(data: xr.Dataset) -> dict[str, Entry]:
    """Errors against the truth, of one filter or of several, by their names `ERRORS`."""
    return {**_attitude_errors(data), **_position_and_velocity_errors(data)}


def _dimensions(data: xr.Dataset) -> tuple[str, ...]:
    """Of a scalar of one filter, or of several."""
    return ("filter", "time") if "filter" in data.dims else ("time",)


def _attitude_errors(data: xr.Dataset) -> dict[str, Entry]:
    """Errors of attitude and heading against the truth."""
    dimensions = _dimensions(data)
    estimated, true = (
        attitude.dcm(*(_of_frame(data, frame, angle) for angle in ("roll", "pitch", "heading")))
        for frame in ("nav", "truth")
    )
    phi = attitude.misalignment_angles(estimated @ np.swapaxes(true, -1, -2))
    heading = attitude.wrap(_of_frame(data, "nav", "heading") - data["truth.heading"].values)
    return {
        "attitude_error": (
            (*dimensions, "axis3"),
            phi,
            {"units": "rad", "description": "Misalignment of the estimated attitude (phi_e, phi_n, phi_u)"},
        ),
        "heading_error": (
            dimensions,
            heading,
            {"units": "rad", "description": "Estimated minus true heading"},
        ),
    }


def _position_and_velocity_errors(data: xr.Dataset) -> dict[str, Entry]:
    """Errors of position and velocity against the truth, estimated minus true (east, north, up)."""
    estimated, true = (
        np.stack([_of_frame(data, frame, name) for name in ("latitude", "longitude", "height")], axis=-1)
        for frame in ("nav", "truth")
    )
    velocity = _of_frame(data, "nav", "velocity") - data["truth.velocity"].values
    dimensions, meaning = (*_dimensions(data), "axis3"), "Estimated minus true"
    return {
        "position_error": (
            dimensions,
            displacement(estimated, true),
            {"units": "m", "description": f"{meaning} position (east, north, up)"},
        ),
        "velocity_error": (
            dimensions,
            velocity,
            {"units": "m/s", "description": f"{meaning} velocity (east, north, up)"},
        ),
    }


def _of_frame(data: xr.Dataset, frame: str, name: str) -> NDArray[np.float64]:
    """Estimate of the filters or truth; NaN of what no filter puts out."""
    truth: NDArray[np.float64] = data[f"truth.{name}"].values
    if f"{frame}.{name}" in data:
        values: NDArray[np.float64] = data[f"{frame}.{name}"].values
        return values
    return np.full((*(data.sizes[name] for name in _dimensions(data)[:-1]), *truth.shape), np.nan)


def of_filter(data: xr.Dataset, label: str) -> xr.Dataset:
    """What one of several filters did, without the dimension `filter` and what this one does not put out."""
    one: xr.Dataset = data.sel(filter=label, drop=True)
    others = [
        name
        for name, values in one.items()
        if "filters" in values.attrs and label not in json.loads(values.attrs["filters"])
    ]
    own: xr.Dataset = one.drop_vars(others)
    return own


def save(data: xr.Dataset, path: Path) -> None:
    """Write a data set to a netCDF file."""
    store = ScipyDataStore(str(path), mode="w", lock=False)  # `to_netcdf` looks for dask's scheduler: slow
    try:
        data.dump_to_store(store)
    finally:
        store.close()


def load(path: Path) -> xr.Dataset:
    """Data set of a file, wholly in memory."""
    data: xr.Dataset = xr.load_dataset(path, engine="scipy")
    return data


def _arrays(columns: Mapping[str, NDArray[Any]], fmu: Fmu, dimension: str) -> dict[str, Entry]:
    """Arrays of an FMU's variables from their scalars."""
    arrays: dict[str, list[str]] = {}
    for scalar in columns:
        arrays.setdefault(scalar.partition("[")[0], []).append(scalar)
    return {name: _array(columns, fmu, dimension, scalars) for name, scalars in arrays.items()}


def _array(columns: Mapping[str, NDArray[Any]], fmu: Fmu, dimension: str, scalars: list[str]) -> Entry:
    variable = fmu.variables[scalars[0]]
    attributes: dict[str, Any] = {"description": variable.description}
    if variable.kind == "Real":
        units = [fmu.variables[scalar].unit.name for scalar in scalars]
        attributes["units"] = units[0] if len(set(units)) == 1 else " ".join(units)  # one for each element
    if variable.kind == "Enumeration":
        attributes["flag_values"] = np.array(list(variable.items.values()), dtype=np.int32)
        attributes["flag_meanings"] = " ".join(variable.items)
    values = np.stack([columns[s] for s in scalars], axis=-1)
    shape = [int(size) for size in scalars[-1].partition("[")[2].rstrip("]").split(",") if size]
    axes = ("axis",) if len(shape) == 1 else ("row", "column")
    dimensions = (dimension, *(f"{axis}{size}" for axis, size in zip(axes, shape, strict=False)))
    values = values.reshape(len(values), *shape)
    if variable.kind == "Boolean":
        values = values.astype(bool)
    return dimensions, values, attributes
