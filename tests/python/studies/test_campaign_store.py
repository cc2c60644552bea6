"""The data set before the first run: bounds in their places, and nothing half made."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.studies import store
from sim_scenarios.studies.case import Case
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import Plan, load_plan
from sim_scenarios.studies.store import Batch, State

WINDOW = {"evaluation.start": 1.0, "evaluation.stop": 3.0, "filter_fmu": "NavigationFilter"}


@pytest.fixture
def plan() -> Plan:
    return load_plan("waves", runs=5, set={"duration": 4.0, "evaluation.start": 1.0})


@pytest.fixture
def made(plan: Plan, fmus: Fmus) -> list[Case]:
    return cases(plan, fmus)


def test_bounds_hold_from_fix_to_fix(tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus) -> None:
    bound = xr.Dataset(
        {
            "bound.heading_sigma": ("bound_time", [9.0, 5.0, 3.0]),
            "bound.position_sigma": (
                ("bound_time", "axis3"),
                [[3.0, 4.0, 9.0], [6.0, 8.0, 9.0], [0.0, 5.0, 9.0]],
            ),
        },
        coords={"bound_time": [0.0, 1.5, 3.0]},
        attrs=WINDOW,
    )
    store.create(tmp_path, plan, made, "any", [bound], fmus.plant)
    results = store.open_results(tmp_path).isel(scenario=0)
    np.testing.assert_array_equal(results["heading_bound"], [9, 9, 5, 3, np.nan])
    np.testing.assert_array_equal(results["horizontal_bound"], [5, 5, 10, 5, np.nan])
    assert float(results["heading_bound_rms"]) == pytest.approx(np.sqrt((25 + 9) / 2))
    assert float(results["horizontal_bound_rms"]) == pytest.approx(np.sqrt((100 + 25) / 2))


def test_of_a_wide_prior_the_bound_of_any_error_counts(
    tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus
) -> None:
    series = {"bound.heading_sigma": [9.0, 5.0, 3.0], "bound.heading_sigma_any": [8.0, 6.0, 4.0]}
    bound = xr.Dataset(
        {name: ("bound_time", values) for name, values in series.items()},
        coords={"bound_time": [0.0, 1.5, 3.0]},
        attrs=WINDOW,
    )
    store.create(tmp_path, plan, made, "any", [bound], fmus.plant)
    results = store.open_results(tmp_path).isel(scenario=0)
    np.testing.assert_array_equal(results["heading_bound"], [8, 8, 6, 4, np.nan])
    assert float(results["heading_bound_rms"]) == pytest.approx(np.sqrt((36 + 16) / 2))
    assert "errors of any size" in results["heading_bound"].attrs["description"]


def test_a_case_may_lack_a_bound(tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus) -> None:
    store.create(tmp_path, plan, made, "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    results = store.open_results(tmp_path)
    assert np.isnan(results["heading_bound"]).all()
    assert np.isnan(results["horizontal_bound_rms"]).all()


def test_nothing_half_made_is_left_or_taken(
    tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(draft: Path, target: Path) -> Path:
        if target == tmp_path / store.NAME:
            raise KeyboardInterrupt
        return replace(draft, target)

    replace = Path.replace
    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            store.create(tmp_path, plan, made, "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    assert not store.is_there(tmp_path, "any")
    store.create(tmp_path, plan, made, "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    assert store.is_there(tmp_path, "any")


def test_sweep_removes_what_a_killed_worker_had_begun(
    tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus
) -> None:
    store.create(tmp_path, plan, made, "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    path = tmp_path / store.NAME
    before = sorted(path.rglob("*"))
    (path / "heading_error" / "0.0.5.12436ce2.partial").touch()
    store.sweep(path)
    assert sorted(path.rglob("*")) == before


Damage = Callable[[Path], None]


def flip(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 0x10
    file.write_bytes(content)


DAMAGE: dict[str, Damage] = {
    "deleted": Path.unlink,
    "emptied": lambda file: file.write_bytes(b"") and None,
    "truncated": lambda file: os.truncate(file, file.stat().st_size - 1),
    "halved": lambda file: os.truncate(file, file.stat().st_size // 2),
    "a bit flipped": flip,
    "zeroed": lambda file: file.write_bytes(bytes(file.stat().st_size)) and None,
    "a folder": lambda file: file.unlink() or file.mkdir(),
}


EMPTY = (next(iter(store.SERIES)), next(iter(store.figures())))


@pytest.fixture(scope="module")
def original(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of which all runs but the last are finished; one series and one figure hold nothing."""
    folder = tmp_path_factory.mktemp("stored")
    plan = load_plan("waves", runs=5, set={"duration": 4.0, "evaluation.start": 1.0})
    store.create(folder, plan, cases(plan, fmus), "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    path = folder / store.NAME
    writer, filters = store.Writer(path), store.open_results(folder).sizes["filter"]
    for batch in list(store.unfinished(path))[:-1]:
        value = float(batch.start)
        values = {name: np.full((filters, 1, *shape), value) for name, shape in writer.shapes.items()}
        values |= {name: values[name] * np.nan for name in EMPTY}
        writer.write(batch, values.__getitem__, np.full((filters, 1), State.finished, np.int8))
    return path


@pytest.fixture
def stored(original: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(original, tmp_path / store.NAME))


def test_a_sound_data_set_is_left_alone(stored: Path) -> None:
    before = {file: file.read_bytes() for file in stored.rglob("*") if file.is_file()}
    assert store.discard_damaged(stored) == []
    assert {file: file.read_bytes() for file in stored.rglob("*") if file.is_file()} == before


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
@pytest.mark.parametrize("name", [EMPTY[0], list(store.figures())[1]])
def test_a_damaged_chunk_is_named_and_its_runs_are_done_again(
    stored: Path, name: str, damage: Damage
) -> None:
    chunk = next(file for file in (stored / name).iterdir() if file.name.startswith("0.0.2"))
    damage(chunk)
    missing = list(store.unfinished(stored))
    assert store.discard_damaged(stored) == [f"{name}/{chunk.name}"]
    assert list(store.unfinished(stored)) == [Batch(0, 2, 3), *missing]
    assert store.discard_damaged(stored) == []


@pytest.mark.parametrize("pattern", ["tilt_rmse/0.0.1*", "*/0.0.1*"], ids=["one", "all of its batch"])
def test_a_chunk_in_the_place_of_another_is_found(stored: Path, pattern: str) -> None:
    """It is whole, but what it holds is of other runs."""
    for chunk in stored.glob(pattern):
        shutil.copy(chunk, chunk.with_name(chunk.name.replace("0.0.1", "0.0.2", 1)))
    assert store.discard_damaged(stored) == ["seal/0.0.2"]
    assert Batch(0, 2, 3) in list(store.unfinished(stored))


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_runs_of_a_damaged_state_are_done_again(stored: Path, damage: Damage) -> None:
    damage(stored / "state" / "0.0.2")
    assert store.discard_damaged(stored) in ([], ["state/0.0.2"])
    assert Batch(0, 2, 3) in list(store.unfinished(stored))


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
@pytest.mark.parametrize("name", ["time", "filter", "heading_bound"])
def test_what_no_run_fills_cannot_be_mended(stored: Path, name: str, damage: Damage) -> None:
    damage(next(file for file in (stored / name).iterdir() if file.name[0].isdigit()))
    with pytest.raises(InputError, match=rf"{name}/0\S* is lost or damaged; give another"):
        store.discard_damaged(stored)


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
@pytest.mark.parametrize("name", [".zattrs", ".zgroup", ".zmetadata"])
def test_damaged_descriptions_are_refused_or_harmless(stored: Path, name: str, damage: Damage) -> None:
    damage(stored / name)
    try:
        assert store.is_there(stored.parent, "any")
    except InputError as error:
        assert "give another --output, or --overwrite" in str(error)  # noqa: PT017
    else:
        assert store.discard_damaged(stored) == []


def test_a_data_set_is_cleared_as_a_whole(stored: Path) -> None:
    store.clear(stored.parent)
    assert list(stored.parent.iterdir()) == []


def test_a_batch_is_missing_until_its_state_is_written(
    tmp_path: Path, plan: Plan, made: list[Case], fmus: Fmus
) -> None:
    store.create(tmp_path, plan, made, "any", [xr.Dataset(attrs=WINDOW)], fmus.plant)
    path = tmp_path / store.NAME
    missing = list(store.unfinished(path))
    assert missing == [Batch(0, run, run + 1) for run in range(5)]
    writer = store.Writer(path)
    filters = store.open_results(tmp_path).sizes["filter"]
    values = {name: np.ones((filters, 1, *shape)) for name, shape in writer.shapes.items()}
    writer.write(missing[3], values.__getitem__, np.full((filters, 1), State.finished, np.int8))
    assert list(store.unfinished(path)) == [*missing[:3], missing[4]]
    assert store.counts(path)[State.finished] == filters


def test_what_is_drawn_stands_beside_the_runs(tmp_path: Path, fmus: Fmus) -> None:
    fault = {"fault.imu.kind": "silence", "fault.imu.begin": 2.0}
    plan = load_plan(
        "waves",
        runs=5,
        seed=4,
        set={"duration": 4.0, "evaluation.start": 1.0, **fault},
        draw={"fault.imu.duration": {"uniform": [0.5, 1.0]}},
    )
    clean, faulted = cases(plan, fmus)
    store.create(tmp_path, plan, [clean, faulted], "any", [xr.Dataset(attrs=WINDOW)] * 2, fmus.plant)
    results = store.open_results(tmp_path)
    drawn = results["drawn.fault.imu.duration"]
    assert drawn.attrs["units"] == "s"
    assert np.isnan(drawn.values[0]).all()
    expected = [faulted.drawn(seed)["fault.imu.duration"] for seed in range(4, 9)]
    np.testing.assert_array_equal(drawn.values[1], expected)
    np.testing.assert_array_equal(results["fault_end"].values[1], 2 + drawn.values[1])
    assert np.isnan(results["fault_end"].values[0]).all()
