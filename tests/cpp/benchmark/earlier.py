"""Plant and filters in a loop by hand, beside those of an earlier version: CPU seconds of a minute.

    python tests/cpp/benchmark/earlier.py build/native/tests/cpp/fmi/libplain_loop.so FOLDER

`swaying_ship` at 100 Hz, as runner.py has it: the plant alone, with one filter, and with all six that the
scenario compares. FOLDER holds TruthPlant.fmu and AlignmentFilter.fmu of the other version, which must know
the parameters of the scenario. Both take turns, so that what else the machine does meets them alike.
"""

from __future__ import annotations

import argparse
import ctypes
from pathlib import Path
from statistics import median

import runner

from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.scenario import load_scenario

TURNS = 31


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("library", help="plain_loop, as built")
    parser.add_argument("folder", type=Path, help="with the FMUs of an earlier version")
    given = parser.parse_args()
    now = Fmus()
    earlier = Fmus({path.stem: Fmu(path) for path in given.folder.glob("*.fmu")})
    scenario = load_scenario("swaying_ship", now, settings=runner.SHORT, running=None)
    step = runner.by_hand(ctypes.CDLL(given.library), scenario)
    for count in (0, 1, len(scenario.filters())):
        found = [
            tuple(runner.spent(scenario, fmus, count, None, step) for fmus in (now, earlier))
            for _ in range(TURNS)
        ]
        ratio = median(one / other for one, other in found)
        seconds = [median(turns) for turns in zip(*found, strict=True)]
        print("plant + {}: {:.4f} s, before {:.4f} s, ratio {:.3f}".format(count, *seconds, ratio))


if __name__ == "__main__":
    main()
