"""A small campaign, run once for all tests: two scenarios, one of which lacks a filter."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim_scenarios.fmus import Fmus
from sim_scenarios.studies.campaign import campaign

CAMPAIGN = """
description = "Two courses"
scenarios = ["zigzag", "overconfident_prior"]
filters = ["EKF", "UKF"]
runs = 5
seed = 3
period = 2.0
reference = "UKF"

[set]
duration = 40.0
"evaluation.start" = 20.0
"evaluation.stop" = 40.0

[grid]
"gnss.rate" = [1.0, 2.0]
"""


@pytest.fixture(scope="session")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plan") / "courses.toml"
    path.write_text(CAMPAIGN, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def results_folder(plan_file: Path, fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the campaign, run to its end on two workers."""
    folder = tmp_path_factory.mktemp("campaign")
    campaign(plan_file, folder, workers=2, fmus=fmus)
    return folder
