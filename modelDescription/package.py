"""Zip an FMU so that the same content always gives the same bytes.

package.py <Name>.fmu <name in the archive>=<file> ...
"""

from __future__ import annotations

import sys
from pathlib import Path

from sim_scenarios.archives import write_archive

if __name__ == "__main__":
    members = {name: Path(file) for name, file in (argument.split("=", 1) for argument in sys.argv[2:])}
    write_archive(Path(sys.argv[1]), members)
