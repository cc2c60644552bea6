"""Lists of checksums that are signed: whose key it was shows, and wrong keys are refused in a sentence."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from cryptography.hazmat.primitives import serialization as pem
from cryptography.hazmat.primitives.asymmetric import ec, ed25519
from typer.testing import CliRunner

from sim_scenarios.archives import archive_bytes
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import checksums, evidence, verification
from sim_scenarios.exchange.signature import signed_by, signer
from sim_scenarios.exchange.verification import NOT_RUN, SIGNED, Check, verify

Key = ed25519.Ed25519PrivateKey | ec.EllipticCurvePrivateKey
MEMBERS = {"modelDescription.xml": b"<fmiModelDescription/>\n"}


def write_keys(folder: Path, name: str, key: Key, locked: bytes | None = None) -> tuple[Path, Path]:
    """PEM files of a private key and of the public one."""
    form = pem.BestAvailableEncryption(locked) if locked else pem.NoEncryption()
    private, public = folder / f"{name}.pem", folder / f"{name}.public.pem"
    private.write_bytes(key.private_bytes(pem.Encoding.PEM, pem.PrivateFormat.PKCS8, form))
    public.write_bytes(key.public_key().public_bytes(pem.Encoding.PEM, pem.PublicFormat.SubjectPublicKeyInfo))
    return private, public


@pytest.fixture
def keys(tmp_path: Path) -> tuple[Path, Path]:
    return write_keys(tmp_path, "ours", ed25519.Ed25519PrivateKey.generate())


@pytest.fixture
def folder(tmp_path: Path, keys: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small export, signed; nothing of it can be run."""
    sign = signer(keys[0])
    fmu = archive_bytes(checksums.with_list(MEMBERS, evidence.FOLDER, sign))
    path = tmp_path / "export"
    path.mkdir()
    for name, content in checksums.with_list({"mine.fmu": fmu, "README.md": b"read\n"}, sign=sign).items():
        (path / name).write_bytes(content)
    for look in ("_repeated", "_valid"):
        monkeypatch.setattr(verification, look, lambda _: Check("looked at", True, []))
    return path


@pytest.mark.parametrize("what", ["", "mine.fmu"])
def test_whose_key_it_was_shows(folder: Path, keys: tuple[Path, Path], tmp_path: Path, what: str) -> None:
    _, other = write_keys(tmp_path, "other", ed25519.Ed25519PrivateKey.generate())
    result = CliRunner().invoke(app, ["verify", str(folder / what), "--signed-by", str(keys[1])])
    assert result.exit_code == 0, result.output
    assert f"holds  {SIGNED}" in result.output
    assert "nobody vouches" not in result.output
    checks = verify(folder / what, signed_by=other)
    assert [check.what for check in checks[1:]] == [SIGNED, NOT_RUN]
    assert not any(check.holds for check in checks[1:])
    assert checks[1].findings == [f"it is not signed with the key of {other}"]


def test_who_changes_the_content_with_its_list_cannot_sign_it(folder: Path, keys: tuple[Path, Path]) -> None:
    (folder / "README.md").write_bytes(b"mine\n")
    files = {name: (folder / name).read_bytes() for name in ("mine.fmu", "README.md")}
    (folder / checksums.NAME).write_text(checksums.listed(files))
    assert all(check.holds for check in verify(folder))
    assert not verify(folder, signed_by=keys[1])[1].holds
    (folder / checksums.SIGNATURE).unlink()
    assert verify(folder, signed_by=keys[1])[1].findings == ["it has no signature"]


def test_each_flipped_bit_of_a_signature_is_found(folder: Path, keys: tuple[Path, Path]) -> None:
    path = folder / checksums.SIGNATURE
    whole = path.read_bytes()
    for bit in range(8 * len(whole)):
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        path.write_bytes(changed)
        assert not verify(folder, signed_by=keys[1])[1].holds, bit


def test_what_is_no_signature_is_found_without_a_key(folder: Path) -> None:
    assert "the signature was not looked at" in verify(folder)[0].findings[1]
    (folder / checksums.SIGNATURE).write_bytes(b"mine")
    assert verify(folder)[0].findings == ["SHA256SUMS.sig is damaged"]


def test_openssl_reads_keys_and_signature(folder: Path, keys: tuple[Path, Path]) -> None:
    openssl = shutil.which("openssl")
    if openssl is None:
        pytest.skip("there is no openssl")
    command = [openssl, "pkeyutl", "-verify", "-rawin", "-pubin", "-inkey", keys[1]]
    subprocess.run([*command, "-in", checksums.NAME, "-sigfile", checksums.SIGNATURE], cwd=folder, check=True)


def test_a_wrong_key_is_refused_in_a_sentence(tmp_path: Path, keys: tuple[Path, Path]) -> None:
    elliptic = write_keys(tmp_path, "elliptic", ec.generate_private_key(ec.SECP256R1()))
    locked, _ = write_keys(tmp_path, "locked", ed25519.Ed25519PrivateKey.generate(), b"secret")
    (tmp_path / "text.pem").write_text("mine")
    for path in (elliptic[0], keys[1], tmp_path / "text.pem"):
        with pytest.raises(InputError, match="must be a private key of Ed25519 in a PEM file"):
            signer(path)
    for path in (elliptic[1], keys[0], tmp_path / "text.pem"):
        with pytest.raises(InputError, match="must be a public key of Ed25519 in a PEM file"):
            signed_by(path)
    with pytest.raises(InputError, match="locked by a passphrase"):
        signer(locked)
    for read in (signer, signed_by):
        with pytest.raises(InputError, match=r"nowhere\.pem cannot be read: No such file"):
            read(tmp_path / "nowhere.pem")


def test_without_the_extra_it_is_named(keys: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cryptography.exceptions", None)
    with pytest.raises(InputError, match=r"truenorth\[sign\]"):
        signer(keys[0])
