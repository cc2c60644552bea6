"""TOML files that people, editors and disks have spoilt: each is read, or refused in a sentence."""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_scenarios import toml
from sim_scenarios.errors import InputError

DEEP = 100_000
SPOILT = {
    "cut": b'name = "sh',
    "no UTF-8": b'name = "\xff\xfe"',
    "UTF-16": "name = 1".encode("utf-16"),
    "NUL": b"name = 1\x00",
    "other line ends": b"a = 1\rb = 2",
    "digits without end": b"a = " + b"9" * 10_000,
    "a date that is none": b"a = 2000-13-45",
    "a key twice": b"a = 1\na = 2",
    "deep lists": b"a = " + b"[" * DEEP + b"]" * DEEP,
    "deep tables": b"a = " + b"{b = " * DEEP + b"1" + b"}" * DEEP,
    "a deep key": b"a" + b".a" * DEEP + b" = 1",
    "deep headings": b"[a" + b".a" * DEEP + b"]",
    "a deep key in quotes": b"'a'" + b' . "a"' * DEEP + b" = 1",
    "a word without end": b"a" * toml.LARGEST,
    "lists a bit too deep": b"a = " + b"[" * toml.DEEPEST + b"]" * toml.DEEPEST,
    "too long": b"#" * (toml.LARGEST + 1),
}


@pytest.mark.parametrize("content", SPOILT.values(), ids=SPOILT.keys())
def test_a_spoilt_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "x.toml").write_bytes(content)
    start = time.process_time()
    with pytest.raises(InputError, match=r"x\.toml: (not valid TOML|must )"):
        toml.read(tmp_path / "x.toml")
    assert time.process_time() - start < 1


@settings(max_examples=300)
@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        assert isinstance(toml.read(path), dict)


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text("a = 1", encoding="utf-8-sig")
    assert toml.read(tmp_path / "x.toml") == {"a": 1}


def test_what_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        toml.read(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        toml.read(tmp_path / "absent")


@pytest.mark.parametrize("name", ["absent", "x" * 5000, "a\x00b"])
def test_there_is_no_such_file(tmp_path: Path, name: str) -> None:
    assert not toml.exists(tmp_path / name)


@pytest.mark.parametrize("text", ["[" * DEEP, "9" * 10_000, "\x00", "[" * 20 + "]" * 20, "'"])
def test_a_value_that_is_none_is_a_text(text: str) -> None:
    assert toml.value(text) == text


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2", 2),
        ("2.5", 2.5),
        ("true", True),
        ("10 deg", "10 deg"),
        ("[1, 2]", [1, 2]),
        ("h_infinity", "h_infinity"),
    ],
)
def test_values_on_the_command_line(text: str, value: object) -> None:
    assert toml.value(text) == value


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(InputError, match=r"pipe\.toml: must be a file"):
        toml.read(tmp_path / "pipe.toml")


@pytest.mark.parametrize("text", ["plain", "two\nlines", "\x1b[2J", "\x7f", "\u2028", "caf\xe9", '"', "\\"])
def test_what_is_written_is_read(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.toml"
    path.write_text(
        f"{toml.comment(text)}\nx = {toml.written(text)}\ny = {toml.written({'a': [1, text]})}\n",
        encoding="utf-8",
        newline="",
    )
    assert toml.read(path) == {"x": text, "y": {"a": [1, text]}}
