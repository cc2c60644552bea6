"""VDMCheck, which holds a model description of FMI 2 or 3 against every rule of the standard, in Java.

TRUENORTH_VDMCHECK2 and TRUENORTH_VDMCHECK3 name its jars, each in the folder in which it was unpacked, or
assembled of what Maven Central has: `vdmcheck2-1.1.3.jar` (org.into-cps.vdmcheck.fmi2; fmi3 likewise) and its
`fmi2schema/`, `fmi2-rule-model/` of `rule-model`, and without versions in their names `xsd2vdm.jar` and
`fmuReader.jar` (org.into-cps.vdmcheck), `vdmj.jar` and `annotations.jar` (dk.au.ece.vdmj, 4.5.0).
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

CLEAN = "No errors found."


def verdict(path: Path, version: int = 2) -> str:
    """What it says of an FMU or a modelDescription.xml of a version of FMI."""
    variable = f"TRUENORTH_VDMCHECK{version}"
    java, jar = shutil.which("java"), os.environ.get(variable)
    if java is None:
        pytest.skip("there is no java")
    if jar is None:
        pytest.skip(f"{variable} names no vdmcheck{version}.jar")
    finished = subprocess.run(
        [java, "-jar", jar, path.resolve()], cwd=Path(jar).parent, check=False, capture_output=True, text=True
    )
    assert not finished.stderr
    assert (finished.returncode == 0) == (CLEAN in finished.stdout.splitlines()), finished.stdout
    return CLEAN if finished.returncode == 0 else finished.stdout
