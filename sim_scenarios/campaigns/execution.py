"""A campaign on Dask distributed: batches of runs as tasks, a few at a time, whose results the workers store.

Whatever the size of a campaign, the scheduler knows only a few batches for each worker, and of a batch that
is done nothing but how many runs it had: its memory does not grow with the number of runs.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Final
from uuid import uuid4

import xarray as xr
from dask.system import CPU_COUNT
from distributed import Client, LocalCluster, Worker, WorkerPlugin, as_completed, get_worker
from distributed.scheduler import KilledWorker

from sim_scenarios import simulation
from sim_scenarios.campaigns import runs, store
from sim_scenarios.campaigns.plan import Case, Plan, filter_labels
from sim_scenarios.campaigns.runs import Bench
from sim_scenarios.campaigns.store import Batch
from sim_scenarios.cosimulation import Master
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmus

AHEAD: Final = 2
"""Batches for each worker that the scheduler knows: one in work, one waiting."""

CONNECTING: Final = 10.0
"""How long a scheduler may take to answer, and a worker to come [s]."""


@dataclass(frozen=True)
class Progress:
    """How far a campaign has come.

    Attributes
    ----------
    done, failed, total : int
        Runs; one run has all the filters of its case, and has failed when one of them has. Failures are
        those of this call.
    rate : float
        Runs in a second, of those that this call has made.
    """

    done: int
    failed: int
    total: int
    rate: float

    @property
    def left(self) -> float:
        """Estimated time to the end [s]."""
        return (self.total - self.done) / self.rate if self.rate > 0 else float("inf")


Report = Callable[[Progress], None]


@dataclass(frozen=True)
class Effort:
    """What the runs cost.

    Attributes
    ----------
    runs, workers : int
    wall : float
        From the first batch to the last [s].
    work : float
        Time that the workers spent in runs, all together [s].
    failures : tuple of str
        Why runs failed, each reason once.
    """

    runs: int
    workers: int
    wall: float
    work: float
    failures: tuple[str, ...] = ()

    @property
    def overhead(self) -> float:
        """Share of the workers' time that was not spent in runs: scheduling, waiting for the last one."""
        return 1 - self.work / (self.wall * self.workers) if self.runs else 0.0


@dataclass(frozen=True)
class Done:
    """What a worker says of a batch."""

    runs: int
    failures: tuple[str, ...]
    work: float


class Workbench(WorkerPlugin):
    """What a worker needs for the batches of a campaign; made once on every worker, also on a late one."""

    def __init__(
        self, path: Path, plan: Plan, made: Sequence[Case], master: Master, versions: dict[str, str]
    ) -> None:
        self.name = f"campaign-{uuid4().hex}"
        self.path, self.plan, self.cases, self.master, self.versions = path, plan, made, master, versions
        self.attributes = store.run_attributes(path)

    def setup(self, worker: Worker) -> None:  # noqa: ARG002
        """Load the FMUs, which must be those of the campaign, and open the data set."""
        self.writer = store.Writer(self.path)
        self.bench = Bench(self.plan.period, self.master)
        found = fmu_versions(self.bench.fmus, self.cases)
        if found != self.versions:
            raise InputError(f"a worker has other FMUs than this process: {found}, not {self.versions}")


