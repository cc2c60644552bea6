"""Signatures of a list of checksums (Ed25519): who has the public key knows who made the list.

Keys are PEM files, as OpenSSL makes and reads them, and a signature is its 64 bytes::

    openssl genpkey -algorithm ed25519 -out key.pem
    openssl pkey -in key.pem -pubout -out public.pem
    openssl pkeyutl -verify -rawin -pubin -inkey public.pem -in SHA256SUMS -sigfile SHA256SUMS.sig
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from sim_scenarios.errors import InputError

SIZE: Final = 64
"""Bytes of a signature."""
Sign = Callable[[bytes], bytes]
"""What makes the signature of bytes."""
IsSigned = Callable[[bytes, bytes], bool]
"""Whether bytes have a signature, the second argument."""


def signer(key: Path) -> Sign:
    """What signs with a private key.

    Raises
    ------
    InputError
        The file is missing, has no private key of Ed25519, or is locked by a passphrase.
    """
    ed25519, serialization, _ = _library()
    content = _read(key)
    try:
        found = serialization.load_pem_private_key(content, password=None)
    except TypeError:
        raise InputError(f"{key} is locked by a passphrase: give a key without one") from None
    except Exception:  # whatever else the library finds wrong with it
        found = None
    if not isinstance(found, ed25519.Ed25519PrivateKey):
        raise InputError(f"{key} must be a private key of Ed25519 in a PEM file")
    sign: Sign = found.sign
    return sign


def signed_by(public_key: Path) -> IsSigned:
    """What tells whether a signature was made with the private key that belongs to a public one.

    Raises
    ------
    InputError
        The file is missing, or has no public key of Ed25519.
    """
    ed25519, serialization, invalid = _library()
    text = _read(public_key)
    try:
        key = serialization.load_pem_public_key(text)
    except Exception:  # whatever the library finds wrong with it
        key = None
    if not isinstance(key, ed25519.Ed25519PublicKey):
        raise InputError(f"{public_key} must be a public key of Ed25519 in a PEM file")
    verify = key.verify

    def is_signed(content: bytes, signature: bytes) -> bool:
        try:
            verify(signature, content)
        except invalid:
            return False
        return True

    return is_signed


def _read(key: Path) -> bytes:
    try:
        return key.read_bytes()
    except OSError as error:
        raise InputError(f"{key} cannot be read: {error.strerror}") from None


def _library() -> tuple[Any, Any, type[Exception]]:
    """Modules of `cryptography`, which is an extra, and what it raises of a wrong signature."""
    try:
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives import serialization
        from cryptography.hazmat.primitives.asymmetric import ed25519
    except ImportError:
        raise InputError("signatures need the package cryptography: pip install 'truenorth[sign]'") from None
    return ed25519, serialization, InvalidSignature
