"""Standard output that cannot take everything, or anything: a sentence, and never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMMAND = "import sim_scenarios.cli as cli; cli._run = lambda: print({text!r} * {times}) or 0; cli.main()"


def command(text: str, times: int = 1, **how: object) -> subprocess.CompletedProcess[str]:
    code = COMMAND.format(text=text, times=times)
    return subprocess.run([sys.executable, "-c", code], text=True, check=False, **how)  # type: ignore[call-overload,no-any-return]


def test_what_an_encoding_lacks_is_written_out() -> None:
    done = command("m\xf6ve", capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stdout, done.stderr) == (0, "m\\xf6ve\n", "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("length", [5, 1_000_000])
def test_a_full_disk_is_told(length: int) -> None:
    """Of a text that waits for the end of the command, and of one that does not."""
    with Path("/dev/full").open("w") as full:
        done = command("x", length, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "truenorth: standard output: No space left on device\n"


def test_it_may_be_closed_from_the_beginning() -> None:
    done = command("x", stderr=subprocess.PIPE, preexec_fn=lambda: os.close(1))
    assert (done.returncode, done.stderr) == (0, "")
