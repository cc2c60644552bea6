"""A pool of processes of this machine that nobody else can reach, and that does not outlive its owner.

Its processes are told what to do through pipes that they have from their owner; none listens anywhere.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread

from sim_scenarios import folders


@contextmanager
def processes(workers: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """A pool of processes, one for each core, that end with this context.

    At an exception (an interruption, say) they end at once, in the midst of whatever they do; and likewise
    when the owner is killed. They are started anew and import the caller's main module, which therefore must
    guard what it does with `if __name__ == "__main__"`.
    """
    context = multiprocessing.get_context("spawn")
    if folders.SEMAPHORES.is_dir():
        # They are found by name, and outlive a group of processes that is killed as a whole.
        process = multiprocessing.current_process()
        process._config["semprefix"] = f"/{folders.temporary().name}"  # type: ignore[attr-defined]
    wire, lifeline = context.Pipe(duplex=False)
    with wire, lifeline:
        executor = ProcessPoolExecutor(
            workers or os.cpu_count(), context, initializer=_begin, initargs=(wire, folders.temporary())
        )
        try:
            yield executor
        except BaseException:
            lifeline.close()
            raise
        finally:
            executor.shutdown(cancel_futures=True)


def _begin(wire: Connection, temporary: Path) -> None:
    """Set up a process of the pool: a terminal interrupts them all, which is for the owner to answer."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    folders.share(temporary)
    Thread(target=_end_with_owner, args=(wire,), daemon=True).start()


def _end_with_owner(wire: Connection) -> None:
    """Nothing ever comes on the wire; it ends when the owner closes its end, or dies."""
    try:
        wire.recv_bytes()
    except (EOFError, OSError):
        os._exit(1)
