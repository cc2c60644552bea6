"""An FMU can be built from its own sources, and then gives the same results."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from archives import FMUS
from fmpy.build import build_platform_binary
from fmpy.model_description import read_build_description
from lxml import etree

NAMES = sorted(path.stem for path in FMUS.glob("*.fmu"))
VERSIONS = {"fmi2": FMUS, "fmi3": FMUS / "fmi3"}


@pytest.mark.parametrize("name", NAMES)
def test_both_descriptions_name_the_same_files(name: str) -> None:
    """FMI 2 has the list in two places."""
    archive = VERSIONS["fmi2"] / f"{name}.fmu"
    (build,) = read_build_description(str(archive))
    expected = build.sourceFileSets[0].sourceFiles
    with zipfile.ZipFile(archive) as content:
        description = etree.fromstring(content.read("modelDescription.xml"))
    for kind in ("ModelExchange", "CoSimulation"):
        assert [file.get("name") for file in description.iterfind(f"{kind}/SourceFiles/File")] == expected


@pytest.mark.parametrize(
    ("name", "version"),
    [
        pytest.param(
            name, version, marks=[] if (name, version) == ("TruthPlant", "fmi3") else pytest.mark.slow
        )
        for name in NAMES
        for version in VERSIONS
    ],
)
def test_the_sources_alone_make_the_same_fmu(name: str, version: str, tmp_path: Path) -> None:
    """FMPy compiles them; where it does not look for the language (FMI 2), it must be told."""
    archive = VERSIONS[version] / f"{name}.fmu"
    unpacked = Path(
        fmpy.extract(archive, unzipdir=tmp_path, include=lambda member: not member.startswith("binaries/"))
    )
    build_platform_binary(unpacked, generator="Ninja", cmake_options={"CMAKE_CXX_STANDARD:STRING": "20"})
    shipped, built = (
        fmpy.simulate_fmu(fmu, stop_time=20.0, output_interval=0.1) for fmu in (str(archive), str(unpacked))
    )
    assert shipped.dtype == built.dtype
    for column in shipped.dtype.names:
        np.testing.assert_array_equal(built[column], shipped[column], err_msg=column)
