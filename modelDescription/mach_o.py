"""Binaries of macOS: those of several processors in one file, which FMI 2 needs (`darwin64` is for all).

After Apple's `mach-o/fat.h` and `mach-o/loader.h`.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

MAGIC = b"\xcf\xfa\xed\xfe"
UNIVERSAL_MAGIC = 0xCAFEBABE
ALIGNMENT = 14
"""Binary logarithm: pages of 16 KiB."""


def is_binary(content: bytes) -> bool:
    """Whether this is a binary for one processor (64 bit)."""
    return content.startswith(MAGIC)


def universal(binaries: Sequence[bytes]) -> bytes:
    """Return one file of the binaries of several processors."""
    processors = [struct.unpack_from("<II", binary, len(MAGIC)) for binary in binaries]
    if len(set(processors)) < len(processors):
        raise SystemExit("two different binaries for the same processor; build all from one checkout")
    header = struct.pack(">II", UNIVERSAL_MAGIC, len(binaries))
    end = len(header) + 20 * len(binaries)
    body = b""
    for processor, binary in zip(processors, binaries, strict=True):
        padding = -(end + len(body)) % (1 << ALIGNMENT)
        body += bytes(padding)
        header += struct.pack(">5I", *processor, end + len(body), len(binary), ALIGNMENT)
        body += binary
    return header + body