@contextmanager
def cluster(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """Connection to a scheduler: one that exists, or an embedded one with a worker process for each core."""
    with ExitStack() as stack:
        if scheduler is None:
            local = LocalCluster(
                n_workers=workers or CPU_COUNT,
                threads_per_worker=1,
                processes=True,
                dashboard_address="127.0.0.1:0",
                memory_limit=0,
                silence_logs="CRITICAL",
                preload=[__name__],
            )
            yield stack.enter_context(Client(stack.enter_context(local)))
            return
        try:
            client = stack.enter_context(Client(scheduler, timeout=CONNECTING))
            client.wait_for_workers(1, timeout=CONNECTING)
        except TimeoutError:
            raise InputError(f"--scheduler {scheduler}: it has no workers") from None
        except (OSError, ValueError) as error:
            raise InputError(f"--scheduler {scheduler}: there is no answer ({error})") from None
        yield client


def dask_setup(_: Worker) -> None:
    """Leave Ctrl-C to the command: a terminal interrupts the worker processes of its group as well.

    Dask calls this function, by its name, in every worker of the embedded cluster.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def bounds(client: Client, made: Sequence[Case], fmus: Fmus) -> list[xr.Dataset]:
    """Cramer-Rao bound of every case, with the attributes of its runs; it knows nothing of faults."""
    own = {case.label: case for case in made if case.unfaulted is None}
    computed = client.gather(client.map(_bound, list(own.values()), pure=False))
    found: dict[str, xr.Dataset] = dict(zip(own, computed, strict=True))

    def of(case: Case) -> xr.Dataset:
        if case.unfaulted is None:
            return found[case.label]
        bound = found[case.unfaulted]
        result: xr.Dataset = bound.assign_attrs({**bound.attrs, **simulation.attributes(case.scenario, fmus)})
        return result

    return [of(case) for case in made]


def execute(
    client: Client,
    path: Path,
    plan: Plan,
    made: Sequence[Case],
    master: Master,
    versions: dict[str, str],
    report: Report = lambda _: None,
) -> Effort:
    """Run all that is missing in a data set; the workers must see it under the same path.

    They must have the FMUs of the given versions. `report` is called after every batch.
    """
    bench = Workbench(path.resolve(), plan, made, master, versions)
    client.register_plugin(bench)
    try:
        return _execute(client, bench, report)
    finally:
        client.unregister_worker_plugin(bench.name)


def _execute(client: Client, bench: Workbench, report: Report) -> Effort:
    missing = list(store.unfinished(bench.path))
    total = bench.plan.runs * len(bench.cases)
    done = total - sum(len(batch) for batch in missing)
    failures: list[str] = []
    made, work, start = 0, 0.0, time.monotonic()
    batches = iter(missing)
    workers = sum(client.nthreads().values())

    def submit(batch: Batch) -> Any:
        return client.submit(_run_batch, bench.name, batch, key=f"{bench.name}-{batch}")

    report(Progress(done, 0, total, 0.0))
    pending = as_completed([submit(batch) for batch in islice(batches, AHEAD * workers)])
    for future in pending:
        try:
            outcome: Done = future.result()
        except KilledWorker as error:
            raise SimulationError(f"workers died again and again on the same runs: {error}") from None
        future.release()
        for batch in islice(batches, 1):
            pending.add(submit(batch))
        made, work = made + outcome.runs, work + outcome.work
        failures += outcome.failures
        report(Progress(done + made, len(failures), total, made / (time.monotonic() - start)))
    return Effort(made, workers, time.monotonic() - start, work, tuple(dict.fromkeys(failures)))


def fmu_versions(fmus: Fmus, made: Sequence[Case]) -> dict[str, str]:
    """Hash of every FMU that the cases use, by name."""
    used = dict.fromkeys(name for case in made for name in case.scenario.fmu_names())
    return {fmus[name].name: fmus[name].guid for name in used}


def _bound(case: Case) -> xr.Dataset:
    return runs.bound(case, Fmus())


def _run_batch(bench: str, batch: Batch) -> Done:
    """Run a batch on a worker and store it."""
    start = time.monotonic()
    plugin = get_worker().plugins[bench]
    assert isinstance(plugin, Workbench)
    case, attributes = plugin.cases[batch.case], plugin.attributes[batch.case]
    seeds = range(plugin.plan.seed + batch.start, plugin.plan.seed + batch.stop)
    outcomes = [plugin.bench.run(case, seed, attributes) for seed in seeds]
    writer = plugin.writer
    writer.write(batch, *runs.arranged(outcomes, filter_labels(plugin.cases), writer.times))
    failures = tuple(outcome.failure for outcome in outcomes if outcome.failure)
    return Done(len(batch), failures, time.monotonic() - start)
