"""A small campaign, run once for all tests: two scenarios, one of which lacks a filter; made-up results."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.fmus import Fmus
from sim_scenarios.studies.campaign import campaign
from sim_scenarios.studies.quantities import BOUNDED, KEPT, SERIES
from sim_scenarios.studies.store import State

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


@pytest.fixture
def results() -> xr.Dataset:
    """One case with filters a and b in four runs, the last of which failed for b."""
    runs = ("scenario", "filter", "run")
    data = xr.Dataset(
        {
            **{name: ((*runs, "time"), np.ones((1, 2, 4, 3))) for name in SERIES},
            **{name: (runs, np.ones((1, 2, 4))) for name in KEPT},
            "state": (runs, np.full((1, 2, 4), State.finished, np.int8)),
            **{f"{name}_bound": (("scenario", "time"), np.ones((1, 3))) for name in BOUNDED},
            "heading_bound_rms": ("scenario", [0.5]),
            "horizontal_bound_rms": ("scenario", [2.0]),
            "fault_end": (("scenario", "run"), np.full((1, 4), np.nan)),
        },
        coords={"scenario": ["case"], "filter": ["a", "b"], "time": [0.0, 1.0, 2.0]},
        attrs={
            "plan": '{"reference": null}',
            "cases": json.dumps(
                {
                    "case": {
                        "attributes": {
                            "duration": 2.0,
                            "evaluation.stop": 1.0,
                            "filter_fmu": "AlignmentFilter",
                        }
                    }
                }
            ),
        },
    )
    data["state"][0, 1, 3] = State.failed
    data["hand_over_time"][:] = np.nan
    data["heading_rmse"][0] = [[1, 1, 1, 7], [3, 3, 3, np.nan]]
    data["convergence_time"][0] = [[30, 10, np.nan, 20], [np.nan, np.nan, 5, np.nan]]
    data["claimed_deviation"][0] = [[0.5, 3.1, np.nan, 2.9], [np.nan] * 4]
    data["success"][0] = [[1, 1, 0, 1], [1, 1, 1, np.nan]]
    data["heading_sigma"][0, 0, :, 1] = 0.5
    return data
