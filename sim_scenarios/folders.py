"""Folders that are filled wholly or not at all, and folders that do not outlive their process.

Whoever makes such a folder holds a lock on a file in it. The system lets go of the lock when the process
ends, however it ends; so a folder whose lock can be had is one that a killed process left, and the next one
that works in the same place removes it. (The number of a process would not do: it may be given anew, and
another container may know it as something else.)
"""

from __future__ import annotations

import atexit
import errno
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO, Final

from sim_scenarios.errors import InputError, NoRoomError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

TEMPORARY: Final = "truenorth-tmp-"
DRAFT: Final = ".truenorth-draft-"
"""Beginnings of the names of folders that are removed."""

CONTENTS: Final = ".truenorth-files"
"""File of a folder that lists those beside and below it that a command wrote."""

SEMAPHORES: Final = Path("/dev/shm")
"""Where Linux keeps them. Those that are named after a folder of this module are removed with it."""

_LOCK: Final = ".lock"
_TAKEN: Final = (errno.EAGAIN, errno.EACCES)
"""Why a lock cannot be had that another process has."""
_NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT)
_NEWBORN: Final = 60.0
"""How long a folder may be made without being locked yet [s]."""


class Owned:
    """A folder of this process, until it is removed or the process ends.

    Parameters
    ----------
    parent : Path
        Where it is made; what killed processes of this user left there is removed.
    prefix : str
        Beginning of its name.
    """

    def __init__(self, parent: Path, prefix: str) -> None:
        _sweep(parent, prefix)
        self.path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
        self._lock: IO[bytes] | None = None
        try:
            self._lock = (self.path / _LOCK).open("wb")
            _try_lock(self._lock)
            self._lock.write(b"locked\n")
            self._lock.flush()
        except BaseException:
            self.remove()
            raise

    def remove(self) -> None:
        """Remove the folder with all that is in it, the lock last."""
        for entry in self.path.glob("*"):
            remove(entry)
        if self._lock:
            self._lock.close()
        remove(self.path)


@contextmanager
def filled(folder: Path, anew: bool = False) -> Iterator[Path]:
    """A draft of a folder: what is written into it is in the folder at the end, or nowhere at an exception.

    Files of the same names are replaced, each as a whole; others stay. When the disk is full or the process
    is interrupted, even while files change places, the folder holds what it held before; so it does when the
    process is killed, but for that moment.

    Parameters
    ----------
    folder : Path
        It need not exist.
    anew : bool
        Whether the files go that the last filling anew put there; which these are stands in `CONTENTS`.
    """
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    draft = Owned(existing, DRAFT)
    try:
        content, aside = draft.path / "content", draft.path / "aside"
        content.mkdir()
        aside.mkdir()
        yield content
        earlier = _listed(folder) if anew else []
        if anew:
            _list(content)
        _exchange(content, folder, earlier, aside)
        if anew:
            _prune(folder, earlier)
    finally:
        draft.remove()


@contextmanager
def reserved(folder: Path, what: str) -> Iterator[None]:
    """A folder, made if it is missing, in which no other process has reserved the same thing meanwhile.

    Raises
    ------
    InputError
        Another one has; `what` says what both want to do there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with _opened(folder / f".truenorth-{what}") as lock:
        try:
            _lock(lock)
        except OSError as error:  # of another kind: the file system has no locks
            if error.errno in _TAKEN:
                raise InputError(f"{folder}: another {what} is at work in it") from None
        yield


def _opened(lock: Path) -> IO[bytes]:
    """A file to be locked; nothing of it changes, and what only leads to another file is none."""
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    try:
        return os.fdopen(os.open(lock, flags, 0o600), "r+b")
    except OSError as error:
        raise InputError(f"{lock}: cannot be locked: {error.strerror}") from None


@cache
def temporary() -> Path:
    """The folder of this process for what it needs while it lives; removed at its end."""
    if _shared is not None:
        return _shared
    try:
        place = Path(tempfile.gettempdir())
    except FileNotFoundError as error:  # it has tried several
        raise NoRoomError(f"{error.strerror}; TMPDIR names another folder") from None
    with _named(place):
        owned = Owned(place, TEMPORARY)
    atexit.register(owned.remove)
    return owned.path


@contextmanager
def filling_temporary() -> Iterator[None]:
    """Say of what has no room meanwhile that it is a temporary file.

    Raises
    ------
    NoRoomError
    """
    with _named(temporary().parent):
        yield


@contextmanager
def _named(place: Path) -> Iterator[None]:
    """Say which folder is full; the system does not, of files that grow."""
    try:
        yield
    except OSError as error:
        if error.errno not in _NO_ROOM:
            raise
        sentence = f"{place}: {error.strerror}; temporary files go there, and TMPDIR names another folder"
        raise NoRoomError(sentence) from None


def share(folder: Path) -> None:
    """Put all temporary files of this process into the folder of the process that has started it."""
    global _shared
    _shared = folder
    tempfile.tempdir = str(folder)


_shared: Path | None = None


def remove(path: Path) -> None:
    """Remove a file or a folder, as far as that is possible."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()


