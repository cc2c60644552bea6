"""Processes that others cannot reach, and that end with their owner."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import dask
import pytest
from distributed import Client, LocalCluster, Security

from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.folders import TEMPORARY, Owned
from sim_scenarios.processes import processes
from sim_scenarios.studies import cluster, execution

Pool = tuple["subprocess.Popen[str]", list[int]]

NOBODY = 65534
LISTENING = "0A"
PROC = Path("/proc")
SEMAPHORES = Path("/dev/shm")
IS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0

OWNER = """
    import os, time
    from sim_scenarios.processes import processes

    if __name__ == "__main__":
        with processes(2) as pool:
            pool.submit(abs, 1).result()
            tasks = [pool.submit(time.sleep, 1000) for _ in range(2)]
            print(os.getpid(), *pool._processes, flush=True)
            tasks[0].result()
"""

linux = pytest.mark.skipif(not PROC.is_dir(), reason="needs /proc to see sockets and processes")


def wait_for(condition: Callable[[], bool], seconds: float = 300.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.05)


def is_alive(process: int) -> bool:
    try:
        return (PROC / str(process) / "stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def listening(processes: list[int]) -> list[str]:
    """Sockets on which processes listen, of TCP and of Unix."""
    inodes = {
        line.split()[9]: line
        for family in ("tcp", "tcp6")
        for line in (PROC / "net" / family).read_text().splitlines()[1:]
        if line.split()[3] == LISTENING
    }
    accepting = 0x10000
    for line in (PROC / "net" / "unix").read_text().splitlines()[1:]:
        if int(line.split()[3], 16) & accepting:
            inodes[line.split()[6]] = line
    open_files = (file for one in processes for file in (PROC / str(one) / "fd").iterdir())
    links = [str(file.readlink()) for file in open_files]
    return [inodes[inode] for inode in inodes if f"socket:[{inode}]" in links]


@pytest.fixture
def owner(tmp_path: Path) -> Iterator[Pool]:
    """A process with a pool that works, and all its processes."""
    (tmp_path / "owner.py").write_text(textwrap.dedent(OWNER), encoding="utf-8")
    command = [sys.executable, str(tmp_path / "owner.py")]
    (tmp_path / "tmp").mkdir()
    place = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, start_new_session=True, env=place
    ) as process:
        try:
            assert process.stdout is not None
            yield process, sorted(set(map(int, process.stdout.readline().split())))
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


@linux
def test_no_process_listens_and_none_outlives_its_owner(
    owner: tuple[subprocess.Popen[str], list[int]],
) -> None:
    process, all_of_them = owner
    assert len(all_of_them) == 3
    assert listening(all_of_them) == []
    process.kill()
    wait_for(lambda: not any(map(is_alive, all_of_them[1:])))


@pytest.mark.skipif(not SEMAPHORES.is_dir(), reason="semaphores are kept elsewhere here")
def test_the_next_one_removes_the_semaphores_of_a_group_that_was_killed(owner: Pool, tmp_path: Path) -> None:
    """With the process that would remove them otherwise."""
    process, all_of_them = owner
    [folder] = (tmp_path / "tmp").iterdir()
    semaphores = list(SEMAPHORES.glob(f"sem.{folder.name}-*"))
    assert semaphores
    os.killpg(process.pid, signal.SIGKILL)
    wait_for(lambda: not any(map(is_alive, all_of_them[1:])))
    process.wait()
    assert all(semaphore.exists() for semaphore in semaphores)
    Owned(tmp_path / "tmp", TEMPORARY).remove()
    assert not any(semaphore.exists() for semaphore in semaphores)
    assert list((tmp_path / "tmp").iterdir()) == []


@linux
@pytest.mark.skipif(not IS_ROOT, reason="needs root, to become another user")
def test_another_user_cannot_reach_a_process(owner: Pool) -> None:
    """Neither its pipes, nor its memory, nor by a signal."""
    for one in owner[1]:
        code = textwrap.dedent(f"""
            import os, signal
            os.setgroups([]); os.setgid({NOBODY}); os.setuid({NOBODY})
            reached = []
            for reach in (
                lambda: os.listdir("/proc/{one}/fd"),
                lambda: open("/proc/{one}/fd/0", "wb", buffering=0),
                lambda: open("/proc/{one}/mem", "r+b", buffering=0),
                lambda: os.kill({one}, signal.SIGTERM),
            ):
                try:
                    reached.append(reach())
                except PermissionError:
                    pass
            raise SystemExit(len(reached))
        """)
        assert subprocess.run([sys.executable, "-S", "-c", code], check=False).returncode == 0


def die_once(file: Path) -> str:
    """A task on which a worker dies the first time."""
    if file.exists():
        return "done"
    file.touch()
    os.kill(os.getpid(), signal.SIGKILL)
    return "never"


def die(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fail(_: int) -> None:
    raise InputError("said on the worker")


@linux
def test_a_worker_that_dies_is_replaced(tmp_path: Path) -> None:
    files = [tmp_path / str(i) for i in range(2)]
    with execution.workers(1, None) as workers:
        assert dict(workers.results(die_once, files)) == dict.fromkeys(files, "done")


@linux
def test_workers_that_die_again_and_again_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "MOST_DEATHS", 2)
    with pytest.raises(SimulationError, match="2 times workers died"), execution.workers(1, None) as workers:
        list(workers.results(die, [1]))


def test_what_a_worker_says_is_heard() -> None:
    with pytest.raises(InputError, match="said on the worker"), execution.workers(1, None) as workers:
        list(workers.results(fail, [1]))


def test_an_exception_does_not_wait_for_the_tasks() -> None:
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt), processes(1) as pool:  # noqa: PT012
        pool.submit(abs, 1).result()
        pool.submit(time.sleep, 1000)
        raise KeyboardInterrupt
    assert time.monotonic() - start < 500


ELSEWHERE = [
    "tcp://10.0.0.1:8786",
    "10.0.0.1:8786",
    "tcp://[2001:db8::1]:8786",
    "ws://host:80",
    "host:1",
    "?",
]
HERE = ["tcp://127.0.0.1:9", "localhost:9", "tcp://[::1]:9", "127.0.0.2:9"]


def connect(scheduler: str, insecure: bool = False) -> None:
    with execution.workers(None, scheduler, insecure):
        pytest.fail("there is nobody")


@pytest.mark.parametrize("scheduler", ELSEWHERE)
def test_a_scheduler_elsewhere_needs_tls(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "Client", called := Called())
    with pytest.raises(InputError, match=r"--scheduler .* without TLS can run code"):
        connect(scheduler)
    assert called.address == ""
    with pytest.raises(InputError, match="there is no answer"):
        connect(scheduler, insecure=True)
    assert called.address == scheduler


@pytest.mark.parametrize("scheduler", HERE)
def test_a_scheduler_of_this_machine_may_do_without(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "Client", called := Called())
    with pytest.raises(InputError, match="there is no answer"):
        connect(scheduler)
    assert called.address == scheduler


def test_tls_without_certificates_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "Client", called := Called())
    with pytest.raises(InputError, match=r"CA_FILE, DASK.*CLIENT__CERT, DASK.*CLIENT__KEY"):
        connect("tls://10.0.0.1:8786")
    assert called.address == ""


@pytest.mark.skipif(shutil.which("openssl") is None, reason="needs openssl, to make certificates")
def test_a_scheduler_with_tls_takes_those_with_its_certificate(tmp_path: Path) -> None:
    certificate, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    request = [
        "openssl",
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=campaign",
    ]
    subprocess.run([*request, "-keyout", str(key), "-out", str(certificate)], check=True, capture_output=True)
    settings = {"tls.ca-file": str(certificate)}
    for role in ("client", "scheduler", "worker"):
        settings |= {f"tls.{role}.cert": str(certificate), f"tls.{role}.key": str(key)}
    with dask.config.set({f"distributed.comm.{name}": value for name, value in settings.items()}):
        how = {"processes": False, "n_workers": 1, "dashboard_address": None, "protocol": "tls://"}
        with LocalCluster(**how, security=Security()) as secured:
            address = secured.scheduler_address
            assert address.startswith("tls://")
            with execution.workers(None, address) as workers:
                assert dict(workers.results(abs, [-1, 2])) == {-1: 1, 2: 2}
            with pytest.raises(OSError, match=r"(?i)closed|reset|timed out"):
                Client(address.replace("tls://", "tcp://"), timeout=5)


class Called:
    """In the place of Dask's client: keeps the address, and finds nobody there."""

    address = ""

    def __call__(self, address: str, timeout: float) -> object:  # noqa: ARG002
        self.address = address
        raise OSError("nobody")


@pytest.mark.parametrize("scheduler", ["ucx://127.0.0.1:1", "inproc://x", "file:///etc/passwd"])
def test_other_ways_to_a_scheduler_are_refused(scheduler: str) -> None:
    with pytest.raises(InputError, match="must begin with tls://, tcp:// or ws://"):
        connect(scheduler, insecure=True)
