"""The data set of a run: complete, labelled, and the same after a round trip through a file."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios import recording
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus


def test_round_trip(ship: xr.Dataset, tmp_path: Path) -> None:
    sim_scenarios.save(ship, tmp_path / "run.nc")
    assert sim_scenarios.load(tmp_path / "run.nc").identical(ship)


def test_round_trip_of_a_comparison(outliers: xr.Dataset, tmp_path: Path) -> None:
    sim_scenarios.save(outliers, tmp_path / "runs.nc")
    loaded = sim_scenarios.load(tmp_path / "runs.nc")
    assert list(loaded["filter"].values) == list(outliers["filter"].values)
    np.testing.assert_array_equal(loaded["heading_error"], outliers["heading_error"])


def test_every_output_of_the_filter_is_recorded_with_unit_and_description(
    ship: xr.Dataset, fmus: Fmus
) -> None:
    for name in {scalar.partition("[")[0] for scalar in fmus.filter.outputs()}:
        assert ship[name].attrs["description"], name
        if fmus.filter.variables[fmus.filter.arrays[name][0]].kind == "Real":
            assert ship[name].attrs["units"], name


def test_enumerations_say_what_their_values_mean(ship: xr.Dataset) -> None:
    names = dict(
        zip(ship["status"].attrs["flag_values"], ship["status"].attrs["flag_meanings"].split(), strict=True)
    )
    assert names[int(ship["status"].values[0])] == "waiting"
    assert names[int(ship["status"].values[-1])] == "converged"


def test_used_and_rejected_fixes_add_up(outliers: xr.Dataset) -> None:
    for label in outliers["filter"].values:
        one = outliers.sel(filter=label)
        assert int(one["fix_used"].sum()) == int(one["used_fixes"][-1])
        assert int((~one["fix_used"]).sum()) == int(one["rejected_fixes"][-1])
        assert np.all(one["measurement_weight"].values[~one["fix_used"].values] == 0)


def test_it_says_what_made_it(ship: xr.Dataset, fmus: Fmus) -> None:
    assert ship.attrs["scenario"] == "swaying_ship"
    assert ship.attrs["seed"] == 11
    settings = json.loads(ship.attrs["settings"])
    assert settings["filter"]["prior.heading_sigma"] == "10 deg"
    assert settings["plant"]["motion.kind"] == "ship"
    assert json.loads(ship.attrs["versions"])["TruthPlant"] == fmus.plant.guid


def test_outputs_of_different_filters_stand_side_by_side() -> None:
    """A filter may lack an output, or elements of it."""
    about = {"units": "m"}
    one = {"innovation": (("fix", "axis3"), np.arange(6.0).reshape(2, 3), about)}
    other = {
        "innovation": (("fix", "axis2"), np.ones((2, 2)), {}),
        "converged": (("time",), np.array([True, True]), {}),
        "status": (("time",), np.array([1, 2], dtype=np.int32), {}),
    }
    found = recording._side_by_side({"one": one, "other": other})
    dimensions, values, attributes = found["innovation"]
    assert (dimensions, attributes) == (("filter", "fix", "axis3"), about)
    np.testing.assert_array_equal(values[1], [[1, 1, np.nan], [1, 1, np.nan]])
    assert found["converged"][1].dtype == bool
    assert found["converged"][1].tolist() == [[False, False], [True, True]]
    assert found["converged"][2] == {"filters": '["other"]'}
    np.testing.assert_array_equal(found["status"][1], [[np.nan, np.nan], [1, 2]])
    with pytest.raises(InputError, match=r"status: one, other have it as numbers and as arrays"):
        recording._side_by_side({"one": {"status": (("time", "axis2"), np.ones((2, 2)), {})}, "other": other})
