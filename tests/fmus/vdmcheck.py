"""VDMCheck2, which holds a model description of FMI 2 against every rule of the standard, in Java.

TRUENORTH_VDMCHECK2 names its jar, in the folder in which it was unpacked, or assembled of what Maven Central
has: `vdmcheck2-1.1.3.jar` (org.into-cps.vdmcheck.fmi2) and its `fmi2schema/`, `fmi2-rule-model/` of
`rule-model`, and without versions in their names `xsd2vdm.jar` and `fmuReader.jar` (org.into-cps.vdmcheck),
`vdmj.jar` and `annotations.jar` (dk.au.ece.vdmj, 4.5.0).
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

CLEAN = "No errors found."


def verdict(path: Path) -> str:
    """What it says of an FMU or a modelDescription.xml."""
    java, jar = shutil.which("java"), os.environ.get("TRUENORTH_VDMCHECK2")
    if java is None:
        pytest.skip("there is no java")
    if jar is None:
        pytest.skip("TRUENORTH_VDMCHECK2 names no vdmcheck2.jar")
    finished = subprocess.run([java, "-jar", jar, path], check=False, capture_output=True, text=True)
    assert not finished.stderr
    assert (finished.returncode == 0) == (CLEAN in finished.stdout.splitlines()), finished.stdout
    return CLEAN if finished.returncode == 0 else finished.stdout