def discard(path: Path) -> None:
    """Remove a folder or a file: it disappears as a whole, however long its removal takes."""
    if path.exists():
        grave = Owned(path.parent, DRAFT)
        path.replace(grave.path / path.name)
        grave.remove()


def _exchange(content: Path, folder: Path, earlier: list[Path], aside: Path) -> None:
    """Put content in its place and what is in its way aside, with earlier files; at an exception nothing."""
    moves: list[tuple[Path, Path]] = []

    def move(source: Path, target: Path) -> None:
        moves.append((source, target))  # first: an interruption may come between
        source.replace(target)

    def put(source: Path, target: Path) -> None:
        if source.is_dir() and target.is_dir():
            for entry in sorted(source.iterdir()):
                put(entry, target / entry.name)
            return
        if os.path.lexists(target) and not target.is_dir():
            move(target, aside / str(len(moves)))
        move(source, target)

    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        for path in earlier:
            move(path, aside / str(len(moves)))
        put(content, folder)
    except BaseException:
        for source, target in reversed(moves):
            if not os.path.lexists(source):
                target.replace(source)
        raise


def _list(content: Path) -> None:
    """Write into a draft which files it has."""
    names = sorted(path.relative_to(content).as_posix() for path in content.rglob("*") if path.is_file())
    (content / CONTENTS).write_text("".join(f"{name}\n" for name in names), encoding="utf-8")


def _listed(folder: Path) -> list[Path]:
    """Files that the list of a folder names, as far as they are there and in it."""
    try:
        names = (folder / CONTENTS).read_text(encoding="utf-8").splitlines()
        root = folder.resolve()
        paths = [folder / name for name in names]
        return [path for path in paths if path.is_file() and root in path.resolve().parents]
    except (OSError, ValueError):  # there is none, or one that nobody here wrote
        return []


def _prune(folder: Path, earlier: list[Path]) -> None:
    """Remove the folders that are empty without earlier files."""
    for path in earlier:
        for parent in path.relative_to(folder).parents[:-1]:
            with suppress(OSError):  # it is not empty, or gone
                (folder / parent).rmdir()


def _sweep(parent: Path, prefix: str) -> None:
    """Remove what killed processes of this user left."""
    for folder in parent.glob(f"{prefix}*"):
        with suppress(OSError):
            if _is_own(folder) and _is_left(folder):
                for semaphore in SEMAPHORES.glob(f"sem.{folder.name}-*"):
                    remove(semaphore)
                remove(folder)


def _is_own(folder: Path) -> bool:
    about = folder.lstat()
    return stat.S_ISDIR(about.st_mode) and (sys.platform == "win32" or about.st_uid == os.getuid())


def _is_left(folder: Path) -> bool:
    """Whether no process has the folder, and this module made it."""
    lock = folder / _LOCK
    if not lock.exists() or lock.stat().st_size == 0:
        newborn = time.time() - folder.lstat().st_mtime < _NEWBORN
        return not newborn and all(path == lock for path in folder.iterdir())
    with lock.open("r+b") as file:
        return _try_lock(file)


def _try_lock(lock: IO[bytes]) -> bool:
    """Lock a file until it is closed; whether that was possible."""
    try:
        _lock(lock)
    except OSError:
        return False
    return True


def _lock(lock: IO[bytes]) -> None:
    """Lock a file until it is closed, or raise."""
    if sys.platform == "win32":
        msvcrt.locking(lock.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
