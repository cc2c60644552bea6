"""Results of a campaign on disk: an xarray Dataset in Zarr, written region by region.

    dimension `scenario`   cases of the campaign: scenario and point of the grid
    dimension `filter`     filters by label; one that a case does not compare stays empty
    dimension `run`        coordinate `seed`
    dimension `time`       every `period` seconds
    dimension `instant`    recorded instants of the errors `recorded.*`, where something expected needs them

What is drawn for a run stands in `drawn.<parameter>` (scenario, run), the end of its faults in `fault_end`.

One chunk holds the runs of one batch, so that workers never write to the same file, and Zarr replaces a file
as a whole. `state` is written last: a run counts as finished when its state says so, and everything else
of it is on disk by then. Whoever dies at any moment leaves finished batches and batches to repeat.

Every chunk begins with a checksum of itself, and every chunk of a finished batch is there, even one that
holds nothing; `seal` holds a checksum of those checksums. A chunk that is lost, damaged or put in another
one's place later is therefore found, and the runs of its batch are done again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, Final, Literal
from zlib import crc32

import numpy as np
import xarray as xr
import zarr
from numcodecs import CRC32, Zstd
from numpy.typing import NDArray

from sim_scenarios import connection, faults, recording
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu
from sim_scenarios.folders import discard, filled, remove
from sim_scenarios.metrics.statistics import rms
from sim_scenarios.scenario import Scenario
from sim_scenarios.studies.case import Case, filter_labels
from sim_scenarios.studies.plan import Plan
from sim_scenarios.studies.quantities import BOUNDED, ERRORS, RECORDED, SERIES, figures
from sim_scenarios.timeline import RESOLUTION, instants, within

NAME: Final = "campaign.zarr"
BEFORE: Final = f"{NAME}.before"
"""The data set while another one takes its place (see `packing`)."""
DRAWN: Final = "drawn."
"""Beginning of the names of what is drawn for the runs."""
RUNS: Final = ("scenario", "filter", "run")
ZARR_3: Final = zarr.__version__[0] >= "3"
_CODEC: Final = "compressors" if ZARR_3 else "compressor"
"""What xarray calls the codec that is applied last."""
_CHECKSUM: Final = 4
"""Bytes of a chunk's checksum, the first of it."""
_LAST: Final = ("seal", "state")
"""What is written of a batch when everything else is there."""


def of_runs(variables: Mapping[Any, Any]) -> list[str]:
    """Those of the variables of a data set, or of its arrays, that the runs fill, in the order of writing."""
    names = [str(name) for name, one in variables.items() if one.ndim >= len(RUNS) and name not in _LAST]
    return [*names, *_LAST]


class State(IntEnum):
    """What became of a run."""

    missing = 0
    finished = 1
    failed = 2  # an FMU refused to go on
    absent = 3  # the case does not compare the filter


@dataclass(frozen=True)
class Batch:
    """Runs start .. stop - 1 of a case, stored together."""

    case: int
    start: int
    stop: int

    def __len__(self) -> int:
        """Runs."""
        return self.stop - self.start

    @property
    def region(self) -> tuple[int, slice, slice]:
        """Its place in an array: case, filters, runs."""
        return self.case, slice(None), slice(self.start, self.stop)


def is_there(folder: Path, identity: str) -> bool:
    """Whether a folder holds the data set of a campaign; refuses a folder with that of another one."""
    path = folder / NAME
    if not path.exists():
        return False
    try:
        attributes = _group(path, "r").attrs.asdict()
    except Exception:  # whatever Zarr raises
        attributes = {}
    if "fingerprint" not in attributes:
        raise InputError(f"{path} is not the data set of a campaign; give another --output, or --overwrite")
    if attributes["fingerprint"] != identity:
        raise InputError(
            f"{folder} holds the results of a campaign with other settings, figures or FMUs "
            f"({attributes['runs']} runs from seed {attributes['seed']}); give another --output, "
            "or --overwrite"
        )
    return True


def create(
    folder: Path, plan: Plan, made: Sequence[Case], identity: str, bounds: Sequence[xr.Dataset], plant: Fmu
) -> None:
    """Data set of a campaign without results; it appears in the folder as a whole or not at all."""
    template = _template(plan, made, identity, bounds, plant)
    encoding: dict[Any, dict[str, Any]] = {name: {_CODEC: CRC32()} for name in template.variables}
    for name in of_runs(template.variables):
        encoding[name]["filters"] = [Zstd()]  # is read after the checksum, and written before it
    with filled(folder) as draft:
        template.to_zarr(
            draft / NAME,
            mode="w",
            compute=False,
            zarr_format=2,
            write_empty_chunks=True,
            encoding=encoding,
        )


