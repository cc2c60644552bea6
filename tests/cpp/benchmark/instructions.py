"""Instructions of an AlignmentFilter, counted by callgrind: of a fix, and of a step between two.

    LOOP=build/native/tests/cpp/fmi/bench_loop
    python tests/cpp/benchmark/instructions.py $LOOP build/fmus/AlignmentFilter.fmu [OLDER.fmu]

The program (filter_loop.cpp) gives the filter increments at 100 Hz, and a fix every second or every half.
What is counted is how it sets inputs and does steps, nothing else; what initialisation costs falls out of the
differences of three runs. An older FMU beside it tells by how much the cost has changed.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

STEPS, RATE = 6000, 100
COUNTED = ("fmi2SetReal", "fmi2SetInteger", "fmi2DoStep")

STANDARD = "INTEGER corrector 1"
NO_GATE = "BOOLEAN gate.enabled 0"
LINEARISED = "INTEGER predictor 1"
INVARIANT = "INTEGER error_model 5 BOOLEAN coarse.enabled 0"
CASES = {
    "10 states, as it is": "",
    "10 states, standard": STANDARD,
    "10 states, standard, no gate": f"{STANDARD} {NO_GATE}",
    "10 states, EKF, standard, no gate": f"{LINEARISED} {STANDARD} {NO_GATE}",
    "invariant, as it is": INVARIANT,
    "invariant, standard, no gate": f"{INVARIANT} {STANDARD} {NO_GATE}",
    "invariant, EKF, standard, no gate": f"{INVARIANT} {LINEARISED} {STANDARD} {NO_GATE}",
}


def counted(loop: Path, fmu: Path, parameters: str, steps: int, steps_per_fix: int) -> int:
    """Instructions of a whole run of an unpacked FMU."""
    (binary,) = (fmu / "binaries").glob("*64*/AlignmentFilter.so")
    run = [loop, binary, fmu / "modelDescription.xml", str(steps), str(steps_per_fix), *parameters.split()]
    toggles = [f"--toggle-collect={name}" for name in COUNTED]
    callgrind = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={os.devnull}", *toggles, *run]
    done = subprocess.run(callgrind, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    return int(re.findall(r"Collected : (\d+)", done.stderr)[-1])


def instructions(loop: Path, fmu: Path, parameters: str) -> tuple[float, float]:
    """Instructions of a fix, and of a step without one."""
    runs = ((STEPS, RATE), (2 * STEPS, RATE), (2 * STEPS, RATE // 2))
    short, long, frequent = (counted(loop, fmu, parameters, *run) for run in runs)
    fix = (frequent - long) / (2 * STEPS / RATE)
    return fix, (long - short - fix * STEPS / RATE) / STEPS


def main() -> None:
    """Print a table, with a ratio where there are two FMUs."""
    parser = argparse.ArgumentParser()
    parser.add_argument("loop", type=Path)
    parser.add_argument("fmus", type=Path, nargs="+")
    options = parser.parse_args()
    with TemporaryDirectory() as folder:
        unpacked = [Path(folder, str(k)) for k in range(len(options.fmus))]
        for archive, target in zip(options.fmus, unpacked, strict=True):
            zipfile.ZipFile(archive).extractall(target)
        for case, parameters in CASES.items():
            costs = [instructions(options.loop.resolve(), fmu, parameters) for fmu in unpacked]
            for what, counts in zip(("fix", "step"), zip(*costs, strict=True), strict=True):
                ratio = f"{counts[0] / counts[1]:8.2f}" if len(counts) == 2 else ""
                print(f"{case:36}{what:5}" + "".join(f"{n:12,.0f}" for n in counts) + ratio, flush=True)


if __name__ == "__main__":
    main()
