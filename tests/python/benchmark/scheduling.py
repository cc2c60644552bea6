"""A campaign's scheduling with workers that only pretend: how many of them one process can keep busy.

    python tests/python/benchmark/scheduling.py --workers 1000 --runs 160000

Batches go through `studies.execution.Workers`, as those of a campaign do, to an executor whose workers hold
each batch for as long as its runs would take and then say that it is done. Told is how long the whole took
beside what it takes when no worker ever waits, and the CPU time of the process for each batch. A batch takes
half to one and a half times what its runs take in the mean. What Dask does of its own, and the network, are
not in it.
"""

from __future__ import annotations

import argparse
import heapq
import random
import threading
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

from sim_scenarios.studies.execution import Done, Workers
from sim_scenarios.studies.plan import Plan
from sim_scenarios.studies.store import Batch


class Pretending(Executor):
    """Workers that take a batch each, in the order in which batches come, and hold it for a while."""

    def __init__(self, workers: int, duration: Callable[[Batch], float]) -> None:
        self._free = [time.monotonic()] * workers  # when each worker is
        self._duration = duration
        self._held: list[tuple[float, int, Future[Any], Batch]] = []
        self._changed = threading.Condition()
        self._count = 0
        threading.Thread(target=self._release, daemon=True).start()

    def submit(self, _: Callable[..., Any], /, *tasks: Any, **__: Any) -> Future[Any]:
        """Give a batch to the worker that is free first."""
        (batch,) = tasks
        future: Future[Any] = Future()
        with self._changed:
            begin = max(heapq.heappop(self._free), time.monotonic())
            end = begin + self._duration(batch)
            heapq.heappush(self._free, end)
            self._count += 1
            heapq.heappush(self._held, (end, self._count, future, batch))
            self._changed.notify()
        return future

    def _release(self) -> None:
        while True:
            with self._changed:
                while not self._held or self._held[0][0] > time.monotonic():
                    self._changed.wait(self._held[0][0] - time.monotonic() if self._held else None)
                _, _, future, batch = heapq.heappop(self._held)
            future.set_result(Done(len(batch), (), self._duration(batch)))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--workers", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=160_000)
    parser.add_argument("--seconds", type=float, default=0.5, help="that a run takes")
    given = parser.parse_args()
    size = Plan(name="any", scenarios=("swaying_ship",), runs=given.runs).batch
    batches = [Batch(0, start, min(start + size, given.runs)) for start in range(0, given.runs, size)]
    draw = random.Random(1)
    durations = {batch: given.seconds * len(batch) * draw.uniform(0.5, 1.5) for batch in batches}
    workers = Workers(lambda: Pretending(given.workers, durations.__getitem__), given.workers)
    start, work = time.monotonic(), time.process_time()
    runs = sum(done.runs for _, done in workers.results(lambda batch: batch, batches))
    wall, work = time.monotonic() - start, time.process_time() - work
    assert runs == given.runs
    ideal = sum(durations.values()) / given.workers
    print(f"{given.runs} runs in {len(batches)} batches on {given.workers} workers: {wall:.1f} s")
    print(f"  where no worker ever waits {ideal:.1f} s: {wall / ideal:.3f}")
    print(f"  CPU time of the scheduling process: {1e3 * work / len(batches):.2f} ms for each batch")


if __name__ == "__main__":
    main()
