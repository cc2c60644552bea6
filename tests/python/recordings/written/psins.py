"""Files of counts, as base/io/imufile.m of the PSINS toolbox writes them."""

from __future__ import annotations

from pathlib import Path

from sim_scenarios.recordings.tables import Array

PERIOD = 0.01  # s
GRAVITY = 9.780327  # m/s2
ANGLE, VELOCITY = 0.1, 125.0
"""What a count is worth [arcsec, ug s]."""


def counted(path: Path, counts: Array, start: float = 0.0) -> Path:
    """A text file as base/io/imufile.m writes it."""
    end = " 0" if counts.shape[1] == 7 else ""
    head = [
        "% PSINS-format SIMU log file. (DO NOT EDIT!)",
        "%   Conventionally, SIMU is mounted",
        f"0.000000 0.000000 -90.600000 0.000000 0.000000 0.000000{end}",
        f"34.24604800 108.90966400 380.000 {start:.8f} {1000 * PERIOD:.8f} {GRAVITY:f}{end}",
        f"{ANGLE:f} {ANGLE:f} {ANGLE:f} {VELOCITY:.3f} {VELOCITY:.3f} {VELOCITY:.3f}{end}",
        "",
    ]
    path.write_text("\n".join(head + [" ".join(str(int(x)) for x in row) for row in counts]) + "\n")
    return path
