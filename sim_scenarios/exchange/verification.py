"""Whether an export, or an FMU of one, is what was written, valid, and still gives its reference results."""

from __future__ import annotations

import errno
import hashlib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import gettempdir
from typing import Final

import fmpy
from fmpy.validation import validate_fmu
from lxml import etree

from sim_scenarios.archives import is_as_written, read_archive
from sim_scenarios.errors import InputError, NoRoomError
from sim_scenarios.exchange import checksums, replay, signature
from sim_scenarios.exchange.evidence import FOLDER

LIST = f"{FOLDER}/{checksums.NAME}"
"""The list of checksums in an FMU."""
SIGNATURE = f"{FOLDER}/{checksums.SIGNATURE}"
"""Its signature."""
TOLD = "The list of checksums is the one that was told"
SIGNED = "The list of checksums is signed with the key that was given"
NOT_RUN = "The FMUs were not run"
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
KINDS = {".ssd": "Description", ".ssv": "ParameterValues"}
"""Documents of a system that have a schema, by the ends of their names."""
TOLERANCE = 1e-9
"""Largest difference from the reference, of the largest value of each output."""
_SHA256 = re.compile(r"[0-9a-fA-F]{64}")

_NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EMFILE)
"""What keeps this machine from looking at a part."""


@dataclass(frozen=True)
class Check:
    """One thing that was looked at.

    Attributes
    ----------
    what : str
        Claim.
    holds : bool
    findings : list of str
        What does not hold, or how well it does.
    """

    what: str
    holds: bool
    findings: list[str]


def verify(
    path: Path, *, expect: str | None = None, signed_by: Path | None = None, run: bool = True
) -> list[Check]:
    """Look at a folder that `truenorth export` wrote, or at one FMU of it.

    Parameters
    ----------
    path : Path
        Folder or FMU.
    expect : str, optional
        SHA-256 of the list of checksums, as it was told by another way than the export came. Whoever can
        change the export can change the list in it as well.
    signed_by : Path, optional
        PEM file of the public key of Ed25519 that the signature of the list must belong to.
    run : bool
        Whether the reference results are repeated. It runs what is in the FMUs, with the rights of the user.

    Returns
    -------
    list of Check
        Nothing is run whose content does not fit its list, or whose list is not the expected or a signed one.

    Raises
    ------
    InputError
        The path, or what is expected, is not what it should be.
    """
    if expect is not None and not _SHA256.fullmatch(expect):
        raise InputError(f"{expect!a} is no SHA-256: must have 64 hexadecimal digits")
    is_signed = signature.signed_by(signed_by) if signed_by else None
    if path.is_dir():
        contents = content_of_folder(path)
        archives = sorted(path.rglob("*.fmu"))
        systems = sorted(path.glob("*.ssp"))
    elif path.is_file():
        contents, archives, systems = content_of_fmu(path), [path], []
    else:
        raise InputError(f"{path} is neither a folder nor a file")
    fits = "The content fits its own list of checksums"
    if contents:
        return [Check(fits, False, contents), Check(NOT_RUN, False, ["the content has changed"])]
    listed, signed = _vouched(path)
    found = _sha256(listed)
    checks = [Check(fits, True, [f"SHA-256 of the list: {found}"])]
    if expect is None and signed_by is None:
        checks[0].findings.append(
            "nobody vouches for its origin: neither a SHA-256 nor a public key was given"
            + (", and the signature was not looked at" if signed else "")
        )
    if expect is not None:
        told = found == expect.lower()
        checks.append(
            Check(TOLD, told, [] if told else [f"the SHA-256 of the list must be {expect.lower()}"])
        )
    if is_signed is not None:
        wrong = "it has no signature" if not signed else f"it is not signed with the key of {signed_by}"
        checks.append(Check(SIGNED, holds := is_signed(listed, signed), [] if holds else [wrong]))
    if not all(check.holds for check in checks):
        return [*checks, Check(NOT_RUN, False, ["the list is another one"])]
    looks = [(_valid, archives), (_described, systems), (_repeated, archives if run else [])]
    return [*checks, *(_looked_at(look, part) for look, parts in looks for part in parts)]


def fingerprint(path: Path) -> str:
    """SHA-256 of the list of checksums in a folder or an FMU: to be told by another way than these come."""
    return _sha256(_vouched(path)[0])


