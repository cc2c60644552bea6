"""Folders: filled wholly or not at all, and removed with their process however it ends."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from sim_scenarios import folders
from sim_scenarios.errors import InputError
from sim_scenarios.folders import CONTENTS, DRAFT, TEMPORARY, Owned, discard, filled, reserved

OWNER = """
    import sys, time
    from pathlib import Path
    from sim_scenarios.folders import {made}
    folder = {made}({arguments})
    print(getattr(folder, "path", folder), flush=True)
    (getattr(folder, "path", folder) / "large").write_bytes(bytes(1000))
    sys.stdin.read() if {waits} else None
"""


IS_ROOT = hasattr(os, "geteuid") and os.geteuid() == 0


def owner(made: str, arguments: str = "", waits: bool = True) -> subprocess.Popen[str]:
    """A process with a folder, that lives until its standard input ends."""
    code = textwrap.dedent(OWNER.format(made=made, arguments=arguments, waits=waits))
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-c", code], stdin=pipe, stdout=pipe, text=True)


def line(process: subprocess.Popen[str]) -> Path:
    assert process.stdout is not None
    return Path(process.stdout.readline().strip())


def test_the_next_one_removes_what_a_killed_process_left(tmp_path: Path) -> None:
    with owner("Owned", f"Path({str(tmp_path)!r}), 'x-'") as process:
        folder = line(process)
        Owned(tmp_path, "x-").remove()
        assert folder.is_dir()  # it lives
        process.kill()
    assert folder.is_dir()
    Owned(tmp_path, "x-").remove()
    assert list(tmp_path.iterdir()) == []


def test_a_process_removes_its_temporary_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with owner("temporary", waits=False) as process:
        folder = line(process)
        assert folder.name.startswith(TEMPORARY)
        assert folder.parent == tmp_path
        process.communicate(timeout=60)
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_a_folder_of_this_module_stays(tmp_path: Path) -> None:
    """A folder of the user's with such a name, a link, a file; and one that is being made."""
    old = time.time() - 1000
    (tmp_path / "x-results").mkdir()
    (tmp_path / "x-results" / "report.html").touch()
    os.utime(tmp_path / "x-results", (old, old))
    (tmp_path / "x-file").touch()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / folders._LOCK).write_text("locked")
    (tmp_path / "x-link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "x-newborn").mkdir()
    before = sorted(tmp_path.rglob("*"))
    Owned(tmp_path, "x-").remove()
    assert sorted(tmp_path.rglob("*")) == before


def test_a_folder_that_was_never_locked_is_removed_when_it_is_old(tmp_path: Path) -> None:
    (tmp_path / "x-1").mkdir()
    (tmp_path / "x-2").mkdir()
    (tmp_path / "x-2" / folders._LOCK).touch()
    for folder in tmp_path.iterdir():
        os.utime(folder, (time.time() - 1000,) * 2)
    Owned(tmp_path, "x-").remove()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not IS_ROOT, reason="needs root: a folder of another user")
def test_a_folder_of_another_user_stays(tmp_path: Path) -> None:
    theirs = Owned(tmp_path, "x-")
    theirs._lock.close()  # type: ignore[union-attr]
    os.chown(theirs.path, 65534, 65534)
    Owned(tmp_path, "x-").remove()
    assert theirs.path.is_dir()


@pytest.mark.parametrize("there", [False, True])
def test_a_folder_is_filled_at_the_end(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "a" / "b" if not there else tmp_path
    with filled(folder) as draft:
        (draft / "below").mkdir()
        (draft / "below" / "file").write_text("new")
        assert not (folder / "below").exists()
    assert (folder / "below" / "file").read_text() == "new"
    assert not list(tmp_path.rglob(f"{DRAFT}*"))
    if hasattr(os, "umask"):
        mask = os.umask(0)
        os.umask(mask)
        assert (folder / "below").stat().st_mode & 0o777 == 0o777 & ~mask
        assert there or folder.stat().st_mode & 0o777 == 0o777 & ~mask


def test_files_of_the_same_name_are_replaced_and_others_stay(tmp_path: Path) -> None:
    (tmp_path / "one").write_text("old")
    (tmp_path / "two").write_text("old")
    with filled(tmp_path) as draft:
        (draft / "one").write_text("new")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"one": "new", "two": "old"}


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_nothing_is_filled_at_an_exception(tmp_path: Path, error: type[BaseException], there: bool) -> None:
    folder = tmp_path / "folder"
    if there:
        folder.mkdir()
        (folder / "one").write_text("old")
    before = [(path, path.is_file() and path.read_text()) for path in sorted(tmp_path.rglob("*"))]
    with pytest.raises(error), filled(folder) as draft:  # noqa: PT012
        (draft / "one").write_text("new")
        raise error
    assert [(path, path.is_file() and path.read_text()) for path in sorted(tmp_path.rglob("*"))] == before


