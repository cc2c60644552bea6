"""Solution files of RTKLIB, written here as its `outsolhead` and `outpos` write them."""

from __future__ import annotations

import gzip
import os
from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from written.rtklib import ABOVE, HEADER, row, solution, written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import rtklib
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.units import DEGREE

REAL = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "car_drive", "gnss.pos.gz")


def test_every_field_is_where_its_name_says(tmp_path: Path) -> None:
    path = written(tmp_path, solution())
    assert rtklib.recognises(path)
    read = rtklib.read(path)
    fixes = read.gnss
    np.testing.assert_allclose(fixes.position[0], [40.0966268 * DEGREE, -7.8474483 * DEGREE, 1601.474])
    np.testing.assert_array_equal(fixes.velocity, [[-2.5, 1.25, 0.125]] * 2)
    np.testing.assert_array_equal(fixes.position_sigma[0], [0.0097, 0.0098, 0.01])
    np.testing.assert_array_equal(fixes.velocity_sigma[0], [0.05868, 0.05869, 0.05867])
    assert read.clock is Clock.GPS
    # 2025-01-01 is 16432 days after 1980-01-06.
    np.testing.assert_allclose(fixes.time + (read.epoch - 16432 * 86400), [70458.499, 70458.749], atol=1e-10)
    assert read.place("gnss", 1) == "line 6"


@pytest.mark.parametrize(
    ("scale", "stamps", "clock", "seconds"),
    [
        ("GPST", ("2347 329658.499", "2347 329658.749"), Clock.GPS, 2347 * 604800 + 329658.499),
        ("GPST", ("2347 604799.900", "2348 0.150"), Clock.GPS, 2347 * 604800 + 604799.9),
        ("GPST", ("2025/01/01 23:59:59.9", "2025/01/02 00:00:00.15"), Clock.GPS, 16433 * 86400 - 0.1),
        ("UTC", ("2025/01/01 19:34:18.499", "2025/01/01 19:34:18.749"), Clock.UNIX, 1735760058.499),
        ("JST", ("2025/01/02 04:34:18.499", "2025/01/02 04:34:18.749"), Clock.UNIX, 1735760058.499),
    ],
)
def test_times_in_every_form(
    tmp_path: Path, scale: str, stamps: tuple[str, ...], clock: Clock, seconds: float
) -> None:
    read = rtklib.read(written(tmp_path, solution(scale, *stamps)))
    assert read.clock is clock
    assert read.epoch + read.gnss.time[0] == pytest.approx(seconds, abs=1e-6)
    assert np.diff(read.gnss.time) == pytest.approx([0.25], abs=1e-9)


def test_another_order_of_fields_and_commas(tmp_path: Path) -> None:
    text = "%  GPST,latitude(deg),longitude(deg),height(m),ve(m/s),vn(m/s)\n2025/01/01 00:00:01,40,-7,3,1,2\n"
    fixes = rtklib.read(written(tmp_path, text)).gnss
    np.testing.assert_array_equal(fixes.velocity, [[1, 2, np.nan]])
    np.testing.assert_array_equal(fixes.position_sigma, [[0, 0, 0]])


def test_degrees_minutes_seconds(tmp_path: Path) -> None:
    header = "%  GPST   latitude(d'\") longitude(d'\") height(m) Q\n"
    text = header + "2025/01/01 00:00:01  40 06 36.0  -07 30 18.0  3.0 1\n"
    fixes = rtklib.read(written(tmp_path, text)).gnss
    np.testing.assert_allclose(fixes.position[0] / [DEGREE, DEGREE, 1], [40.11, -7.505, 3.0])


def test_rows_without_a_solution_are_left_out_and_a_cut_last_line_is(tmp_path: Path) -> None:
    text = solution() + row("2025/01/01 19:34:18.999", q=0) + "2025/01/01 19:34:19.2"
    assert len(rtklib.read(written(tmp_path, text)).gnss.time) == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            HEADER.format(scale="GPST").replace(
                "latitude(deg) longitude(deg)  height(m)", "x-ecef(m) y-ecef(m) z-ecef(m)"
            ),
            "positions must be latitude, longitude, height, and are x-ecef",
        ),
        (
            HEADER.format(scale="GPST").replace(
                "latitude(deg) longitude(deg)  height(m)", "e-baseline(m) n-baseline(m) u-baseline(m)"
            ),
            "positions must be latitude, longitude, height, and are e-baseline",
        ),
        ("2025/01/01 19:34:18.499 40 -7 1600 1\n", "names the fields"),
        (ABOVE + HEADER.format(scale="GPST"), "has no solution"),
        (
            "%  GPST   latitude(d'\") longitvde(d'\") height(m) Q\n2025/01/01 0:0:1  40 6 36  -7.5  3.0 1\n",
            "names a latitude and no longitude",
        ),
        (
            solution().replace("1601.4740", "16o1.4740", 1),
            "line 5: could not convert string to float: '16o1.4740'",
        ),
        (ABOVE + HEADER.format(scale="GPST") + row("2347 1.0", q=0), "has no solution"),
        (solution().replace("   1  21", "   x  21", 1), "line 5: could not convert string to float: 'x'"),
        (solution().replace("19:34:18.499", "19-34"), "line 5: '2025/01/01 19-34' is no time such as"),
        (solution().replace(" 0.05868", "", 1), "line 5: has 23 cells, and the header names 24"),
    ],
)
def test_what_is_no_solution_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as refused:
        rtklib.read(path)
    assert words in str(refused.value)
    assert str(refused.value).startswith(f"{path}: ")


@pytest.mark.parametrize("stamp", ["2025/01/01 19:34:{:06.3f}", "2347 {:.3f}"])
def test_damaged_files(tmp_path: Path, stamp: str) -> None:
    path = written(tmp_path, solution("GPST", *(stamp.format(k) for k in range(10))))
    assert len(refusals(rtklib.read, path)) > 50


def test_damaged_degrees_minutes_seconds(tmp_path: Path) -> None:
    header = "%  GPST   latitude(d'\") longitude(d'\") height(m) Q\n"
    rows = [f"2025/01/01 00:00:{k:02d}  40 06 36.0  -07 30 18.0  3.0 1\n" for k in range(10)]
    assert len(refusals(rtklib.read, written(tmp_path, header + "".join(rows)))) > 50


@pytest.mark.skipif(not REAL.exists(), reason="no car_drive in the folder TRUENORTH_RECORDINGS")
def test_a_real_solution() -> None:
    assert rtklib.recognises(REAL)
    read = rtklib.read(REAL)
    rows = [line.split() for line in gzip.decompress(REAL.read_bytes()).decode().splitlines()[1:]]
    assert len(read.gnss.time) == len(rows)
    np.testing.assert_array_equal(read.gnss.velocity[:, 1], [float(row[15]) for row in rows])
    assert np.median(np.diff(read.gnss.time)) == pytest.approx(0.25, abs=1e-9)
