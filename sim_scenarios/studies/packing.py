"""The data set of a campaign that is done in few files, however many runs it has.

While workers write, a chunk is a batch, small enough that one that is lost is soon done again. When all runs
are there, and a case has more than `MANY` batches, they are put together into `CHUNKS`. The packed data set
is written beside the other one and takes its place; a process that is killed between leaves the one or the
other, which `store.open_results` finds, and `recover` puts in its place.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, Final

from numpy.typing import NDArray

from sim_scenarios.folders import DRAFT, Owned, discard
from sim_scenarios.studies import store
from sim_scenarios.studies.store import Batch, Writer

CHUNKS: Final = 10
"""Files of a variable for each case that is packed."""
MANY: Final = 100
"""Files of a variable for each case that are left as they are: to put them together takes its time, too."""
_RUN: Final = store.RUNS.index("run")


def pack(folder: Path) -> list[str]:
    """Put the chunks of a campaign's data set together, if all its runs are there and it has many.

    Only when nobody else writes. Where there is no room for it, the data set stays as it is.

    Returns
    -------
    list of str
        Chunks that are lost or damaged, whose runs are missing from now on; nothing is put together then.
    """
    path = folder / store.NAME
    arrays = store.stored(path)
    state = arrays["state"]
    size = -(-state.shape[_RUN] // CHUNKS)
    if state.cdata_shape[_RUN] <= MANY or any(store.unfinished(path)):
        return []
    if damaged := store.discard_damaged(path):
        return damaged
    with suppress(OSError):
        _pack(folder, arrays, size)
    return []


def _pack(folder: Path, arrays: Mapping[str, Any], size: int) -> None:
    """Put chunks together, so many runs in each."""
    path, state = folder / store.NAME, arrays["state"]
    cases, _, runs = state.shape
    draft = Owned(folder, DRAFT)
    try:
        packed = draft.path / store.NAME
        _copy_without_runs(path, packed, store.of_runs(arrays), size)
        writer = Writer(packed)
        for case in range(cases):
            for start in range(0, runs, size):
                batch = Batch(case, start, min(start + size, runs))
                writer.write(batch, partial(_stored, arrays, batch), state[batch.region])
        path.replace(folder / store.BEFORE)
        packed.replace(path)
    finally:
        recover(folder)
        draft.remove()


def recover(folder: Path) -> None:
    """Put back what a packed data set was about to take the place of, or remove it."""
    path, before = folder / store.NAME, folder / store.BEFORE
    if path.exists():
        discard(before)
    else:
        with suppress(FileNotFoundError):  # there is none
            before.replace(path)


def _stored(arrays: Mapping[str, Any], batch: Batch, name: str) -> NDArray[Any]:
    """What an array has of the runs of a batch."""
    values: NDArray[Any] = arrays[name][batch.region]
    return values


def _copy_without_runs(path: Path, packed: Path, of_runs: list[str], size: int) -> None:
    """Copy a data set without the chunks that runs fill, which have another size from now on."""

    def left_out(place: str, names: list[str]) -> list[str]:
        if Path(place).name not in of_runs:
            return []
        return [name for name in names if not name.startswith(".z")]  # which describe

    shutil.copytree(path, packed, ignore=left_out)
    for name in of_runs:
        _edit(packed / name / ".zarray", lambda about: _resized(about, size))
    if (packed / ".zmetadata").exists():
        _edit(
            packed / ".zmetadata",
            lambda about: {
                **about,
                "metadata": {
                    key: _resized(one, size) if key.removesuffix("/.zarray") in of_runs else one
                    for key, one in about["metadata"].items()
                },
            },
        )


def _resized(array: Mapping[str, Any], size: int) -> dict[str, Any]:
    """Description of an array with so many runs in a chunk."""
    chunks = list(array["chunks"])
    chunks[_RUN] = size
    return {**array, "chunks": chunks}


def _edit(path: Path, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Change what a JSON file says."""
    path.write_text(json.dumps(change(json.loads(path.read_text(encoding="utf-8")))), encoding="utf-8")
