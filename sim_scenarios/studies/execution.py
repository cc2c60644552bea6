"""A campaign on several processes: batches of runs as tasks, a few at a time; workers store the results.

The workers are a pool of processes of this machine, which have pipes and listen nowhere, or those of a Dask
cluster. Whatever the size of a campaign, only a few batches for each worker are handed out, and of a batch
that is done comes back nothing but how many runs it had.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Final, TypeVar

import xarray as xr

from sim_scenarios import provenance
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import Fmus
from sim_scenarios.processes import processes
from sim_scenarios.stepping import Master
from sim_scenarios.studies import runs, store
from sim_scenarios.studies.case import Case, filter_labels
from sim_scenarios.studies.plan import Plan
from sim_scenarios.studies.quantities import figures
from sim_scenarios.studies.runs import Bench
from sim_scenarios.studies.store import Batch
from sim_scenarios.version import PACKAGE, sources

Task = TypeVar("Task")
Result = TypeVar("Result")

AHEAD: Final = 2
"""Tasks for each worker that are handed out: one in work, one waiting."""

MOST_DEATHS: Final = 3
"""How often in a row workers may die before a single task is done."""


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
    damaged : tuple of str
        Chunks of the data set that could not be read, whose runs have been done again.
    """

    runs: int
    workers: int
    wall: float
    work: float
    failures: tuple[str, ...] = ()
    damaged: tuple[str, ...] = ()

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


