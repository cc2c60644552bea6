"""An interruption ends the command, whatever Python makes of it: drops it, say, or another exception."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Final

import pytest

PROGRAM: Final = """
import signal, time
from sim_scenarios import cli

class Dropped:
    def __del__(self):
        signal.raise_signal(signal.{name})

def run():
{interrupted}

cli._run = run
cli.main()
"""

INTERRUPTED: Final = {
    "in a finaliser, which drops it": """
Dropped()
time.sleep(20)
return 0
""",
    "while Python says what it has dropped": """
import sys
class Failing:
    def __del__(self):
        raise ValueError
sys.__unraisablehook__ = lambda _: signal.raise_signal(signal.{name})
Failing()
time.sleep(20)
return 0
""",
    # Python would end by the signal, whoever catches it.
    "in a text that is executed": """
exec("signal.raise_signal(signal.{name})")
""",
    # As compiled modules do.
    "in a module that then cannot be imported": """
try:
    signal.raise_signal(signal.{name})
except KeyboardInterrupt as error:
    raise ImportError("initialization failed") from error
""",
}


@pytest.mark.parametrize("interrupted", INTERRUPTED.values(), ids=INTERRUPTED)
@pytest.mark.parametrize(("name", "word"), [("SIGTERM", "terminated"), ("SIGINT", "interrupted")])
def test_an_interruption_ends_the_command(tmp_path: Path, interrupted: str, name: str, word: str) -> None:
    body = textwrap.indent(interrupted, "    ")
    program = PROGRAM.replace("{interrupted}", body).replace("{name}", name)
    (tmp_path / "program.py").write_text(program)
    done = subprocess.run(
        [sys.executable, "-m", "program"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=15,
        check=False,
    )
    assert done.stderr == f"truenorth: {word}\n"
    assert done.returncode == 128 + signal.Signals[name]
