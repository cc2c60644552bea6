"""The command `truenorth`: every subcommand is one function call of the package and a report.

Each subcommand is a module of its own; `application` registers them.
"""

from __future__ import annotations

import sys

INTERRUPTED = 130  # 128 + SIGINT, as shells have it


def main() -> None:
    """Run the command. An interruption ends it in one line, be it while Python still imports."""
    try:
        from sim_scenarios.cli.application import app

        app()
    except KeyboardInterrupt:
        code: object = INTERRUPTED
    except SystemExit as end:
        code = end.code
    if code == INTERRUPTED:
        print("truenorth: interrupted", file=sys.stderr)
    sys.exit(code)  # type: ignore[arg-type]
