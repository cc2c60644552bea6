"""An interruption that comes where Python drops exceptions ends the command all the same."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap

import pytest

PROGRAM = textwrap.dedent(
    """
    import signal, time
    from sim_scenarios import cli

    class Dropped:
        def __del__(self):
            signal.raise_signal(signal.{name})

    def run():
        Dropped()
        time.sleep(20)
        return 0

    cli._run = run
    cli.main()
    """
)


@pytest.mark.parametrize(("name", "word"), [("SIGTERM", "terminated"), ("SIGINT", "interrupted")])
def test_an_interruption_that_python_drops_is_asked_again(name: str, word: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(name=name)],
        capture_output=True,
        text=True,
        timeout=15,
        check=False,
    )
    assert done.stderr == f"truenorth: {word}\n"
    assert done.returncode == 128 + signal.Signals[name]
