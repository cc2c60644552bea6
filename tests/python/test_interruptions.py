"""Commands that are killed at any moment, and disks that fill: nothing is left, nothing is half."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import toml
from sim_scenarios.cli.application import app  # noqa: F401  (compiled before the clock runs)
from sim_scenarios.fmus import Fmus
from sim_scenarios.folders import DRAFT

SHORT = ["--set", "duration=20", "--set", "evaluation.start=10"]
COMMANDS = {
    "run": ["run", "zigzag", *SHORT],
    "live": ["run", "zigzag", "--live", "--pace", "100", *SHORT],
    "export": ["export", "zigzag", *SHORT],
    "compare": ["compare", "zigzag", *SHORT],
    "campaign": ["campaign", "zigzag", "-n", "6", "--workers", "2", "--filter", "UKF", *SHORT],
    "replay": ["replay", "{imu}", "--heading", "10"],
    "derive": ["derive", "{imu}"],
    "import": ["import", "{imu}"],
    "bands": ["bands", "zigzag", "-n", "1", "--workers", "2"],
    "paper": ["paper", "jing", "-n", "1", "--workers", "2"],
    "verify": ["verify", "{export}"],
}
ALL = {signal.SIGTERM: 143, signal.SIGINT: 130, signal.SIGKILL: -signal.SIGKILL}
PLACE = ("latitude", "longitude", "height")
RESUMED = ("campaign", "bands", "paper")
ENOUGH: tuple[int, ...] = (0, 1, 2)  # exit codes of a command that came to its end

ATTEMPTS = [0, *(pytest.param(i, marks=pytest.mark.slow) for i in range(1, 10))]
FREE = [20_000, *(pytest.param(1 << k, marks=pytest.mark.slow) for k in range(12, 22))]  # bytes
full_form = pytest.mark.parametrize("attempt", ATTEMPTS)
IN_SHORT = ("run", "import")
every_command = pytest.mark.parametrize(
    "command", [c if c in IN_SHORT else pytest.param(c, marks=pytest.mark.slow) for c in COMMANDS]
)


def start(command: str, output: Path, temporary: Path) -> subprocess.Popen[str]:
    """The command, in a group of its own, with its own folder for temporary files.

    What it is given lies beside that of its temporary files.
    """
    place = {"imu": temporary.parent / "imu.csv", "export": temporary.parent / "export"}
    words = [word.format_map(place) for word in COMMANDS[command]]
    if command == "import":
        words += ["--force", "--output", str(output / "recording.toml")]
    elif command != "verify":
        words += ["--output", str(output)]
    return subprocess.Popen(
        [sys.executable, "-m", "sim_scenarios.cli", *words],
        env={**os.environ, "TMPDIR": str(temporary)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def kill(process: subprocess.Popen[str], number: signal.Signals, dice: random.Random, span: float) -> str:
    """Send a signal at a random moment of a span [s]; what the command said."""
    time.sleep(dice.uniform(0, span))
    if process.poll() is None:
        process.send_signal(number)
    _, said = process.communicate(timeout=600)
    return said


def check_whole(output: Path) -> None:
    """Whatever has its final name can be read to its end."""
    for path in output.rglob("*"):
        if path.suffix == ".html":
            assert path.read_text(encoding="utf-8").rstrip().endswith("</html>")
        elif path.suffix == ".nc":
            xr.load_dataset(path, engine="scipy")
        elif path.suffix == ".png":
            assert path.read_bytes().endswith(b"IEND\xaeB`\x82")
        elif path.suffix in (".fmu", ".ssp"):
            assert zipfile.ZipFile(path).testzip() is None
        elif path.suffix in (".xml", ".ssv", ".ssd"):
            ET.parse(path)
        elif path.suffix == ".toml":
            assert toml.read(path)
        elif path.name in (".zattrs", ".zarray", ".zmetadata"):
            json.loads(path.read_text(encoding="utf-8"))


def left(folder: Path) -> list[Path]:
    """Temporary files and drafts."""
    return [path for path in folder.rglob("*") if DRAFT in path.name or path.name.endswith(".partial")]


def at_rest(path: Path, rows: int) -> None:
    """A recorded IMU, 100 Hz, with a fix a second."""
    time = 0.01 * np.arange(1, rows + 1)
    increments = np.random.default_rng(15).normal([0, 0, 0, 0, 0, 0.0978], 1e-5, (rows, 6))
    names = [f"delta_{kind}_{axis}" for kind in ("angle", "velocity") for axis in "xyz"]
    table = pd.DataFrame({"time": time, **dict(zip(names, increments.T, strict=True))})
    fixes = [f"gnss_{name}" for name in ("velocity_east", "velocity_north", "velocity_up", *PLACE)]
    for name in fixes:
        table[name] = np.where(np.arange(rows) % 100 == 0, 0.0, np.nan)
    table.to_csv(path, index=False)


@pytest.fixture(scope="module")
def given(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Path:  # noqa: ARG001
    """A recording at rest, and an export."""
    folder = tmp_path_factory.mktemp("given")
    at_rest(folder / "imu.csv", 2000)
    sim_scenarios.export("zigzag", folder / "export", set={"duration": 20.0, "evaluation.start": 10.0})
    return folder


@pytest.fixture
def places(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path]:
    """Where a command writes, and its temporary files; beside them what it is given, if it needs any."""
    (tmp_path / "tmp").mkdir()
    named = getattr(request.node, "callspec", None)
    command = named.params.get("command", "") if named else ""
    if any("{" in word for word in COMMANDS.get(command, ())):
        for path in request.getfixturevalue("given").iterdir():
            (tmp_path / path.name).symlink_to(path)
    return tmp_path / "out", tmp_path / "tmp"


@pytest.fixture(scope="module")
def span(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> dict[str, float]:  # noqa: ARG001
    """How long the commands take when they are left alone [s]; `run` alone, as the others take longer."""
    folder = tmp_path_factory.mktemp("span")
    begin = time.monotonic()
    start("run", folder / "out", folder).communicate(timeout=600)
    return dict.fromkeys(COMMANDS, time.monotonic() - begin)


@full_form
@every_command
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_nothing_is_left_and_nothing_is_half(
    places: tuple[Path, Path], span: dict[str, float], command: str, attempt: int, number: signal.Signals
) -> None:
    """After SIGTERM at once; after SIGKILL, when the same command has come to its end."""
    output, temporary = places
    process = start(command, output, temporary)
    said = kill(process, number, random.Random(attempt), span[command])
    assert process.returncode in (*ENOUGH, ALL[number], -number)  # the last before Python is ready to answer
    assert "Traceback" not in said
    check_whole(output)
    if number is not signal.SIGKILL:
        assert list(temporary.iterdir()) == []
        assert left(output.parent) == []
    if number is signal.SIGKILL or command in RESUMED:
        again = start(command, output, temporary)
        again.communicate(timeout=600)
        assert again.returncode in ENOUGH[:2]
        check_whole(output)
        assert list(temporary.iterdir()) == []
        assert left(output.parent) == []


def test_sigterm_says_so(fmus: Fmus, places: tuple[Path, Path]) -> None:  # noqa: ARG001
    output, temporary = places
    command = [sys.executable, "-m", "sim_scenarios.cli", "run", "zigzag", "--set", "duration=100000"]
    with subprocess.Popen(
        [*command, "--output", str(output)],
        env={**os.environ, "TMPDIR": str(temporary)},
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        while not list(temporary.glob("*/*")):  # FMUs are unpacked
            assert process.poll() is None
            time.sleep(0.05)
        process.terminate()
        _, said = process.communicate(timeout=600)
    assert process.returncode == 143
    assert said.splitlines()[-1] == "truenorth: terminated"
    assert "Traceback" not in said
    assert list(temporary.iterdir()) == []
    assert not output.exists()


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 8 MB."""
    if not hasattr(os, "geteuid") or os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("needs root, to mount a small disk")
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "none", str(place)], check=False)
    if mounted.returncode != 0:
        pytest.skip("cannot mount a small disk here")
    yield place
    subprocess.run(["umount", str(place)], check=True)


