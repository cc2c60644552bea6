"""`truenorth verify`: what holds of an export, and that no change passes."""

from __future__ import annotations

import errno
import json
import random
import shutil
import subprocess
from pathlib import Path

import pytest
from archives import FMUS
from cryptography.hazmat.primitives import serialization as pem
from cryptography.hazmat.primitives.asymmetric import ed25519
from typer.testing import CliRunner

from sim_scenarios.archives import archive_bytes, read_archive
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import checksums, evidence, export, replay, verification
from sim_scenarios.exchange.verification import content_of_fmu, verify
from sim_scenarios.fmus import Fmu, Fmus

SHORT = {"duration": 5.0, "evaluation.start": 1.0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export")
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    export("swaying_ship", path, set=SHORT, fmus=fmus)
    return path


def verified(path: Path) -> tuple[int, list[dict[str, object]]]:
    """Exit code and checks of the command."""
    result = CliRunner().invoke(app, ["verify", str(path), "--json"])
    return result.exit_code, json.loads(result.output)["checks"]


def test_an_untouched_folder_holds(folder: Path) -> None:
    code, checks = verified(folder)
    assert code == 0, checks
    repeated = [check for check in checks if "repeats its reference results" in str(check["what"])]
    assert len(repeated) == 4
    assert all(check["findings"] == ["equal"] for check in repeated)
    page = CliRunner().invoke(app, ["verify", str(folder)]).output
    assert "All of it holds" in page
    assert len(page.splitlines()) < 40


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_an_untouched_fmu_holds(folder: Path, version: str) -> None:
    code, checks = verified(folder / version / "AlignmentFilter.fmu")
    assert code == 0, checks


def test_sha256sum_reads_the_list(folder: Path) -> None:
    subprocess.run(["sha256sum", "--check", "--strict", "--quiet", "SHA256SUMS"], cwd=folder, check=True)


def flipped(content: bytes, dice: random.Random) -> bytes:
    """One bit of a file changed."""
    changed = bytearray(content)
    changed[dice.randrange(len(changed))] ^= 1 << dice.randrange(8)
    return bytes(changed)


def test_any_flipped_bit_of_a_folder_is_found(folder: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(folder, tmp_path / "copy")
    files = sorted(path for path in copy.rglob("*") if path.is_file())
    dice = random.Random(1)
    for number in range(200):
        path = files[number % len(files)] if number < 2 * len(files) else dice.choice(files)
        before = path.read_bytes()
        path.write_bytes(flipped(before, dice))
        checks = verify(copy)
        assert not checks[0].holds, (path, number)
        assert checks[0].findings
        assert "not run" in checks[1].what
        path.write_bytes(before)
    assert verify(copy)[0].holds


def test_any_flipped_bit_of_an_fmu_is_found_or_changes_nothing_that_is_read(
    folder: Path, tmp_path: Path
) -> None:
    """Compressed data has bits that mean nothing: a member that reads back the same is the same."""
    untouched = (folder / "fmi2" / "TruthPlant.fmu").read_bytes()
    members = read_archive(folder / "fmi2" / "TruthPlant.fmu")
    dice, path = random.Random(2), tmp_path / "TruthPlant.fmu"
    for number in range(200):
        content = bytearray(untouched)
        # every other one in the headers at the end of the archive
        place = dice.randrange(len(content)) if number % 2 else len(content) - 1 - dice.randrange(2000)
        content[place] ^= 1 << dice.randrange(8)
        path.write_bytes(content)
        if not content_of_fmu(path):
            assert read_archive(path) == members, place


def test_a_start_value_that_was_changed_with_care_is_found_by_the_fmu_itself(
    folder: Path, tmp_path: Path
) -> None:
    """With all checksums put right, but for the mark in modelDescription.xml."""
    members = read_archive(folder / "fmi2" / "AlignmentFilter.fmu")
    members["resources/start_values.txt"] = members["resources/start_values.txt"].replace(b"0", b"1", 1)
    del members[f"{evidence.FOLDER}/{checksums.NAME}"]
    path = tmp_path / "AlignmentFilter.fmu"
    path.write_bytes(archive_bytes(checksums.with_list(members, evidence.FOLDER)))
    with pytest.raises(Exception, match="nstantiat"):
        replay.difference(path, replay.experiment(members))


@pytest.mark.parametrize("what", ["nowhere", "empty"])
def test_what_is_no_export_is_bad_input(tmp_path: Path, what: str) -> None:
    (tmp_path / "empty").mkdir()
    assert CliRunner().invoke(app, ["verify", str(tmp_path / what)]).exit_code == 2


def test_an_export_takes_the_place_of_an_earlier_one(folder: Path, tmp_path: Path) -> None:
    """What is there besides, or was changed, is somebody's: it stays, and is found."""
    copy = shutil.copytree(folder, tmp_path / "copy")
    for name in ("fmi2/OldFilter.fmu", "parameters/of/old.ssv", "changed.txt"):
        (copy / name).parent.mkdir(exist_ok=True)
        (copy / name).write_text("old")
    files = {path.relative_to(copy).as_posix(): path for path in copy.rglob("*") if path.is_file()}
    del files[checksums.NAME]
    listed = checksums.listed({name: path.read_bytes() for name, path in files.items()})
    (copy / checksums.NAME).write_text(listed)
    (copy / "changed.txt").write_text("mine")
    (copy / "notes.txt").write_text("mine")
    fmus = Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})
    export("swaying_ship", copy, set=SHORT, fmus=fmus)
    assert sorted(verify(copy, run=False)[0].findings) == [
        "changed.txt was not exported",
        "notes.txt was not exported",
    ]
    (copy / "changed.txt").unlink()
    (copy / "notes.txt").unlink()
    assert verify(copy, run=False)[0].holds


def test_a_signed_export_is_known_by_its_key(tmp_path: Path) -> None:
    key = ed25519.Ed25519PrivateKey.generate()
    private, public, folder = tmp_path / "key.pem", tmp_path / "public.pem", tmp_path / "export"
    private.write_bytes(key.private_bytes(pem.Encoding.PEM, pem.PrivateFormat.PKCS8, pem.NoEncryption()))
    public.write_bytes(key.public_key().public_bytes(pem.Encoding.PEM, pem.PublicFormat.SubjectPublicKeyInfo))
    short = [f"--set={name}={value}" for name, value in SHORT.items()]
    command = ["export", "swaying_ship", "--output", str(folder), *short]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TRUENORTH_FMUS", str(FMUS))
        for options, signed in ((["--sign", str(private)], True), ([], False)):
            result = CliRunner().invoke(app, [*command, *options])
            assert result.exit_code == 0, result.output
            assert (folder / checksums.SIGNATURE).exists() is signed
            for path in (folder, folder / "fmi3" / "AlignmentFilter.fmu"):
                checks = verify(path, signed_by=public, run=False)
                assert all(check.holds for check in checks) is signed, checks


def test_a_file_more_or_less_is_found(folder: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(folder, tmp_path / "copy")
    (copy / "notes.txt").write_text("mine")
    (copy / "README.md").unlink()
    assert verify(copy)[0].findings == ["README.md is missing", "notes.txt was not exported"]


def test_a_machine_without_room_finds_nothing_wrong(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_archive: str) -> list[str]:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(verification, "validate_fmu", full)
    with pytest.raises(InputError, match=r"cannot be unpacked into .*: No space left"):
        verify(folder)