def clear(folder: Path) -> None:
    """Remove the data set of a folder."""
    discard(folder / NAME)


def discard_damaged(path: Path) -> list[str]:
    """Chunks that are lost or damaged, by their paths; the runs of their batches are missing from now on.

    A chunk that no run fills cannot be made again, and the data set is refused.
    """
    arrays = stored(path)
    for name in arrays.keys() - set(of_runs(arrays)):
        for index in np.ndindex(arrays[name].cdata_shape):
            if not _is_whole(path, arrays[name], name, index):
                where = path / _chunk(name, index)
                raise InputError(f"{where} is lost or damaged; give another --output, or --overwrite")
    batches = np.ndindex(arrays["state"].cdata_shape)
    return [chunk for batch in batches for chunk in _damaged(path, arrays, batch)]


def _damaged(path: Path, arrays: Mapping[str, Any], index: tuple[int, ...]) -> list[str]:
    """Chunks of a batch that were stored and cannot be read; with the batch's state they are removed."""
    state = path / _chunk("state", index)
    if not state.exists():
        return []
    if not _is_whole(path, arrays["state"], "state", index):
        damaged = [_chunk("state", index)]
    elif (arrays["state"].get_block_selection(index) == State.missing).any():
        return []
    else:
        at = {name: _place(arrays[name], index) for name in of_runs(arrays)}
        damaged = [_chunk(n, where) for n, where in at.items() if not _is_whole(path, arrays[n], n, where)]
        if not damaged and not _is_sealed(path, arrays, index):
            damaged = [_chunk("seal", index)]
    if damaged:
        remove(state)  # first: from now on the runs are missing
    for chunk in damaged:
        remove(path / chunk)
    return damaged


def _is_whole(path: Path, array: Any, name: str, index: tuple[int, ...]) -> bool:
    """Whether a chunk is there and fits its checksum; Zarr takes one that is not there for an empty one."""
    try:
        array.get_block_selection(index)
    except Exception:  # whatever file system, checksum and compression raise
        return False
    return (path / _chunk(name, index)).is_file()


def _is_sealed(path: Path, arrays: Mapping[str, Any], index: tuple[int, ...]) -> bool:
    """Whether the chunks of a batch, each of them whole, are those that were written for it."""
    state = arrays["state"].get_block_selection(index)
    return bool((arrays["seal"].get_block_selection(index) == _seal(path, arrays, index, state)).all())


def _seal(path: Path, arrays: Mapping[str, Any], index: tuple[int, ...], state: NDArray[np.int8]) -> int:
    """Checksum of the checksums of a batch's chunks, of its state, and of where it stands."""
    content = [repr(index).encode(), state.tobytes()]
    for name in sorted(of_runs(arrays)):
        if name not in _LAST:
            with (path / _chunk(name, _place(arrays[name], index))).open("rb") as chunk:
                content.append(chunk.read(_CHECKSUM))
    return crc32(b"".join(content))


def _place(array: Any, index: tuple[int, ...]) -> tuple[int, ...]:
    """Place of an array's chunk of a batch."""
    return (*index, *[0] * (array.ndim - len(index)))


def _chunk(name: str, index: tuple[int, ...]) -> str:
    return f"{name}/{'.'.join(map(str, index))}"


def sweep(path: Path) -> None:
    """Remove the chunks that killed workers had begun to write. Only when nobody writes any more."""
    for partial in path.rglob("*.partial"):
        partial.unlink(missing_ok=True)


def run_attributes(path: Path) -> list[dict[str, Any]]:
    """Attributes of the runs of each case: evaluation window, limits, bound."""
    about = json.loads(_group(path, "r").attrs["cases"])
    return [case["attributes"] for case in about.values()]


def unfinished(path: Path) -> Iterator[Batch]:
    """Batches with a run that is missing."""
    state = _group(path, "r")["state"]
    size = state.chunks[2]
    for case in range(state.shape[0]):
        missing = (state[case] == State.missing).any(axis=0)
        for start in range(0, len(missing), size):
            stop = min(start + size, len(missing))
            if missing[start:stop].any():
                yield Batch(case, start, stop)


