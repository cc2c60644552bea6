"""The page of a run in headless Chromium: at two widths, light and dark."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from browser import WINDOWS, browser_is_there, chooses_and_zooms, fits, opened
from playwright.sync_api import Browser

from sim_scenarios.report import report_run


@pytest.fixture(scope="module")
def page(ship: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report_run(ship, tmp_path_factory.mktemp("page"))


@browser_is_there
@pytest.mark.parametrize(("width", "scheme"), WINDOWS)
def test_a_run(page: Path, chromium: Browser, width: int, scheme: str) -> None:
    with opened(chromium, page.as_uri(), width, scheme) as shown:
        fits(shown, scheme)
        chooses_and_zooms(shown)
