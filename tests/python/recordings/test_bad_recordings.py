"""Recordings that disks and editors have spoilt: each is refused in a sentence, none ends in a traceback."""

from __future__ import annotations

import contextlib
import gzip
import math
import os
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
from sim_scenarios.recordings import load
from sim_scenarios.recordings.feed import feed

ROWS = 300
COLUMNS = [
    "time",
    *(f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz"),
    *(f"gnss_velocity_{axis}" for axis in ("east", "north", "up")),
    *("gnss_latitude", "gnss_longitude", "gnss_height", "gnss_time"),
]
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
    if value == "9" * 400 and column not in ("time", "gnss_time", "gnss_latitude"):
        load(tmp_path / "x.csv")  # is infinite: the filter refuses the sample or the fix, and counts it
        return
    column = "latitudes" if value == "9" * 400 and column == "gnss_latitude" else column
    with pytest.raises(InputError, match=rf"x\.csv: .*{column}"):
        load(tmp_path / "x.csv")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            lambda t: t.drop(columns="delta_angle_y"),
            "there is no column delta_angle_y; did you mean 'delta_angle_",
        ),
        (lambda t: t.iloc[:1], "has 1 samples"),
        (lambda t: t[COLUMNS[:7]].assign(time=0.0), "has 1 samples"),
        (
            lambda t: t.assign(**{c: 100 * t[c] for c in COLUMNS if c.startswith("delta")}),
            "seems to hold rates, not increments",
        ),
        (
            lambda t: t.assign(delta_velocity_z=t.delta_velocity_z / 9.8),
            r"\|delta_velocity\| / dt is (1|0\.99)",
        ),
    ],
)
def test_what_the_plain_form_cannot_be_is_refused(
    table: pd.DataFrame, tmp_path: Path, edit: Callable[[pd.DataFrame], pd.DataFrame], message: str
) -> None:
    edit(table).to_csv(tmp_path / "x.csv", index=False)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "x.csv")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e308])
def test_a_time_that_is_none_is_refused(table: pd.DataFrame, tmp_path: Path, value: float) -> None:
    spoilt = table.copy()
    spoilt.loc[100, "time"] = value
    spoilt.to_csv(tmp_path / "x.csv", index=False)
    with pytest.raises(InputError, match="time must"):
        load(tmp_path / "x.csv")


def test_a_byte_order_mark_is_passed_over(table: pd.DataFrame, tmp_path: Path) -> None:
    table.to_csv(tmp_path / "x.csv", index=False, encoding="utf-8-sig")
    assert len(load(tmp_path / "x.csv").imu.time) == ROWS


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
            feed(load(file))
        assert time.process_time() - start < 1, seed


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "imu.csv")
    for command in ("replay", "import"):
        result = CliRunner().invoke(app, [command, str(tmp_path / "imu.csv")])
        assert result.exit_code == 2
        assert "imu.csv" in result.stderr
