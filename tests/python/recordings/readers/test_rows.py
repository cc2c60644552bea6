"""Text files of nothing but numbers."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import rows

TEXT = "# comment\n\n% another\n1.5 -2e-3  3 # end\n\t4 5 6 \n"


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_comments_blanks_and_compression(tmp_path: Path) -> None:
    expected = [[1.5, -2e-3, 3], [4, 5, 6]]
    np.testing.assert_array_equal(rows.numbers(written(tmp_path / "a.txt", TEXT)), expected)
    (tmp_path / "a.txt.gz").write_bytes(gzip.compress(TEXT.encode()))
    np.testing.assert_array_equal(rows.numbers(tmp_path / "a.txt.gz"), expected)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("7 8", "line 6: has 2 numbers, where the first row has 3"),
        ("7 8 9 10", "line 6: has 4 numbers, where the first row has 3"),
        ("7 x8 9", "line 6: 'x8' is not a finite number"),
        ("7 8 nan", "line 6: 'nan' is not a finite number"),
        ("7 inf 9", "line 6: 'inf' is not a finite number"),
        ("7 8 9\xff", "line 6: '9\xff' is not a finite number"),
    ],
)
def test_rows_that_are_none(tmp_path: Path, row: str, words: str) -> None:
    with pytest.raises(InputError, match=rf"a\.txt: {words}"):
        rows.numbers(written(tmp_path / "a.txt", f"{TEXT}{row}\n1 2 3\n"))


def test_no_row(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no row of numbers"):
        rows.numbers(written(tmp_path / "a.txt", "# only this\n"))


def test_the_line_of_a_row(tmp_path: Path) -> None:
    path = written(tmp_path / "a.txt", TEXT)
    assert [rows.line(path, row) for row in range(2)] == [4, 5]
