"""MATLAB files are read by a process of its own, which may end."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from sim_scenarios import matlab
from sim_scenarios.errors import InputError


def content(variables: dict[str, object], compressed: bool = False) -> bytes:
    file = BytesIO()
    savemat(file, variables, do_compression=compressed)
    return file.getvalue()


@pytest.mark.parametrize("compressed", [False, True])
def test_tables_and_fields_of_structures(compressed: bool) -> None:
    """Names are anything, those of numpy's own archives too; a name may stand in two places."""
    table = np.arange(12.0).reshape(4, 3)
    variables = {"file": table, "arr_0": -table, "trj": {"file": 2 * table, "n": 3.0}, "who": "ship"}
    found = matlab.tables(Path("x.mat"), content(variables, compressed))
    assert [name for name, _ in found] == ["file", "arr_0", "file"]
    np.testing.assert_array_equal([array for _, array in found], [table, -table, 2 * table])


def test_nothing_that_is_a_table() -> None:
    assert matlab.tables(Path("x.mat"), content({"name": "ship", "n": 3.0})) == []


def test_something_else() -> None:
    with pytest.raises(InputError, match=r"x\.mat: cannot be read as a MATLAB file: .+"):
        matlab.tables(Path("x.mat"), b"no MATLAB file")


@pytest.mark.parametrize("bits", [0x20, 0x40, 0x8000])
def test_a_type_that_ends_the_reader(bits: int) -> None:
    """scipy looks numbers of types up without asking whether it knows them."""
    damaged = bytearray(content({"imu": np.ones((50, 7))}))
    doubles = damaged.index((9).to_bytes(4, "little"), 160)
    damaged[doubles : doubles + 4] = (9 ^ bits).to_bytes(4, "little")
    with pytest.raises(InputError, match=r"x\.mat: cannot be read as a MATLAB file: .+"):
        matlab.tables(Path("x.mat"), bytes(damaged))


@pytest.mark.parametrize("python", [None, "", "/no/such/python"])
def test_without_a_python_to_start(python: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", python)
    with pytest.raises(InputError, match=r"x\.mat: is read by a Python of its own"):
        matlab.tables(Path("x.mat"), content({"imu": np.ones((5, 7))}))