class Writer:
    """Stores batches in a data set."""

    def __init__(self, path: Path) -> None:
        group = _group(path, "r+")
        arrays = dict(group.arrays())
        self._path = path
        self._arrays = {name: _writing_all(arrays[name]) for name in of_runs(arrays)}
        self.shapes = {n: array.shape[len(RUNS) :] for n, array in self._arrays.items() if n not in _LAST}

    def write(self, batch: Batch, values: Callable[[str], NDArray[Any]], state: NDArray[np.int8]) -> None:
        """Store a batch, its seal and its state last.

        The shapes are (filters, runs) for states, and (filters, runs, ...) as `shapes` has it for values,
        which are asked for by name, one after the other.
        """
        region = batch.region
        for name in self.shapes:
            self._arrays[name][region] = values(name)
        index = batch.case, 0, batch.start // self._arrays["state"].chunks[2]
        self._arrays["seal"][region] = _seal(self._path, self._arrays, index, state)
        self._arrays["state"][region] = state


def _writing_all(array: Any) -> Any:
    """An array that writes chunks with nothing in them, too, as Zarr 2 does anyway."""
    return array.with_config({"write_empty_chunks": True}) if ZARR_3 else array


def open_results(folder: str | Path) -> xr.Dataset:
    """Results of a campaign, read from its folder as they are needed.

    To be opened anew when the campaign has gone on: its chunks may then be others.
    """
    path = Path(folder) / NAME
    if not path.exists() and (before := path.with_name(BEFORE)).exists():
        path = before  # who was at work has been killed
    if not path.exists():
        raise InputError(f"there are no results of a campaign in {folder}")
    data: xr.Dataset = xr.open_zarr(path, chunks="auto")  # of Dask, larger than the batches on disk
    return data


def stored(path: Path) -> dict[str, Any]:
    """Arrays of a data set, by name."""
    return dict(_group(path, "r").arrays())


def counts(path: Path) -> dict[State, int]:
    """How many runs of filters are in each state."""
    state = _group(path, "r")["state"][:]
    return {s: int((state == s).sum()) for s in State}


def _group(path: Path, mode: Literal["r", "r+"]) -> Any:
    return zarr.open_group(str(path), mode=mode)


def _template(
    plan: Plan, made: Sequence[Case], identity: str, bounds: Sequence[xr.Dataset], plant: Fmu
) -> xr.Dataset:
    """The whole data set, with nothing in its runs yet."""
    import dask.array  # slow, and workers have no use for it

    filters = filter_labels(made)
    steps = max(int(case.scenario.duration / plan.period + 1e-9) for case in made)
    time = plan.period * np.arange(steps + 1, dtype=np.float64)
    recorded = _recorded(made if plan.asked.errors else [])
    shape = {"scenario": len(made), "filter": len(filters), "run": plan.runs, "time": len(time)}
    shape |= {"instant": recorded.shape[1], "axis3": 3}
    chunks = {**shape, "scenario": 1, "run": plan.batch}

    def empty(dimensions: Sequence[str], dtype: str, fill: float) -> Any:
        return dask.array.full(
            [shape[d] for d in dimensions], fill, dtype=dtype, chunks=[chunks[d] for d in dimensions]
        )

    series = {
        name: ((*RUNS, "time"), empty((*RUNS, "time"), "f8", np.nan), _attributes(*about))
        for name, about in SERIES.items()
    }
    single = {
        name: (RUNS, empty(RUNS, "f8", np.nan), _attributes(one.figure.unit, one.description))
        for name, one in figures(plan.asked).items()
    }
    errors = {
        f"{RECORDED}{name}": (dims, empty(dims, "f8", np.nan), {"description": f"{name} at every instant"})
        for name in (recording.ERRORS if plan.asked.errors else ())
        for dims in [(*RUNS, "instant", *(() if name == "heading_error" else ("axis3",)))]
    }
    state = {
        "description": "What became of the run",
        "flag_values": np.array(list(State), dtype=np.int8),
        "flag_meanings": " ".join(s.name for s in State),
    }
    data: xr.Dataset = xr.Dataset({**series, **single, **errors})
    data["state"] = RUNS, empty(RUNS, "i1", 0), state
    data["seal"] = RUNS, empty(RUNS, "u4", 0), {"description": "Checksum of what is stored of the batch"}
    if errors:
        about = _attributes("s", "Recorded instants; NaN beyond the end of the runs")
        data[f"{RECORDED}time"] = (("scenario", "instant"), recorded, about)
    data = data.assign_coords(
        scenario=(
            "scenario",
            [case.label for case in made],
            {"description": "Scenario and point of the grid"},
        ),
        filter=("filter", filters, {"description": "Filter"}),
        seed=("run", plan.seed + np.arange(plan.runs), {"description": "Seed of the run"}),
        time=("time", time, {"units": "s", "description": "Time since the start"}),
    )
    data = data.assign({**_bounds(bounds, time), **_drawn(plan, made, plant)})
    data.attrs = _about(plan, made, identity, bounds)
    return data


