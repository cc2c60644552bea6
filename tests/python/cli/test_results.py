"""The folder of a result: its own, whoever else works in the same place, and gone if nothing comes in."""

from __future__ import annotations

import errno
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
import xarray as xr
from typer.testing import CliRunner

from sim_scenarios import matrix
from sim_scenarios.cli.application import app
from sim_scenarios.cli.results import DEFAULT, Results
from sim_scenarios.errors import InputError

TOGETHER = 8


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def page(_: xr.Dataset, folder: Path) -> Path:
    (folder / "report.html").write_text("here")
    return folder / "report.html"


def test_commands_at_once_get_a_folder_each() -> None:
    """All of them have found their folder before one writes into it."""
    everybody = Barrier(TOGETHER)

    def found(data: xr.Dataset, folder: Path) -> Path:
        everybody.wait(timeout=60)
        return page(data, folder)

    with ThreadPoolExecutor(TOGETHER) as threads:
        tasks = [threads.submit(Results(None).write, xr.Dataset(), found, "run") for _ in range(TOGETHER)]
        pages = {task.result()["report"] for task in tasks}
    assert len(pages) == TOGETHER
    assert all(Path(one).is_file() for one in pages)


def test_a_folder_that_nothing_came_into_is_gone() -> None:
    def full(*_: object) -> Path:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(InputError, match="No space left"):
        Results(None).write(xr.Dataset(), full, "run")
    assert list(DEFAULT.iterdir()) == []


def test_a_matrix_that_is_refused_leaves_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object, **__: object) -> None:
        raise InputError("no")

    monkeypatch.setattr(matrix, "matrix", refused)
    assert CliRunner().invoke(app, ["compare", "waves", "zigzag"]).exit_code == 2
    assert list(DEFAULT.iterdir()) == []


def test_what_an_unfinished_command_has_written_stays() -> None:
    with pytest.raises(InputError), Results(None).folder("matrix") as folder:  # noqa: PT012
        Results(folder / "waves").write(xr.Dataset(), page, "waves")
        raise InputError("the next scenario cannot be run")
    assert (DEFAULT / "matrix" / "waves" / "report.html").is_file()


def test_a_place_for_results_that_is_no_folder_is_refused(here: Path) -> None:
    (here / DEFAULT).symlink_to("nowhere")
    with pytest.raises(OSError, match="truenorth-results"), Results(None).folder("run"):
        pass