def contents(folder: Path) -> dict[str, str]:
    """Text of every file but the list, by its path."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != CONTENTS)
    return {path.relative_to(folder).as_posix(): path.read_text() for path in files}


def fill(folder: Path, text: str, *names: str) -> None:
    with filled(folder, anew=True) as draft:
        for name in names:
            (draft / name).parent.mkdir(parents=True, exist_ok=True)
            (draft / name).write_text(text)


def test_what_a_command_wrote_goes_with_the_next_one(tmp_path: Path) -> None:
    """But nothing else: the user's files, and what was filled in without being listed, stay."""
    folder = tmp_path / "results"
    fill(folder, "first", "report.html", "heading.png", "below/deep/one", "below/two")
    (folder / "notes.txt").write_text("mine")
    with filled(folder) as draft:
        (draft / "runs").write_text("kept")
    fill(folder, "second", "report.html", "below/two")
    stay = {"notes.txt": "mine", "runs": "kept"}
    assert contents(folder) == {"report.html": "second", "below/two": "second", **stay}
    fill(folder, "third", "report.html")
    assert contents(folder) == {"report.html": "third", **stay}
    assert not (folder / "below").exists()


@pytest.mark.parametrize("name", ["../mine", "/etc/hostname", "link/mine", "", ".", "\0", "\udcff"])
def test_a_list_that_was_tampered_with_removes_nothing_elsewhere(tmp_path: Path, name: str) -> None:
    folder = tmp_path / "results"
    fill(folder, "first", "report.html")
    (tmp_path / "mine").write_text("mine")
    (folder / "link").symlink_to(tmp_path)
    (folder / CONTENTS).write_text(f"{name}\n", errors="surrogateescape")
    fill(folder, "second", "report.html")
    assert (tmp_path / "mine").read_text() == "mine"
    assert (folder / "report.html").read_text() == "second"


@pytest.mark.parametrize("done", [False, True])
@pytest.mark.parametrize("call", range(1, 8))
def test_a_folder_is_never_half_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int, done: bool
) -> None:
    """An interruption at each file that changes its place, before it has done so and after."""
    names = ["a", "b/c", "b/d", "e"]
    fill(tmp_path, "old", *names)
    (tmp_path / CONTENTS).write_text("a\nb/c\n")  # the others are in the way
    replace, calls = Path.replace, 0

    def interrupted(source: Path, target: Path) -> Path:
        nonlocal calls
        calls += 1
        if calls == call and not done:
            raise KeyboardInterrupt
        moved = replace(source, target)
        if calls == call:
            raise KeyboardInterrupt
        return moved

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fill(tmp_path, "new", *names)
    assert contents(tmp_path) == dict.fromkeys(names, "old")


def test_a_file_in_the_place_of_a_folder_is_refused(tmp_path: Path) -> None:
    fill(tmp_path, "old", "a", "b/c")
    (tmp_path / "d").write_text("mine")
    with pytest.raises(OSError, match="b"):
        fill(tmp_path, "new", "a", "b")
    assert contents(tmp_path) == {"a": "old", "b/c": "old", "d": "mine"}


def test_what_is_discarded_is_gone(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    discard(tmp_path / "a")
    discard(tmp_path / "a")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_reserved_by_one_process_for_one_thing(tmp_path: Path) -> None:
    """Until it ends, however it does."""
    code = """
        import sys
        from pathlib import Path
        from sim_scenarios.folders import reserved
        with reserved(Path(sys.argv[1]), "campaign"):
            print("reserved", flush=True)
            sys.stdin.read()
    """
    pipe, folder = subprocess.PIPE, tmp_path / "new"
    command = [sys.executable, "-c", textwrap.dedent(code), str(folder)]
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        assert line(process).name == "reserved"
        with (
            pytest.raises(InputError, match="new: another campaign is at work in it"),
            reserved(folder, "campaign"),
        ):
            pass
        with reserved(folder, "paper"):
            pass
        process.kill()
    for _ in range(2):
        with reserved(folder, "campaign"):
            pass


def test_a_file_system_without_locks_does_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def lock(_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(folders, "_lock", lock)
    with reserved(tmp_path, "campaign"):
        pass


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="links are followed here")
def test_a_link_in_the_place_of_a_lock_is_not_followed(tmp_path: Path) -> None:
    """Whoever may write into a folder would otherwise choose which file of another user is emptied."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / ".truenorth-campaign").symlink_to(victim)
    with pytest.raises(InputError, match="cannot be locked"), reserved(tmp_path, "campaign"):
        pass
    assert victim.read_text() == "precious"