def content_of_folder(folder: Path) -> list[str]:
    """Differences from the list of checksums in a folder."""
    listed = folder / checksums.NAME
    if not listed.is_file():
        raise InputError(f"{listed} is missing; {folder} is not from `truenorth export`")
    different = checksums.differences(checksums.of_folder(folder), listed.read_bytes())
    return [*different, *_unfit(_vouched(folder)[1])]


def content_of_fmu(archive: Path) -> list[str]:
    """Differences from the list of checksums in an FMU."""
    try:
        found = checksums.of_archive(archive)
        listed, signed = _vouched(archive)
        as_written = is_as_written(archive)
    except InputError as error:
        return [str(error)]
    if found.pop(LIST, None) is None:
        return [f"{archive.name} has no {LIST}; it is damaged, or not from `truenorth export`"]
    found.pop(SIGNATURE, None)
    different = [*checksums.differences(found, listed), *_unfit(signed)]
    return different if as_written else [*different, f"{archive.name}: the zip archive has changed"]


def _vouched(path: Path) -> tuple[bytes, bytes]:
    """The list of checksums of a folder or an FMU, and its signature; empty where there is none."""
    if path.is_dir():
        files = (path / checksums.NAME, path / checksums.SIGNATURE)
        listed, signed = (file.read_bytes() if file.is_file() else b"" for file in files)
        return listed, signed
    members = read_archive(path, lambda name: name in (LIST, SIGNATURE))
    return members.get(LIST, b""), members.get(SIGNATURE, b"")


def _unfit(signed: bytes) -> list[str]:
    """What is wrong with a signature, whoever made it."""
    fits = len(signed) in (0, signature.SIZE)
    return [] if fits else [f"{checksums.SIGNATURE} is damaged"]


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _looked_at(look: Callable[[Path], Check], part: Path) -> Check:
    """A look at an FMU or a system; what is listed may be nonsense all the same."""
    try:
        return look(part)
    except NoRoomError:
        raise
    except Exception as error:  # whatever zip, XML, CSV, FMPy and the FMU raise
        if isinstance(error, OSError) and error.errno in _NO_ROOM:  # which says nothing of the part
            raise InputError(
                f"{part.name}: cannot be unpacked into {gettempdir()}: {error.strerror}"
            ) from None
        return Check(f"{_named(part)} can be read and run", False, [f"{type(error).__name__}: {error}"])


def _valid(archive: Path) -> Check:
    """FMPy's checks of an FMU: schema and rules of the standard."""
    problems = [str(problem) for problem in validate_fmu(str(archive))]
    return Check(f"{_named(archive)} is valid", not problems, problems)


def _described(archive: Path) -> Check:
    """Description and parameters of a system; FMPy has the schemas of SSP 1.0 alone."""
    documents = list(_documents(archive))
    if any(document.get("version") != "1.0" for _, _, document in documents):
        version = documents[0][2].get("version")
        return Check(f"{archive.name} is well-formed", True, [f"no schema of SSP {version} is at hand"])
    problems = []
    for name, kind, document in documents:
        schema = etree.XMLSchema(etree.parse(SCHEMAS / f"SystemStructure{kind}.xsd"))
        schema.validate(document)
        problems += [f"{name}: {error.message}" for error in schema.error_log]
    return Check(f"{archive.name} is valid", not problems, problems)


def _documents(archive: Path) -> Iterator[tuple[str, str, etree._Element]]:
    for name, content in read_archive(archive, lambda name: Path(name).suffix in KINDS).items():
        yield name, KINDS[Path(name).suffix], etree.fromstring(content)


def _repeated(archive: Path) -> Check:
    """The reference experiment of an FMU, run here."""
    members = read_archive(archive, lambda name: name.startswith(f"{replay.FOLDER}/"))
    experiment = replay.experiment(members)
    found = replay.difference(archive, experiment)
    outcome = "equal" if found == 0 else f"largest difference {found:.1e}, limit {TOLERANCE:g}"
    return Check(f"{_named(archive)} repeats its reference results", found <= TOLERANCE, [outcome])


def _named(archive: Path) -> str:
    return f"{archive.parent.name}/{archive.name}"
