"""Campaigns whose processes die: nothing is lost, nothing is doubled, nothing changes."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.stepping import Master
from sim_scenarios.studies import cluster, execution, store
from sim_scenarios.studies.campaign import campaign
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.execution import Progress
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.runs import bound
from sim_scenarios.studies.store import State

SETTINGS = {"duration": 30.0, "evaluation.start": 10.0}
RUNS = 16
COMMAND = [
    *(sys.executable, "-m", "sim_scenarios.cli", "campaign", "zigzag", "-n", str(RUNS), "--workers", "2"),
    *("--filter", "UKF", "--set", "duration=30.0", "--set", "evaluation.start=10.0"),
]


def files(folder: Path) -> dict[str, bytes]:
    root = folder / store.NAME
    return {str(p.relative_to(root)): p.read_bytes() for p in sorted(root.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def undisturbed(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("undisturbed")
    run(folder, fmus, workers=2)
    return files(folder)


def run(folder: Path, fmus: Fmus, **how: Any) -> None:
    """What COMMAND does."""
    campaign("zigzag", folder, runs=RUNS, filters=("UKF",), set=SETTINGS, fmus=fmus, **how)


@contextmanager
def process(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    """A process with a group of its own, that does not outlive the test."""
    with subprocess.Popen(command, text=True, stderr=subprocess.PIPE, start_new_session=True) as running:
        try:
            yield running
        finally:
            if running.poll() is None:
                os.killpg(running.pid, signal.SIGKILL)


def wait_for(condition: Callable[[], bool], seconds: float = 300.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.02)


def finished(folder: Path) -> int:
    path = folder / store.NAME
    return store.counts(path)[State.finished] if path.exists() else 0


@pytest.mark.parametrize("attempt", [0, *(pytest.param(i, marks=pytest.mark.slow) for i in range(1, 10))])
def test_a_killed_campaign_resumes(
    fmus: Fmus, tmp_path: Path, undisturbed: dict[str, bytes], attempt: int
) -> None:
    """SIGKILL at a random number of stored runs and a random moment after; the same command goes on."""
    dice = random.Random(attempt)
    with process([*COMMAND, "--output", str(tmp_path)]) as running:
        stored = dice.randrange(1, RUNS // 2)
        wait_for(lambda: finished(tmp_path) >= stored)
        time.sleep(dice.uniform(0, 0.1))
        running.kill()
        running.wait()
    done = finished(tmp_path)
    assert stored <= done < RUNS
    kept = {file: file.stat().st_mtime_ns for file in (tmp_path / store.NAME / "state").glob("[0-9]*")}
    said: list[Progress] = []
    run(tmp_path, fmus, workers=2, report=said.append)
    assert said[0].done == done
    assert files(tmp_path) == undisturbed
    assert {file: file.stat().st_mtime_ns for file in kept} == kept  # computed once


def test_an_interruption_says_how_to_resume(tmp_path: Path) -> None:
    with process([*COMMAND, "--set", "duration=200.0", "--output", str(tmp_path)]) as running:
        wait_for(lambda: finished(tmp_path) >= 2)
        os.killpg(running.pid, signal.SIGINT)  # as a terminal does
        _, said = running.communicate(timeout=300)
    assert running.returncode == 130
    assert "the same command resumes" in said
    assert "campaign zigzag -n 16" in said
    assert "Traceback" not in said
    assert 2 <= finished(tmp_path) < RUNS


def test_a_cluster_that_exists_and_a_worker_that_dies(
    fmus: Fmus, tmp_path: Path, undisturbed: dict[str, bytes]
) -> None:
    """A scheduler and two workers started by hand; one is killed when the first runs are stored."""
    address_file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    file = ["--scheduler-file", str(address_file)]
    worker = [*dask, "worker", *file, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
    with ExitStack() as stack:
        stack.enter_context(
            process(
                [*dask, "scheduler", "--scheduler-file", str(address_file), "--port", "0", "--no-dashboard"]
            )
        )
        wait_for(address_file.exists)
        first, _ = (stack.enter_context(process(worker)) for _ in range(2))
        killed: list[int] = []

        def report(progress: Progress) -> None:
            if progress.done >= 4 and not killed:
                first.kill()
                killed.append(progress.done)

        address = json.loads(address_file.read_text(encoding="utf-8"))["address"]
        run(tmp_path / "results", fmus, scheduler=address, insecure=True, report=report)
    assert killed
    assert files(tmp_path / "results") == undisturbed


def test_a_worker_with_other_fmus_is_refused(fmus: Fmus, tmp_path: Path) -> None:
    plan = load_plan("zigzag", runs=1, set=SETTINGS)
    made = cases(plan, fmus)
    store.create(tmp_path, plan, made, "any", [bound(case, fmus) for case in made], fmus.plant)
    others = {"TruthPlant": "another", "AlignmentFilter": fmus.filter.guid}
    with execution.workers(1, None) as workers, pytest.raises(InputError, match="a worker has other FMUs"):
        execution.execute(workers, tmp_path / store.NAME, plan, made, Master.auto, others)


def test_a_scheduler_without_workers(fmus: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECTING", 0.5)
    with (
        LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address="127.0.0.1:0") as empty,
        pytest.raises(InputError, match="it has no workers"),
    ):
        run(tmp_path, fmus, scheduler=empty.scheduler_address)


def test_a_scheduler_that_does_not_answer(
    fmus: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "CONNECTING", 0.5)
    with pytest.raises(InputError, match="there is no answer"):
        run(tmp_path, fmus, scheduler="tcp://127.0.0.1:9")