def _recorded(made: Sequence[Case]) -> NDArray[np.float64]:
    """Recorded instants of each case [s], filled up with NaN, shape (cases, instants)."""
    times = [
        instants(one.duration, one.communication_step, connection.stride(one))
        for one in (case.scenario for case in made)
    ]
    recorded = np.full((len(made), max(map(len, times), default=0)), np.nan)
    for row, time in zip(recorded, times, strict=True):
        row[: len(time)] = time
    return recorded


def _attributes(unit: str, description: str) -> dict[str, str]:
    return {"units": unit, "description": description}


def _drawn(plan: Plan, made: Sequence[Case], plant: Fmu) -> dict[str, Any]:
    """What is drawn for each run, and when its faults end; NaN where nothing is drawn, and no fault ends."""
    shape = len(made), plan.runs
    values: dict[str, NDArray[np.float64]] = {}
    units: dict[str, str] = {}
    ends = np.empty(shape)
    for c, case in enumerate(made):
        ends[c] = _fault_end(case.scenario, plant)
        for one in case.draws:
            units |= {one.label(scalar): unit for scalar, unit in one.units.items()}
        for r in range(plan.runs if case.draws else 0):
            seed = plan.seed + r
            ends[c, r] = _fault_end(case.with_seed(seed), plant)
            for name, value in case.drawn(seed).items():
                values.setdefault(name, np.full(shape, np.nan))[c, r] = value
    drawn = {
        f"{DRAWN}{name}": (("scenario", "run"), drawn, _attributes(units[name], f"{name} of the run"))
        for name, drawn in values.items()
    }
    about = _attributes("s", "When the last fault of the plant ends, where there is one that does")
    return {**drawn, "fault_end": (("scenario", "run"), ends, about)}


def _fault_end(scenario: Scenario, plant: Fmu) -> float:
    end = faults.end(scenario.plant, plant)
    return np.nan if end is None or np.isinf(end) else end


def _bounds(bounds: Sequence[xr.Dataset], time: NDArray[np.float64]) -> dict[str, Any]:
    """Bound of each case at the times of the campaign, and its RMS over the window; NaN without one."""
    variables: dict[str, Any] = {}
    for name in BOUNDED:
        courses = [_bound(bound, name) for bound in bounds]
        series = np.full((len(bounds), len(time)), np.nan)
        over_window = np.full(len(bounds), np.nan)
        for i, (bound, sigma) in enumerate(zip(bounds, courses, strict=True)):
            if sigma is None:
                continue
            at = bound["bound_time"].values
            start, stop = (bound.attrs[f"evaluation.{edge}"] for edge in ("start", "stop"))
            known = time <= at[-1] + RESOLUTION
            series[i, known] = sigma[np.searchsorted(at, time[known] + RESOLUTION, side="right") - 1]
            over_window[i] = rms(within(at, sigma, start, stop))
        unit, what = ERRORS[name].unit, f"Posterior Cramer-Rao bound of the {ERRORS[name].title.lower()}"
        if name == "heading":
            what += ", or where its prior is wide that of errors of any size"
        variables[f"{name}_bound"] = (("scenario", "time"), series, _attributes(unit, what))
        about = _attributes(unit, f"{what}: RMS over the window")
        variables[f"{name}_bound_rms"] = ("scenario", over_window, about)
    return variables


def _bound(data: xr.Dataset, name: str) -> NDArray[np.float64] | None:
    """Sigma of an error after each fix, None if the bound does not have it."""
    sources = {
        "heading": ("bound.heading_sigma_any", "bound.heading_sigma"),
        "horizontal": ("bound.position_sigma",),
    }
    source = next((source for source in sources[name] if source in data), None)
    if source is None:
        return None
    sigma: NDArray[np.float64] = data[source].values
    return sigma if sigma.ndim == 1 else np.hypot(sigma[:, 0], sigma[:, 1])


def _about(plan: Plan, made: Sequence[Case], identity: str, bounds: Sequence[xr.Dataset]) -> dict[str, Any]:
    cases = {
        case.label: {
            "scenario": case.source,
            "settings": case.settings,
            "drawn": case.drawn(plan.seed),
            "unfaulted": case.unfaulted,
            "attributes": {key: value for key, value in bound.attrs.items() if key != "messages"},
        }
        for case, bound in zip(made, bounds, strict=True)
    }
    return {
        "campaign": plan.name,
        "description": plan.description or made[0].scenario.description,
        "runs": plan.runs,
        "seed": plan.seed,
        "plan": plan.model_dump_json(),
        "cases": json.dumps(cases),
        "fingerprint": identity,
    }