def fill(disk: Path, free: int) -> None:
    """Leave so many bytes of a disk."""
    space = os.statvfs(disk)
    (disk / "filling").write_bytes(bytes(space.f_bavail * space.f_bsize - free))


@every_command
@pytest.mark.parametrize(
    "free", [10_000, *(pytest.param(1 << k, marks=pytest.mark.slow) for k in range(14, 22))]
)
def test_a_full_folder_of_temporary_files_is_named(
    fmus: Fmus,  # noqa: ARG001
    disk: Path,
    places: tuple[Path, Path],
    command: str,
    free: int,
) -> None:
    """And not that of the results; or the command does without temporary files."""
    output, temporary = places
    temporary.rmdir()
    temporary.symlink_to(disk)
    fill(disk, free)
    process = start(command, output, temporary)
    _, said = process.communicate(timeout=600)
    assert process.returncode in ENOUGH
    assert "Traceback" not in said
    if process.returncode == 2:
        assert f"{temporary}: No space left on device; temporary files go there" in said
        assert "--output" not in said
        assert not output.exists() or command in RESUMED
    check_whole(output)
    assert [path.name for path in disk.iterdir()] == ["filling"]


@every_command
@pytest.mark.parametrize("free", FREE)
def test_a_full_disk_leaves_nothing_half(
    fmus: Fmus,  # noqa: ARG001
    disk: Path,
    places: tuple[Path, Path],
    command: str,
    free: int,
) -> None:
    fill(disk, free)
    process = start(command, disk / "out", places[1])
    _, said = process.communicate(timeout=600)
    check_whole(disk / "out")
    assert left(disk) == []
    assert list(places[1].iterdir()) == []
    assert process.returncode in ENOUGH
    if process.returncode == 2:
        assert "No space left on device" in said
        assert not (disk / "out" / "report.html").exists()
    assert "Traceback" not in said
