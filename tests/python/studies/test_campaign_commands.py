"""The command that shows a run of a campaign alone, where there is one."""

from __future__ import annotations

import json

import pytest
import xarray as xr

from sim_scenarios.studies import page

CASE = {"scenario": "zigzag", "settings": {"gnss.rate": 2.0}, "drawn": {}}
COMMAND = "truenorth compare zigzag --seed 3 --set gnss.rate=2.0"


@pytest.mark.parametrize(
    ("filters", "command"), [(None, COMMAND), (["EKF"], COMMAND), ({"mine": {"corrector": "igg"}}, "")]
)
def test_filters_of_the_campaign_itself_are_in_no_command(filters: object, command: str) -> None:
    data = xr.Dataset(attrs={"seed": 3, "plan": json.dumps({"filters": filters})})
    assert page._command(CASE, data) == command
