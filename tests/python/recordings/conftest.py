"""Tests below use the modules beside this file: signals of the plant, and files as loggers write them."""

from __future__ import annotations

import pytest

from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, PLANT, Fmus, load


@pytest.fixture(scope="session")
def all_fmus() -> Fmus:
    return Fmus({name: load(name) for name in (PLANT, ALIGNMENT_FILTER, NAVIGATION_FILTER)})
