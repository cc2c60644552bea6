"""What importers were measured to do with an export, kept in `importers.json`, as `docs/importers.md`.

    python tests/fmus/importer_table.py        # writes the page from what is kept

A cell is the largest difference from the reference results that a test found, or what the importer said that
it cannot do; nothing else gets in.
"""

from __future__ import annotations

import csv
import json
import os
import platform
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

KEPT = Path(__file__).with_name("importers.json")
PAGE = Path(__file__).parents[2] / "docs" / "importers.md"
RECORDING = "TRUENORTH_RECORD_IMPORTERS"


@dataclass(frozen=True, order=True)
class Importer:
    """A tool, its version, how it was used, and the version of FMI."""

    name: str
    version: str
    way: str
    fmi: str


def asked() -> bool:
    """Whether what is measured is to be kept."""
    return os.environ.get(RECORDING) == "1"


def keep(importer: Importer, scenario: str, outcome: float | str) -> None:
    """Keep what a test measured, if that is asked for; an older figure of the same cell gives way."""
    if not asked():
        return
    cells = [cell for cell in load() if (cell["name"], cell["way"], cell["fmi"], cell["scenario"]) !=
             (importer.name, importer.way, importer.fmi, scenario)]  # fmt: skip
    machine = f"{platform.system()} {platform.machine()}"
    cells.append(
        {**asdict(importer), "scenario": scenario, "outcome": outcome, "on": machine,
         "date": date.today().isoformat()}
    )  # fmt: skip
    cells.sort(key=lambda cell: [str(cell[key]) for key in ("name", "way", "fmi", "scenario")])
    KEPT.write_text(json.dumps(cells, indent=1) + "\n", encoding="utf-8")


def load() -> list[dict[str, str | float]]:
    """All cells."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else []


def page() -> str:
    """The page, from what is kept."""
    cells = load()
    scenarios = list(dict.fromkeys(sorted(str(cell["scenario"]) for cell in cells)))
    rows: dict[tuple[str, ...], dict[str, str]] = {}
    for cell in cells:
        row = tuple(str(cell[key]) for key in ("name", "version", "way", "fmi", "on", "date"))
        rows.setdefault(row, {})[str(cell["scenario"])] = shown(cell["outcome"])
    head = ["importer", "version", "way", "FMI", "on", "day", *(f"`{name}`" for name in scenarios)]
    lines = [head, ["---"] * len(head)]
    lines += [[*row, *(figures.get(name, "not run") for name in scenarios)] for row, figures in rows.items()]
    return HEAD + "".join(f"| {' | '.join(line)} |\n" for line in lines)


HEAD = """# What importers do with an export

For those who take an export into a tool of their own.

Each importer was given the folder that `truenorth export SCENARIO` writes, unchanged and with nothing handed
in from outside. A cell is the largest difference of the outputs from the reference results in the folder, of
the largest value of each output; it may be 1e-9 at most; "equal" is none at all. Command lines had each
FMU's inputs from it, and FMPy's its step (`--output-interval`); all else ran the connected system.
`recorded_ship` is a recording: 20 s of TruthPlant's signals in a CSV file, put out by Playback.
`tests/fmus/test_importers.py` measures it; `tests/fmus/importer_table.py` writes the page from its figures.

"""


def shown(outcome: float | str) -> str:
    """A difference, or what the importer cannot do, as a cell."""
    if isinstance(outcome, str):
        return outcome
    return "equal" if outcome == 0 else f"{outcome:.0e}"


def read_csv(path: Path) -> NDArray[np.void]:
    """All columns as numbers; Booleans may be words, elements of an array stand in one column."""
    with path.open(newline="") as file:
        header, *rows = csv.reader(file)
    words = {"True": 1.0, "False": 0.0, "true": 1.0, "false": 0.0}
    sizes = [len(text.split()) for text in rows[0]]
    kinds = [
        (name, float) if size == 1 else (name, float, (size,))
        for name, size in zip(header, sizes, strict=True)
    ]
    numbers = [
        tuple(
            values[0] if len(values) == 1 else tuple(values)
            for values in (
                [words[part] if part in words else float(part) for part in text.split()] for text in row
            )
        )
        for row in rows
    ]
    return np.array(numbers, dtype=kinds)


if __name__ == "__main__":
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