class Workers:
    """Processes that do tasks.

    Parameters
    ----------
    start : callable
        Gives an executor that hands tasks to them; called again when they have died.
    count : int
        How many tasks are done at once.
    given_up : type of Exception, optional
        What the executor raises of a task on which workers died again and again.
    """

    def __init__(
        self, start: Callable[[], Executor], count: int, given_up: type[Exception] | tuple[()] = ()
    ) -> None:
        self._start, self._executor = start, start()
        self.count, self._given_up = count, given_up

    def results(self, do: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[tuple[Task, Result]]:
        """Tasks and their results, as they are done. A task on which a worker died is given out again."""
        waiting, pending = deque(tasks), dict[Future[Result], Task]()
        done: SimpleQueue[Future[Result]] = SimpleQueue()  # to wait for all takes as long as there are
        deaths = 0
        while waiting or pending:
            try:
                while waiting and len(pending) < AHEAD * self.count:
                    future = self._executor.submit(do, waiting[0])
                    pending[future] = waiting.popleft()
                    future.add_done_callback(done.put)
                future = done.get()
                if future in pending:  # no more of workers that have died
                    result = future.result()
                    deaths = 0
                    yield pending.pop(future), result
            except BrokenExecutor:  # noqa: PERF203
                deaths += 1
                if deaths == MOST_DEATHS:
                    raise SimulationError(f"{deaths} times workers died on the same tasks") from None
                waiting.extendleft(pending.values())
                pending.clear()
                self._executor = self._start()
            except self._given_up as error:
                raise SimulationError(f"workers died again and again on the same tasks: {error}") from None
            except CancelledError:
                raise SimulationError("the scheduler has dropped tasks, or is lost") from None


@dataclass(frozen=True)
class Workbench:
    """What a worker needs for the batches of a campaign.

    Attributes
    ----------
    path : Path
        The data set; the workers must see it under the same path.
    plan, cases, master
        Of the campaign.
    versions : dict of str to str
        FMUs that the workers must have.
    figures : list of str
        Variables of those that the workers must know.
    attributes : list of dict
        Of the runs of each case.
    """

    path: Path
    plan: Plan
    cases: Sequence[Case]
    master: Master
    versions: dict[str, str]
    figures: list[str]
    attributes: list[dict[str, Any]]

    def set_up(self) -> tuple[Bench, store.Writer]:
        """Load the FMUs, which must be those of the campaign, and open the data set."""
        bench = Bench(self.plan.period, self.master, asked=self.plan.asked)
        found = versions(bench.fmus, self.plan, self.cases)
        if found != self.versions:
            raise other_fmus(found, self.versions)
        if differing := set(self.figures).symmetric_difference(figures(self.plan.asked)):
            raise InputError(f"a worker has other figures than this process: {', '.join(sorted(differing))}")
        return bench, store.Writer(self.path)


@contextmanager
def workers(count: int | None, scheduler: str | None, insecure: bool = False) -> Iterator[Workers]:
    """Workers of a scheduler that exists, or a process for each core of this machine."""
    from dask.system import CPU_COUNT  # slow, and workers have no use for it

    with ExitStack() as stack:
        if scheduler is None:
            count = count or CPU_COUNT
            yield Workers(lambda: stack.enter_context(processes(count)), count)
        else:
            from sim_scenarios.studies import cluster  # slow: distributed

            client = stack.enter_context(cluster.connected(scheduler, insecure))
            start = partial(client.get_executor, pure=False)
            yield Workers(start, sum(client.nthreads().values()), cluster.WORKERS_DIED)


def bounds(workers: Workers, made: Sequence[Case], fmus: Fmus) -> list[xr.Dataset]:
    """Cramer-Rao bound of every case, with the attributes of its runs; it knows nothing of faults."""
    own = [index for index, case in enumerate(made) if case.unfaulted is None]
    computed = workers.results(partial(_bound, made), own)
    found = {made[index].label: bound for index, bound in computed}

    def of(case: Case) -> xr.Dataset:
        if case.unfaulted is None:
            return found[case.label]
        bound = found[case.unfaulted]
        result: xr.Dataset = bound.assign_attrs({**bound.attrs, **provenance.attributes(case.scenario, fmus)})
        return result

    return [of(case) for case in made]


def execute(
    workers: Workers,
    path: Path,
    plan: Plan,
    made: Sequence[Case],
    master: Master,
    versions: dict[str, str],
    report: Report = lambda _: None,
) -> Effort:
    """Run all that is missing in a data set; `report` is called after every batch."""
    path = path.resolve()
    bench = Workbench(path, plan, made, master, versions, [*figures(plan.asked)], store.run_attributes(path))
    missing = list(store.unfinished(path))
    total = plan.runs * len(made)
    done = total - sum(len(batch) for batch in missing)
    failures: list[str] = []
    finished, work, start = 0, 0.0, time.monotonic()
    report(Progress(done, 0, total, 0.0))
    for _, outcome in workers.results(partial(_run_batch, pickle.dumps(bench)), missing):
        finished, work = finished + outcome.runs, work + outcome.work
        failures += outcome.failures
        report(Progress(done + finished, len(failures), total, finished / (time.monotonic() - start)))
    wall = time.monotonic() - start
    return Effort(finished, workers.count, wall, work, tuple(dict.fromkeys(failures)))


def other_fmus(found: Mapping[str, str], wanted: Mapping[str, str]) -> InputError:
    """Why a worker is of no use."""
    return InputError(f"a worker has other FMUs than this process: {found}, not {wanted}")


def versions(fmus: Fmus, plan: Plan, made: Sequence[Case]) -> dict[str, str]:
    """Hash of every FMU that the cases use, by name or path; of this package, if something is expected."""
    used = dict.fromkeys(name for case in made for name in case.scenario.fmu_names())
    return {**{name: fmus[name].version for name in used}, **({PACKAGE: sources()} if plan.expect else {})}


def _bound(made: Sequence[Case], index: int) -> xr.Dataset:
    return runs.bound(made[index], Fmus())


class _OnWorker(threading.local):
    """What a thread of a worker keeps from one batch to the next of the same campaign."""

    pickled: bytes = b""
    bench: Workbench
    ready: tuple[Bench, store.Writer]

    def of(self, pickled: bytes) -> tuple[Workbench, Bench, store.Writer]:
        """A workbench, set up."""
        if pickled != self.pickled:
            self.bench = pickle.loads(pickled)
            self.ready = self.bench.set_up()
            self.pickled = pickled
        return (self.bench, *self.ready)


_on_worker: Final = _OnWorker()


def _run_batch(pickled: bytes, batch: Batch) -> Done:
    """Run a batch on a worker and store it."""
    workbench, bench, writer = _on_worker.of(pickled)
    start = time.monotonic()
    case, attributes = workbench.cases[batch.case], workbench.attributes[batch.case]
    seeds = range(workbench.plan.seed + batch.start, workbench.plan.seed + batch.stop)
    outcomes = [bench.run(case, seed, attributes) for seed in seeds]
    values, state = runs.arranged(outcomes, filter_labels(workbench.cases), writer.shapes)
    writer.write(batch, values.__getitem__, state)
    failures = tuple(outcome.failure for outcome in outcomes if outcome.failure)
    return Done(len(batch), failures, time.monotonic() - start)
