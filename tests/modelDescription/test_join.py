"""FMUs of several platforms become one."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path

import pytest
from package import join

from sim_scenarios.archives import write_archive


def platform(folder: Path, name: str, description: str) -> Path:
    archive = folder / f"{name}.fmu"
    write_archive(archive, {"modelDescription.xml": description, f"binaries/{name}/x": name})
    return archive


def test_the_binaries_of_all(tmp_path: Path) -> None:
    join(tmp_path / "all.fmu", [platform(tmp_path, name, "same") for name in ("linux64", "win64")])
    with zipfile.ZipFile(tmp_path / "all.fmu") as content:
        members = {name: content.read(name) for name in content.namelist()}
    assert members == {
        "modelDescription.xml": b"same",
        "binaries/linux64/x": b"linux64",
        "binaries/win64/x": b"win64",
    }


def test_another_build_is_refused(tmp_path: Path) -> None:
    fmus = [platform(tmp_path, "linux64", "same"), platform(tmp_path, "win64", "other")]
    with pytest.raises(SystemExit, match=r"win64\.fmu: modelDescription\.xml is not as in the others"):
        join(tmp_path / "all.fmu", fmus)
    assert not (tmp_path / "all.fmu").exists()


X86, ARM = 0x01000007, 0x0100000C


def mac(folder: Path, name: str, processor: int, rest: bytes) -> Path:
    archive = folder / f"{name}.fmu"
    binary = struct.pack("<III", 0xFEEDFACF, processor, 3) + rest
    write_archive(archive, {"modelDescription.xml": "same", "binaries/darwin64/x.dylib": binary})
    return archive


def test_binaries_of_macos_become_a_universal_one(tmp_path: Path) -> None:
    fmus = [mac(tmp_path, "x86", X86, b"longer" * 9000), mac(tmp_path, "arm", ARM, b"short")]
    join(tmp_path / "all.fmu", fmus)
    with zipfile.ZipFile(tmp_path / "all.fmu") as content:
        universal = content.read("binaries/darwin64/x.dylib")
    assert struct.unpack_from(">II", universal) == (0xCAFEBABE, 2)
    ends = [0]
    for entry, (fmu, processor) in enumerate(zip(fmus, (X86, ARM), strict=True)):
        kind, _, offset, size, alignment = struct.unpack_from(">5I", universal, 8 + 20 * entry)
        assert kind == processor
        assert offset % 2**alignment == 0
        assert offset >= ends[-1]
        with zipfile.ZipFile(fmu) as content:
            assert universal[offset : offset + size] == content.read("binaries/darwin64/x.dylib")
        ends.append(offset + size)
    assert ends[-1] == len(universal)


def test_two_binaries_for_one_processor_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="two different binaries for the same processor"):
        join(tmp_path / "all.fmu", [mac(tmp_path, str(n), ARM, bytes([n])) for n in range(2)])
