"""The FMUs, and short runs of them, shared by the tests."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING

import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, PLANT, Fmus, load
from sim_scenarios.metrics import figures

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="session")
def fmus() -> Fmus:
    """Plant and filter; tests that need them fail without them."""
    try:
        return Fmus({name: load(name) for name in (PLANT, ALIGNMENT_FILTER)})
    except InputError as error:
        pytest.fail(str(error), pytrace=False)


@pytest.fixture(scope="session")
def ship(fmus: Fmus) -> xr.Dataset:
    """The whole swaying ship."""
    return sim_scenarios.run("swaying_ship", seed=11, fmus=fmus)


@pytest.fixture(scope="session")
def outliers(fmus: Fmus) -> xr.Dataset:
    """A comparison in which fixes are rejected."""
    return sim_scenarios.compare("gnss_outliers", seed=12, set={"duration": 400.0}, fmus=fmus)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """Headless, for tests that are skipped where it is not installed."""
    from browser import CHROMIUM, FLAGS  # with Playwright, which other tests do without
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def register(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[dict[str, str]], None]]:
    """Makes entry points known that other packages would bring for figures, by name."""

    def registered(points: dict[str, str]) -> None:
        made = {figures.GROUP: [EntryPoint(name, value, figures.GROUP) for name, value in points.items()]}
        monkeypatch.setattr(figures, "entry_points", lambda group: made[group])
        figures.own.cache_clear()

    yield registered
    figures.own.cache_clear()


def pytest_configure() -> None:
    """A suite in the background of a shell ignores SIGINT; the commands that it starts must not."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
