"""The data set of a campaign that is done: the same numbers in few files, also when it is interrupted."""

from __future__ import annotations

import errno
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.fmus import Fmus
from sim_scenarios.studies import packing, store
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.store import Batch, State

RUNS = 9
WINDOW = {"evaluation.start": 1.0, "evaluation.stop": 3.0, "filter_fmu": "NavigationFilter"}


@pytest.fixture(autouse=True)
def few_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packing, "MANY", 4)
    monkeypatch.setattr(packing, "CHUNKS", 4)


def write(folder: Path, batches: list[Batch]) -> None:
    """Store numbers that tell where they belong."""
    writer = store.Writer(folder / store.NAME)
    filters = store.open_results(folder).sizes["filter"]
    for batch in batches:
        state = np.full((filters, len(batch)), State.finished, np.int8)
        draw = np.random.default_rng([batch.case, batch.start]).standard_normal
        values = {name: draw((*state.shape, *shape)) for name, shape in writer.shapes.items()}
        writer.write(batch, values.__getitem__, state)


@pytest.fixture(scope="module")
def original(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All runs of two cases, in a chunk each."""
    folder = tmp_path_factory.mktemp("stored")
    settings = {"duration": 4.0, "evaluation.start": 1.0}
    plan = load_plan("waves", runs=RUNS, filters=("EKF",), set=settings, grid={"gnss.rate": [1, 2]})
    bounds = [xr.Dataset(attrs=WINDOW)] * 2
    store.create(folder, plan, cases(plan, fmus), "any", bounds, fmus.plant)
    write(folder, list(store.unfinished(folder / store.NAME)))
    return folder


@pytest.fixture
def folder(original: Path, tmp_path: Path) -> Path:
    shutil.copytree(original / store.NAME, tmp_path / store.NAME)
    return tmp_path


def content(folder: Path) -> xr.Dataset:
    return store.open_results(folder).drop_vars("seal").load()


def test_few_files_hold_the_same_numbers(folder: Path) -> None:
    before, path = content(folder), folder / store.NAME
    packing.pack(folder)
    xr.testing.assert_identical(content(folder), before)
    for name in store.of_runs(store.stored(path)):
        chunks = [file for file in (path / name).iterdir() if file.name[0].isdigit()]
        assert len(chunks) == 2 * 3, name  # of three runs each
    assert store.is_there(folder, "any")
    assert store.discard_damaged(path) == []
    assert [entry.name for entry in folder.iterdir()] == [store.NAME]


def test_what_is_packed_stays_as_it_is(folder: Path) -> None:
    packing.pack(folder)
    files = {file: file.stat().st_mtime_ns for file in folder.rglob("*")}
    packing.pack(folder)
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("*")} == files


def test_a_damaged_chunk_of_a_packed_data_set_is_done_again(folder: Path) -> None:
    packing.pack(folder)
    path = folder / store.NAME
    (path / "heading_rmse" / "1.0.2").unlink()
    assert store.discard_damaged(path) == ["heading_rmse/1.0.2"]
    missing = list(store.unfinished(path))
    assert missing == [Batch(1, 6, 9)]
    write(folder, missing)
    assert list(store.unfinished(path)) == []
    assert store.discard_damaged(path) == []


def test_a_small_data_set_stays_as_it_is(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(packing, "MANY", RUNS)
    packing.pack(folder)
    assert store.stored(folder / store.NAME)["state"].chunks[2] == 1


@pytest.mark.parametrize("harm", ["lost", "of another run", "damaged"])
def test_what_is_lost_or_damaged_is_not_put_together(folder: Path, harm: str) -> None:
    path = folder / store.NAME
    chunk, other = (path / "heading_rmse" / f"0.0.{k}" for k in (2, 5))
    if harm == "lost":
        chunk.unlink()
    else:
        content = bytearray((chunk if harm == "damaged" else other).read_bytes())
        content[-1] ^= harm == "damaged"
        chunk.write_bytes(content)
    named = "seal/0.0.2" if harm == "of another run" else "heading_rmse/0.0.2"
    assert packing.pack(folder) == [named]
    missing = list(store.unfinished(path))
    assert missing == [Batch(0, 2, 3)]
    write(folder, missing)
    assert packing.pack(folder) == []
    assert store.stored(path)["state"].chunks[2] == 3


def test_without_room_the_data_set_stays_as_it_is(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "no room")

    before = content(folder)
    with monkeypatch.context() as patch:
        patch.setattr(store.Writer, "write", full)
        assert packing.pack(folder) == []
    xr.testing.assert_identical(content(folder), before)
    assert [entry.name for entry in folder.iterdir()] == [store.NAME]
    assert packing.pack(folder) == []
    assert store.stored(folder / store.NAME)["state"].chunks[2] == 3


def test_runs_that_are_missing_are_waited_for(folder: Path) -> None:
    path = folder / store.NAME
    (path / "state" / "1.0.4").unlink()
    packing.pack(folder)
    assert store.stored(path)["state"].chunks[2] == 1


@pytest.mark.parametrize("killed", ["before", "between", "after"])
def test_a_data_set_is_there_whenever_packing_is_killed(
    folder: Path, killed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = content(folder)
    replace, recover = Path.replace, packing.recover
    last = {"before": folder / store.BEFORE, "between": folder / store.NAME}

    def dying(source: Path, target: Path) -> Path:
        if target == last.get(killed):
            raise SystemExit
        return replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(packing, "recover", lambda _: None)  # which one who is killed cannot do
        patch.setattr(packing, "discard", lambda _: None)
        if killed != "after":
            patch.setattr(Path, "replace", dying)
            with pytest.raises(SystemExit):
                packing.pack(folder)
        else:
            packing.pack(folder)
    assert (folder / store.BEFORE).exists() == (killed != "before")
    xr.testing.assert_identical(content(folder), before)
    recover(folder)
    assert not (folder / store.BEFORE).exists()
    xr.testing.assert_identical(content(folder), before)
    assert (store.stored(folder / store.NAME)["state"].chunks[2] > 1) == (killed == "after")
