"""Whether what an export holds is what was written: no change passes, and none is a traceback."""

from __future__ import annotations

import hashlib
import os
import re
import socket
import struct
import sys
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sim_scenarios import archives
from sim_scenarios.archives import archive_bytes, read_archive
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import checksums, evidence, replay, verification
from sim_scenarios.exchange.verification import (
    Check,
    content_of_fmu,
    content_of_folder,
    fingerprint,
    verify,
)

MEMBERS = {"modelDescription.xml": b"<fmiModelDescription/>\n", "resources/a.txt": b"seed 7\n" * 4}


def fmu_bytes() -> bytes:
    """A small archive with its list of checksums."""
    return archive_bytes(checksums.with_list(MEMBERS, evidence.FOLDER))


@pytest.fixture
def fmu(tmp_path: Path) -> Path:
    path = tmp_path / "small.fmu"
    path.write_bytes(fmu_bytes())
    return path


def test_each_flipped_bit_of_an_fmu_is_found(fmu: Path) -> None:
    """But for those that fill up the last byte of compressed data, which mean nothing."""
    whole, members = fmu.read_bytes(), read_archive(fmu)
    assert content_of_fmu(fmu) == []
    passed = 0
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        fmu.write_bytes(changed)
        if not content_of_fmu(fmu):
            assert read_archive(fmu) == members, bit
            passed += 1
    assert passed <= 7 * len(members)


def test_an_fmu_that_is_cut_short_is_found(fmu: Path) -> None:
    whole = fmu.read_bytes()
    for length in range(len(whole)):
        fmu.write_bytes(whole[:length])
        assert content_of_fmu(fmu), length


def changed_by_hand(path: Path, members: list[tuple[str, bytes]]) -> None:
    """An archive with any names, in any order, each as `archive_bytes` packs it."""
    with zipfile.ZipFile(path, "w") as content:
        for name, member in members:
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = 0o644 << 16
            content.writestr(entry, member)


def listed_members() -> list[tuple[str, bytes]]:
    return sorted(checksums.with_list(MEMBERS, evidence.FOLDER).items())


def test_an_archive_made_by_hand_passes_if_it_is_the_same(fmu: Path) -> None:
    changed_by_hand(fmu, listed_members())
    assert fmu.read_bytes() == fmu_bytes()


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("place", [0, -1])
def test_a_member_that_is_there_twice_is_found(fmu: Path, place: int) -> None:
    """One tool takes the first, another the last."""
    members = listed_members()
    name, content = members[place]
    for twice in ([(name, b"mine"), *members], [*members, (name, content)]):
        changed_by_hand(fmu, twice)
        assert content_of_fmu(fmu) == [f"small.fmu is damaged: '{name}' is in it twice"]


def test_members_in_another_order_are_found(fmu: Path) -> None:
    changed_by_hand(fmu, listed_members()[::-1])
    assert content_of_fmu(fmu) == ["small.fmu: the zip archive has changed"]


def test_a_member_that_would_lie_outside_is_found_though_it_is_listed(fmu: Path) -> None:
    changed_by_hand(fmu, sorted(checksums.with_list({"../mine": b""}, evidence.FOLDER).items()))
    assert content_of_fmu(fmu) == ["small.fmu: the zip archive has changed"]


def test_what_hides_between_two_members_is_found(fmu: Path) -> None:
    """Compressed data says by itself where it ends; what follows is read by nobody."""
    members, hidden = listed_members(), b"mine"
    pack = zlib.compressobj(wbits=-zlib.MAX_WBITS)
    whole = bytearray(fmu_bytes())
    packed = pack.compress(members[0][1]) + pack.flush()
    end = whole.index(packed) + len(packed)
    whole[end:end] = hidden
    longer = struct.pack("<L", len(packed) + len(hidden))
    directory = whole.index(b"PK\1\2")
    for header in (18, directory + 20):  # compressed size, in both headers of the first member
        whole[header : header + 4] = longer
    for at in find_all(whole, b"PK\1\2")[1:]:  # the places of the others
        moved = struct.unpack_from("<L", whole, at + 42)[0] + len(hidden)
        struct.pack_into("<L", whole, at + 42, moved)
    struct.pack_into("<L", whole, len(whole) - 6, directory)
    fmu.write_bytes(whole)
    assert read_archive(fmu) == dict(members)
    assert content_of_fmu(fmu) == ["small.fmu: the zip archive has changed"]


def find_all(whole: bytearray, what: bytes) -> list[int]:
    return [match.start() for match in re.finditer(re.escape(what), whole)]


