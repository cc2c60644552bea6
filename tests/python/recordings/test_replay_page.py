"""The page of a recording with a reference in headless Chromium: at two widths, light and dark."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import WINDOWS, browser_is_there, chooses_and_zooms, fits, opened, paths
from plant_signals import sensed, told_as_in
from playwright.sync_api import Browser

import sim_scenarios
from sim_scenarios import Start
from sim_scenarios.fmus import Fmus
from sim_scenarios.report import report_replay


@pytest.fixture(scope="module")
def page(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Path:
    recording = sensed(fmus, "swaying_ship", 60.0)
    run = sim_scenarios.replay(recording, Start(0.0), set=told_as_in("swaying_ship", fmus), fmus=fmus)
    return report_replay(run, tmp_path_factory.mktemp("page"))


@browser_is_there
@pytest.mark.parametrize(("width", "scheme"), WINDOWS)
def test_a_replay(page: Path, chromium: Browser, width: int, scheme: str) -> None:
    with opened(chromium, page.as_uri(), width, scheme) as shown:
        fits(shown, scheme)
        chooses_and_zooms(shown)
        shown.select_option("#panel", label="Track")
        assert len(paths(shown, "curve")) == 2  # of the filter, and of the fixes
