"""`--overwrite`: results of another campaign give way when this one can begin, and its own never do."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.folders import reserved
from sim_scenarios.studies import execution, store
from sim_scenarios.studies.campaign import Campaign
from sim_scenarios.studies.cases import fingerprint
from sim_scenarios.studies.plan import Plan, load_plan
from sim_scenarios.studies.store import State

WINDOW = {"evaluation.start": 1.0, "evaluation.stop": 3.0, "filter_fmu": "NavigationFilter"}


def plan(seed: int) -> Plan:
    return load_plan("waves", runs=2, seed=seed, set={"duration": 4.0, "evaluation.start": 1.0})


@pytest.fixture
def finished(fmus: Fmus, tmp_path: Path) -> Campaign:
    """A campaign all of whose runs are stored."""
    campaign = Campaign.of(plan(1), tmp_path, fmus=fmus)
    identity = fingerprint(campaign.plan, campaign.cases, campaign.versions)
    bounds = [xr.Dataset(attrs=WINDOW)] * len(campaign.cases)
    store.create(tmp_path, campaign.plan, campaign.cases, identity, bounds, fmus.plant)
    for batch in store.unfinished(campaign.path):
        writer = store.Writer(campaign.path)
        shape = store.open_results(tmp_path).sizes["filter"], len(batch)
        values = {name: np.ones((*shape, *rest)) for name, rest in writer.shapes.items()}
        writer.write(batch, values.__getitem__, np.full(shape, State.finished, np.int8))
    return campaign


def content(campaign: Campaign) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in campaign.path.rglob("*") if path.is_file()}


@contextmanager
def no_workers(*_: object) -> Iterator[None]:
    raise InputError("there are no workers")
    yield


@contextmanager
def some_workers(*_: object) -> Iterator[None]:
    yield


def stopped(*_: object) -> None:
    raise KeyboardInterrupt


def test_own_results_are_gone_on_with(finished: Campaign) -> None:
    before = content(finished)
    assert finished.run(overwrite=True).runs == 0
    assert content(finished) == before


@pytest.mark.parametrize(("workers", "error"), [(no_workers, InputError), (some_workers, KeyboardInterrupt)])
def test_results_of_another_stay_until_this_one_can_begin(
    finished: Campaign, fmus: Fmus, monkeypatch: pytest.MonkeyPatch, workers: object, error: type[Exception]
) -> None:
    """Without workers, and stopped while the bounds are computed."""
    monkeypatch.setattr(execution, "workers", workers)
    monkeypatch.setattr(execution, "bounds", stopped)
    before = content(finished)
    with pytest.raises(error):
        Campaign.of(plan(7), finished.folder, fmus=fmus).run(overwrite=True)
    assert content(finished) == before


@pytest.mark.parametrize("damage", ["another campaign", "no data set", "a lost bound"])
def test_what_cannot_be_gone_on_with_gives_way(
    finished: Campaign, fmus: Fmus, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    monkeypatch.setattr(execution, "workers", some_workers)
    monkeypatch.setattr(execution, "bounds", lambda *_: [xr.Dataset(attrs=WINDOW)])
    monkeypatch.setattr(execution, "execute", lambda *_: execution.Effort(2, 1, 1.0, 1.0))
    another = Campaign.of(plan(7 if damage == "another campaign" else 1), finished.folder, fmus=fmus)
    if damage == "no data set":
        (finished.path / ".zattrs").unlink()
    if damage == "a lost bound":
        next((finished.path / "heading_bound").glob("[0-9]*")).unlink()
    with pytest.raises(InputError, match="--overwrite"):
        another.run()
    assert another.run(overwrite=True).runs == 2
    assert store.counts(another.path)[State.finished] == 0


def test_a_campaign_that_is_at_work_is_left_alone(finished: Campaign) -> None:
    """Neither cleared, nor swept of what its workers are writing."""
    writing = finished.path / "state" / "0.0.0.partial"
    writing.touch()
    before = content(finished)
    for overwrite in (False, True):
        with (
            reserved(finished.folder, "campaign"),
            pytest.raises(InputError, match="another campaign is at work in it"),
        ):
            finished.run(overwrite=overwrite)
    assert content(finished) == before
    finished.run()
    assert not writing.exists()


def test_the_hint_after_an_interruption_overwrites_nothing(
    finished: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["campaign", "waves", "--overwrite", "-o", str(finished.folder)]
    monkeypatch.setattr(sys, "argv", ["truenorth", *words])
    monkeypatch.setattr(Campaign, "run", lambda *_, **__: stopped())
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 130
    assert f"truenorth campaign waves -o {finished.folder}" in result.stderr
