"""Names stay in the folder that they are given for, whatever they are made of."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from sim_scenarios.archives import read_archive, write_archive
from sim_scenarios.errors import InputError
from sim_scenarios.names import (
    LONGEST,
    checked_label,
    checked_name,
    checked_text,
    file_name,
    file_names,
    printable,
)

GOOD = ["zigzag", "my_ship.v2", "A-1", "_", "7", "x" * LONGEST]
OUTSIDE = ["..", ".", "../..", "/abs", "a/b", "a\\b", "C:", "C:\\x", "~", ".hidden", "-rf", ""]
BROKEN = ["a\nb", "a\x1b[2Jb", "a\x00", "a b", "x" * (LONGEST + 1), "ä", "a\u202eb", "a*", "$HOME", "a;b"]


@pytest.mark.parametrize("name", GOOD)
def test_a_name(name: str) -> None:
    assert checked_name(name) == name


@pytest.mark.parametrize("name", OUTSIDE + BROKEN)
def test_no_name(name: str) -> None:
    with pytest.raises(InputError, match="must have letters") as refused:
        checked_name(name)
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 3 * LONGEST


@given(st.text())
def test_a_name_is_a_file_in_its_folder(text: str) -> None:
    try:
        name = checked_name(text)
    except InputError:
        return
    folder = Path("/folder")
    assert (folder / name).resolve().parent == folder


@pytest.mark.parametrize("label", ["robust UKF, L = I (printed)", "EKF/UKF", "γ = 1.5", "x" * LONGEST])
def test_a_label_is_any_line(label: str) -> None:
    assert checked_label(label) == label


NO_LINE = ["", " ", "a\nb", "a\x1b[2J", "a\x00", "a\x7f", "a\u2028b", "x" * (LONGEST + 1)]


@pytest.mark.parametrize("label", NO_LINE)
def test_a_label_that_is_no_line(label: str) -> None:
    with pytest.raises(InputError, match="label"):
        checked_label(label)


def test_a_text_has_lines_but_no_other_control_characters() -> None:
    assert checked_text("one\n\ttwo") == "one\n\ttwo"
    with pytest.raises(InputError, match=r"'\\x1b'"):
        checked_text("one\n\x1b[2J")


@given(st.lists(st.text(), unique=True, max_size=30))
def test_every_label_has_a_file_of_its_own(labels: list[str]) -> None:
    names = file_names(labels)
    assert list(names) == labels
    assert len({name.casefold() for name in names.values()}) == len(labels)
    for name in names.values():
        assert 0 < len(name) <= LONGEST
        assert (Path("/folder") / name).resolve().parent == Path("/folder")


def test_files_of_like_labels_are_told_apart() -> None:
    assert file_names(["a b", "a_b", "A B", "c"]) == {"a b": "a_b", "a_b": "a_b-2", "A B": "A_B-3", "c": "c"}
    assert file_name("zigzag gnss.rate=1.0") == "zigzag_gnss.rate=1.0"


@given(st.text())
def test_what_is_printed_moves_no_cursor(text: str) -> None:
    shown = printable(text)
    assert all(one.isprintable() or one in "\n\t" or ord(one) > 0x9F for one in shown)
    Console(file=io.StringIO()).print(shown, markup=False)
    shown.encode()


NO_MEMBER = ["../x", "/x", "a/../../x", "a//b", "./x", "a\\..\\x", "C:x", "x\ny", "x\x00", "", "a/"]


@pytest.mark.parametrize("name", NO_MEMBER)
def test_an_archive_refuses_a_member_outside(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="must not be a member of an archive"):
        write_archive(tmp_path / "x.zip", {"good": "", name: ""})
    assert not (tmp_path / "x.zip").exists()


def test_an_archive_that_is_given_is_no_way_around(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "given.zip", "w") as content:
        content.writestr("folder/", "")
        content.writestr("../sly", "")
    with pytest.raises(InputError, match=r"'\.\./sly' must not be a member"):
        write_archive(tmp_path / "copy.zip", {**read_archive(tmp_path / "given.zip"), "more": ""})
    assert not (tmp_path / "copy.zip").exists()
