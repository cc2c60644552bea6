"""Recordings that disks and editors have spoilt: each is refused in a sentence, none ends in a traceback."""

from __future__ import annotations

import contextlib
import gzip
import math
import random
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner, Result

from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.recorded_imu import COLUMNS, read_recording, signals_of_imu

ROWS = 300
Spoilt = Callable[[bytes], bytes]


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """A vehicle at rest on the equator, heading north, with a fix a second."""
    clock = 0.01 * np.arange(1, ROWS + 1)
    values = {column: np.zeros(ROWS) for column in COLUMNS}
    values |= {"time": clock, "gnss_time": clock, "delta_velocity_z": np.full(ROWS, 0.0978)}
    made = pd.DataFrame(values)
    made.loc[np.arange(ROWS) % 100 != 0, [c for c in COLUMNS if c.startswith("gnss")]] = np.nan
    return made


def text(table: pd.DataFrame) -> bytes:
    return table.to_csv(index=False).encode()


def replay(file: Path, *arguments: object) -> Result:
    options = ["replay", file, "--heading", 10, "--output", file.parent / "out", *arguments]
    return CliRunner().invoke(app, [str(option) for option in options])


def refused(result: Result) -> str:
    """What is said; that it is a refusal."""
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert "Traceback" not in result.output
    return " ".join(result.stderr.split())


SPOILT: dict[str, Spoilt] = {
    "empty": lambda _: b"",
    "a heading alone": lambda raw: raw.splitlines()[0],
    "cut in a row": lambda raw: (
        raw[: len(raw) // 2].rsplit(b",", 3)[0] + b"\n1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16\n"
    ),
    "no UTF-8": lambda raw: raw.replace(b"time", b"\xff\xfe", 1),
    "UTF-16": lambda raw: raw.decode().encode("utf-16"),
    "NUL": lambda raw: raw.replace(b"0.0", b"\x00", 50),
    "a quote that never ends": lambda raw: raw.replace(b"0.0978", b'"', 1),
    "semicolons": lambda raw: raw.replace(b",", b";"),
    "decimal commas": lambda raw: raw.replace(b",", b";").replace(b".", b","),
    "zeros of a lost block": lambda raw: raw[:3000] + bytes(4096) + raw[7096:],
    "noise": lambda raw: random.Random(1).randbytes(len(raw)),
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT.keys())
def test_a_spoilt_text_is_refused(table: pd.DataFrame, tmp_path: Path, spoil: Spoilt) -> None:
    (tmp_path / "x.csv").write_bytes(spoil(text(table)))
    assert "x.csv: " in refused(replay(tmp_path / "x.csv"))


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.9, 0.999])
def test_a_truncated_archive_is_refused(table: pd.DataFrame, tmp_path: Path, share: float) -> None:
    whole = gzip.compress(text(table))
    (tmp_path / "x.csv.gz").write_bytes(whole[: int(share * len(whole))])
    assert "x.csv.gz: " in refused(replay(tmp_path / "x.csv.gz"))


@pytest.mark.parametrize("seed", range(20))
def test_a_damaged_archive_is_refused(table: pd.DataFrame, tmp_path: Path, seed: int) -> None:
    """A flipped byte anywhere behind the header of the archive, which may hold a wrong date."""
    damaged = bytearray(gzip.compress(text(table)))
    damaged[random.Random(seed).randrange(10, len(damaged))] ^= 0xFF
    (tmp_path / "x.csv.gz").write_bytes(damaged)
    assert "x.csv.gz: " in refused(replay(tmp_path / "x.csv.gz"))


@pytest.mark.parametrize("column", COLUMNS)
@pytest.mark.parametrize("value", ["abc", "1e3m", "--", "True", "1,5", "9" * 400])
def test_what_is_no_number_is_refused(table: pd.DataFrame, tmp_path: Path, column: str, value: str) -> None:
    spoilt = table.astype(object)
    spoilt.loc[100, column] = value
    spoilt.to_csv(tmp_path / "x.csv", index=False)
    if value == "9" * 400 and column != "time":  # is infinite: the filter refuses the sample, and counts it
        read_recording(tmp_path / "x.csv")
        return
    with pytest.raises(InputError, match=rf"x\.csv: .*{column}"):
        read_recording(tmp_path / "x.csv")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_a_time_that_is_none_is_refused(table: pd.DataFrame, tmp_path: Path, value: float) -> None:
    spoilt = table.copy()
    spoilt.loc[100, "time"] = value
    spoilt.to_csv(tmp_path / "x.csv", index=False)
    with pytest.raises(InputError, match="time must"):
        read_recording(tmp_path / "x.csv")


def test_a_gap_that_no_counter_covers_is_refused(table: pd.DataFrame) -> None:
    spoilt = table.copy()
    spoilt.loc[ROWS - 1, "time"] = 1e9
    with pytest.raises(InputError, match="at most 2147483647"):
        signals_of_imu(spoilt)


def test_a_byte_order_mark_is_passed_over(table: pd.DataFrame, tmp_path: Path) -> None:
    table.to_csv(tmp_path / "x.csv", index=False, encoding="utf-8-sig")
    assert list(read_recording(tmp_path / "x.csv").columns) == COLUMNS


STANDING = ["--zero-velocity", "--position", "0,0,0"]
NO_NUMBER = [
    *(["--heading", value] for value in ("nan", "inf")),
    *(["--heading-sigma", value] for value in ("nan", "inf")),
    *(["--levelling", value] for value in ("nan", "inf")),
    *([*STANDING, "--rate", value] for value in ("nan", "inf", "-inf")),
    *([*STANDING, "--sigma", value] for value in ("nan", "inf", "-inf")),
    ["--zero-velocity", "--position", "nan,0,0"],
]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        *((given, "must be finite") for given in NO_NUMBER),
        ([*STANDING, "--rate", "1000"], "rate = 1000 Hz: must be at most"),
        (["--heading-sigma", "-1"], "must be at least 0"),
        (["--levelling", "-1"], "levelling = -1 s"),
    ],
)
def test_options_that_are_no_quantities_are_refused(
    table: pd.DataFrame, tmp_path: Path, arguments: list[str], words: str
) -> None:
    table.to_csv(tmp_path / "x.csv", index=False)
    assert words in refused(replay(tmp_path / "x.csv", *arguments))


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["csv", "csv.gz"])
def test_ten_thousand_damaged_files(table: pd.DataFrame, tmp_path: Path, ending: str) -> None:
    """Bytes changed, lost, doubled: read, or refused within a second."""
    whole = text(table.iloc[:50])
    raw = gzip.compress(whole) if ending == "csv.gz" else whole
    file = tmp_path / f"x.{ending}"
    for seed in range(10_000):
        dice = random.Random(seed)
        damaged = bytearray(raw)
        for _ in range(dice.randrange(1, 4)):
            at = dice.randrange(len(damaged))
            damaged[at : at + dice.randrange(3)] = dice.randbytes(dice.randrange(3))
        file.write_bytes(damaged)
        start = time.process_time()
        with contextlib.suppress(InputError):
            signals_of_imu(read_recording(file))
        assert time.process_time() - start < 1, seed
