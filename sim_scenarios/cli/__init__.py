"""The command `truenorth`: every subcommand is one function call of the package and a report.

Each subcommand is a module of its own; `application` registers them.
"""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
from types import FrameType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

BAD_INPUT: Final = 2
INTERRUPTED: Final = 130  # 128 + SIGINT, as shells have it

_ENDING: Final = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "hung up"}
"""Signals that ask a command to end, and what it says then: a terminal's, a batch system's, a lost line's."""


def main() -> None:
    """Run the command. A signal ends it in one line, be it while Python still imports.

    Whatever the signal, the command cleans up as after Ctrl-C. The exit code is 128 + its number.
    """
    received: signal.Signals | None = None

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal received
        received = signal.Signals(number)
        while frame is not None:
            if frame.f_code is ask_again.__code__:  # Python drops what is raised there, too
                ask_later()
                return
            frame = frame.f_back
        raise KeyboardInterrupt

    def ask_later() -> None:
        threading.Timer(0.01, os.kill, [os.getpid(), received or signal.SIGINT]).start()

    def ask_again(ignored: UnraisableHookArgs) -> None:
        # Python drops what is raised where nobody can catch it, as in the callback of a weak reference.
        if ignored.exc_type is KeyboardInterrupt:
            ask_later()
        else:
            sys.__unraisablehook__(ignored)

    sys.unraisablehook = ask_again
    ending = [signal.Signals[name] for name in _ENDING if hasattr(signal, name)]
    for one in ending:
        if signal.getsignal(one) in (signal.SIG_DFL, signal.default_int_handler):  # not ignored, as by nohup
            signal.signal(one, interrupt)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # what a terminal cannot show is written out
            stream.reconfigure(errors="backslashreplace")
    try:
        code = _run()
        if sys.stdout is not None:  # as it is where it was closed from the beginning
            sys.stdout.flush()
    except KeyboardInterrupt:
        code = INTERRUPTED
    except OSError as error:  # nobody takes what is printed
        print(f"truenorth: standard output: {error.strerror or error}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # so that Python does not try again at its end
        code = BAD_INPUT
    except Exception:
        # A compiled module that is interrupted while it is imported says that it cannot be imported.
        if received is None:
            raise
        code = INTERRUPTED
    for one in ending:
        signal.signal(one, signal.SIG_IGN)  # what is left to do is to clean up
    if code == INTERRUPTED:
        # Where an exec() was interrupted, as while a dataclass is made, CPython ends by killing itself,
        # whoever caught it, unless another text is evaluated.
        eval("None")
        received = received or signal.SIGINT
        print(f"truenorth: {_ENDING[received.name]}", file=sys.stderr)
        code = 128 + received
    sys.exit(code)  # type: ignore[arg-type]


def _run() -> object:
    """Exit code of the command."""
    try:
        from sim_scenarios.cli.application import app

        app()
    except SystemExit as end:
        return end.code
    return 0