@pytest.mark.parametrize("line", ["0" * 64 + "  resources/a.txt\n", "\n", "nonsense\n"])
def test_a_list_that_names_a_file_twice_or_none_is_damaged(line: str) -> None:
    sums = {name: hashlib.sha256(content).hexdigest() for name, content in MEMBERS.items()}
    whole = checksums.listed(MEMBERS)
    assert checksums.differences(sums, whole.encode()) == []
    for damaged in (line + whole, whole + line):
        assert checksums.differences(sums, damaged.encode()) == ["SHA256SUMS is damaged"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A small folder with its list of checksums."""
    path = tmp_path / "export"
    for name, content in {**MEMBERS, checksums.NAME: checksums.listed(MEMBERS).encode()}.items():
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        (path / name).write_bytes(content)
    assert content_of_folder(path) == []
    return path


UNLISTED: dict[str, Callable[[Path, Path], object]] = {
    "file": lambda path, _: path.write_bytes(b""),
    "empty folder": lambda path, _: path.mkdir(),
    "link to a file": lambda path, export: path.symlink_to(export / "modelDescription.xml"),
    "link to a folder": lambda path, export: path.symlink_to(export / "resources"),
    "link to itself": lambda path, _: path.symlink_to(path),
    "broken link": lambda path, _: path.symlink_to("nowhere"),
    "pipe": lambda path, _: os.mkfifo(path),
    "socket": lambda path, _: socket.socket(socket.AF_UNIX).bind(str(path)),
}


@pytest.mark.skipif(sys.platform == "win32", reason="links and pipes of POSIX")
@pytest.mark.parametrize("kind", UNLISTED)
@pytest.mark.parametrize("name", ["mine", "resources/mine"])
def test_whatever_is_not_listed_is_found(
    folder: Path, kind: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder.parent)  # the name of a socket is short
    UNLISTED[kind](folder.relative_to(folder.parent) / name, folder)
    assert content_of_folder(folder) == [f"{name} was not exported"]


@pytest.mark.skipif(sys.platform == "win32", reason="links of POSIX")
@pytest.mark.parametrize(
    ("name", "found"), [("resources/a.txt", "has changed"), ("SHA256SUMS", "was not exported")]
)
def test_a_link_in_the_place_of_a_file_is_found(folder: Path, name: str, found: str) -> None:
    """What it points to may change after it was looked at."""
    elsewhere = folder.parent / "elsewhere"
    (folder / name).rename(elsewhere)
    (folder / name).symlink_to(elsewhere)
    assert content_of_folder(folder) == [f"{name} {found}"]


SLY = [
    "\x1b[2J",
    "\x1b]0;mine\x07",
    "a\nholds  b",
    "a\rb",
    "\x9b2J",
    "\u202etxt.exe",
    "a\tb",
    ":skull:",
    "[red]a",
]


@pytest.mark.skipif(sys.platform == "win32", reason="names that Windows has not")
@pytest.mark.parametrize("name", SLY)
def test_no_name_of_a_file_commands_the_terminal(folder: Path, name: str) -> None:
    """Nor does it look like a line, or a name, that is not there."""
    (folder / name).write_bytes(b"")
    page = CliRunner().invoke(app, ["verify", str(folder)], env={"FORCE_COLOR": None}).output
    assert len(page.splitlines()) == 5, page
    assert all(one.isprintable() for line in page.splitlines() for one in line), page
    assert f"{ascii(name)[1:-1]} was not exported" in page


@pytest.mark.parametrize("size", [2**31, 2**32 - 1])
def test_an_archive_that_says_it_is_too_large_is_not_unpacked(fmu: Path, size: int) -> None:
    whole = bytearray(fmu.read_bytes())
    struct.pack_into("<L", whole, whole.index(b"PK\1\2") + 24, size)
    fmu.write_bytes(whole)
    (found,) = content_of_fmu(fmu)
    assert re.fullmatch(rf"small\.fmu is damaged: unpacked it has \d+ bytes: must be at most {2**31}", found)


def test_an_archive_that_says_too_little_is_found(fmu: Path) -> None:
    whole = bytearray(fmu.read_bytes())
    for header in (22, whole.index(b"PK\1\2") + 24):
        struct.pack_into("<L", whole, header, 1)
    fmu.write_bytes(whole)
    assert content_of_fmu(fmu)


def test_a_large_member_is_looked_at_piece_by_piece(fmu: Path) -> None:
    """64 MB of zeros in 64 kB."""
    fmu.write_bytes(archive_bytes(checksums.with_list({"zeros": bytes(2**26)}, evidence.FOLDER)))
    tracemalloc.start()
    try:
        assert content_of_fmu(fmu) == []
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 2**24


def test_no_archive_is_written_that_would_be_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archives, "LARGEST", 30)
    assert archive_bytes({"a": b"0" * 10, "b": "0" * 20})
    with pytest.raises(InputError, match="2 members of an archive have 31 bytes: must be at most 30"):
        archive_bytes({"a": b"0" * 10, "b": "0" * 21})


NONSENSE = [
    {},
    {"modelDescription.xml": b"<"},
    {"modelDescription.xml": b"<fmiModelDescription/>", f"{replay.FOLDER}/experiments.xml": b"<"},
    {f"{replay.FOLDER}/experiments.xml": b"<Experiments/>"},
    {f"{replay.FOLDER}/experiments.xml": b"<Experiments><Experiment stopTime='x'/></Experiments>"},
]


@pytest.mark.parametrize("members", NONSENSE)
def test_nonsense_with_a_right_list_does_not_hold(folder: Path, members: dict[str, bytes]) -> None:
    files = {
        "mine.fmu": archive_bytes(checksums.with_list(members, evidence.FOLDER)),
        "mine.ssp": archive_bytes({"SystemStructure.ssd": b"<"}),
        "other.ssp": b"PK",
    }
    listed = checksums.listed({**MEMBERS, **files})
    for name, content in {**files, checksums.NAME: listed.encode()}.items():
        (folder / name).write_bytes(content)
    for path in (folder, folder / "mine.fmu"):
        content, *looks = verify(path)
        assert content.holds
        assert looks
        assert not any(look.holds for look in looks)
        assert all(look.findings for look in looks)


# ------------------------------------------------------------------ whose it is


@pytest.fixture
def ran(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """FMUs that would have been run, of which there is one in the folder now."""
    files = {**MEMBERS, "mine.fmu": fmu_bytes()}
    (folder / "mine.fmu").write_bytes(files["mine.fmu"])
    (folder / checksums.NAME).write_text(checksums.listed(files))
    paths: list[Path] = []

    def note(path: Path) -> Check:
        paths.append(path)
        return Check("noted", True, [])

    monkeypatch.setattr(verification, "_repeated", note)
    monkeypatch.setattr(verification, "_valid", lambda _: Check("valid", True, []))
    return paths


def printed(folder: Path, *options: str) -> tuple[int, str]:
    """Exit code and page of the command."""
    result = CliRunner().invoke(app, ["verify", str(folder), *options])
    return result.exit_code, result.output


def test_nobody_vouches_for_a_list_that_was_not_told(folder: Path, ran: list[Path]) -> None:
    """Whoever changes the content can change the list with it."""
    code, page = printed(folder)
    assert code == 0
    told = hashlib.sha256((folder / checksums.NAME).read_bytes()).hexdigest()
    assert f"SHA-256 of the list: {told}" in page
    assert "nobody vouches for its origin" in page
    assert ran == [folder / "mine.fmu"]


@pytest.mark.parametrize("of_the_fmu", [False, True])
def test_nothing_is_run_whose_list_is_another_one(folder: Path, ran: list[Path], of_the_fmu: bool) -> None:
    path = folder / "mine.fmu" if of_the_fmu else folder
    told = fingerprint(path)
    code, page = printed(path, "--expect", told.upper())
    assert (code, ran) == (0, [folder / "mine.fmu"])
    assert "holds  The list of checksums is the one that was told" in page
    assert "nobody vouches" not in page
    ran.clear()
    for digit in range(64):
        other = told[:digit] + ("0" if told[digit] != "0" else "1") + told[digit + 1 :]
        checks = verify(path, expect=other)
        assert [check.holds for check in checks] == [True, False, False]
        assert checks[1].findings == [f"the SHA-256 of the list must be {other}"]
    assert printed(path, "--expect", "0" * 64)[0] == 1
    assert ran == []


@pytest.mark.parametrize("told", ["", "0" * 63, "0" * 65, "g" * 64, "0" * 64 + "\n"])
def test_what_is_no_sha_256_is_refused(folder: Path, told: str) -> None:
    with pytest.raises(InputError, match="must have 64 hexadecimal digits"):
        verify(folder, expect=told)


def test_nothing_is_run_if_nothing_shall_be(folder: Path, ran: list[Path]) -> None:
    code, page = printed(folder, "--no-run")
    assert (code, ran) == (0, [])
    assert "All of it holds; nothing was run" in page


@pytest.mark.skipif(sys.platform == "win32", reason="links of POSIX")
def test_what_is_as_it_was_exported(folder: Path) -> None:
    """No name leads out of the folder, not even one that its list has."""
    outside = folder.parent / "outside"
    outside.write_bytes(b"")
    (folder / "link").symlink_to(outside)
    files = {**MEMBERS, "../outside": b"", "link": b"", "changed": b"before", "gone": b""}
    (folder / "changed").write_bytes(b"after")
    (folder / checksums.NAME).write_text(checksums.listed(files))
    assert checksums.unchanged(folder) == sorted(MEMBERS)
    (folder / checksums.NAME).unlink()
    assert checksums.unchanged(folder) == []
