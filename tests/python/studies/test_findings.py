"""What a campaign found, in sentences, against results whose answer is known."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from sim_scenarios.studies.expectations import Band, Row
from sim_scenarios.studies.findings import found
from sim_scenarios.studies.statistics import summarise
from sim_scenarios.studies.store import State
from sim_scenarios.units import ARCMIN


def said(data: xr.Dataset, *measured: Row) -> str:
    return found(data, list(summarise(data)), measured)


def several(*cases: xr.Dataset) -> xr.Dataset:
    """The cases of several results in one."""
    names = [f"case {k}" for k in range(len(cases))]
    about = json.loads(cases[0].attrs["cases"])["case"]
    data: xr.Dataset = xr.concat(cases, "scenario").assign_coords(scenario=names)
    data.attrs["cases"] = json.dumps(dict.fromkeys(names, about))
    return data


@pytest.fixture
def sound(results: xr.Dataset) -> xr.Dataset:
    """No run failed, a is three times as good as b on every seed, and neither is wrongly sure."""
    results["state"][:] = State.finished
    results["success"][:] = 1.0
    results["heading_rmse"][0, 0] = np.array([10.0, 11.0, 9.0, 10.0]) * ARCMIN
    results["heading_rmse"][0, 1] = 3 * results["heading_rmse"][0, 0]
    results["sure_time"][:] = 100.0
    results["wrongly_sure_time"][:] = [0.5, 1.0, 1.0, 0.7]  # of seven components, each with 0.27 %
    return results


def test_the_best_filter_is_named_with_its_figure(sound: xr.Dataset) -> None:
    text = said(sound)
    assert text.startswith("Of 2 filters 'a' has the smallest RMSE of heading, 10.0 arcmin (")
    assert "cannot be told" not in text


def test_what_noise_may_have_made_worse_is_told_with_the_best(sound: xr.Dataset) -> None:
    sound["heading_rmse"][0, 1] = np.array([13.0, 9.0, 11.0, 10.0]) * ARCMIN
    assert "'b' cannot be told from it" in said(sound)


def test_cases_are_counted(sound: xr.Dataset) -> None:
    other = sound.copy(deep=True)
    other["heading_rmse"][0] = sound["heading_rmse"].values[0, ::-1]
    assert "'a' has the smallest RMSE, or one that cannot be told from it, in 2 of 3 cases" in said(
        several(sound, other, sound)
    )
    assert "'a' and 'b' each have the smallest" in said(several(sound, other))


def test_a_filter_alone_is_not_the_best(sound: xr.Dataset) -> None:
    assert said(sound.isel(filter=[0])).startswith("None of 4 runs failed.")


def test_failed_runs_are_those_that_stopped_or_were_judged_so(sound: xr.Dataset) -> None:
    assert "None of 8 runs failed" in said(sound)
    sound["success"][0, 1, :2] = 0.0
    assert "2 of 8 runs failed, all of them of 'b'" in said(sound)
    sound["state"][0, 0, 3] = State.failed
    assert "3 of 8 runs failed, 2 of them of 'b'" in said(sound)


def test_wrongly_sure_is_told_where_it_is_no_chance(sound: xr.Dataset) -> None:
    assert "No filter was wrongly sure by more than chance" in said(sound)
    sound["wrongly_sure_time"][0, 1] = [20.0, 30.0, 25.0, 25.0]
    assert "'b' was wrongly sure by more than chance, for 25.0 % (" in said(sound)
    worse = sound.copy(deep=True)
    worse["wrongly_sure_time"][0, 0] = [50.0, 40.0, 45.0, 45.0]
    text = said(several(sound, worse))
    assert "'b' and 'a' were wrongly sure by more than chance, at most 'a' for 45.0 % (" in text
    assert "of the converged time in case 1." in text


def test_what_never_converged_was_not_sure(sound: xr.Dataset) -> None:
    sound["sure_time"][:] = 0.0
    assert "No filter reported convergence" in said(sound)


def test_expectations_that_are_missed_are_counted(sound: xr.Dataset) -> None:
    printed = Row("a", "heading_rmse", 9.0, 10.0, None, None)
    met = replace(printed, expected=Band(low=9.0, high=11.0))
    missed = replace(printed, expected=Band(low=1.0, high=2.0))
    assert "1 of 2 figures with a band missed it" in said(sound, met, missed, printed)
    assert "None of 1 figures" in said(sound, met)
    assert "missed" not in said(sound, printed)


def test_no_run_that_was_finished_is_told(sound: xr.Dataset) -> None:
    sound["state"][:] = State.failed
    assert said(sound) == ("Every one of 8 runs failed. Whether a filter reported convergence is not known.")


def test_filters_that_failed_as_often_are_named_together(sound: xr.Dataset) -> None:
    sound["state"][0, :, 3] = State.failed
    assert "2 of 8 runs failed, 1 of them of each of 'a' and 'b'." in said(sound)


def test_without_runs_there_is_nothing_to_tell(sound: xr.Dataset) -> None:
    sound["state"][:] = State.missing
    assert said(sound) == "There are no runs yet."


def test_one_run_tells_a_share_and_no_more(sound: xr.Dataset) -> None:
    sound["wrongly_sure_time"][0, 1] = 2.0
    text = said(sound.isel(run=[0]))
    assert "'b' was wrongly sure for 2.00 % of the converged time: one run tells no more." in text
    assert "chance" not in text
    sound["sure_time"][0, 1, 1:] = 0.0
    sound["wrongly_sure_time"][0, 0] = [50.0, 40.0, 45.0, 45.0]
    text = said(sound)
    assert "'a' was wrongly sure by more than chance, for 45.0 % (" in text
    assert "; 'b' was wrongly sure for 2.00 % of the converged time: one run tells no more." in text


def test_a_filter_of_which_certainty_is_not_known_is_not_called_right(sound: xr.Dataset) -> None:
    sound["wrongly_sure_time"][0, 1] = np.nan
    assert "No filter was wrongly sure by more than chance; of 'b' it is not known." in said(sound)
    sound["wrongly_sure_time"][:] = np.nan
    assert said(sound).endswith("Whether a filter was wrongly sure is not known.")


def test_what_stopped_is_not_known_to_be_unsure(sound: xr.Dataset) -> None:
    sound["sure_time"][:] = 0.0
    sound["state"][0, 1] = State.failed
    assert "No filter reported convergence in a run that finished." in said(sound)


def test_what_is_left_of_failed_runs_is_not_the_best(sound: xr.Dataset) -> None:
    sound["state"][0, 0, 1:] = State.failed
    assert said(sound).startswith("'b' alone has an RMSE of heading of every run, 30.1 arcmin (")
    three = xr.concat([sound, sound.isel(filter=[1])], "filter", data_vars="minimal")
    three = three.assign_coords(filter=list("abc"))
    three["heading_rmse"][0, 2] *= 2
    assert said(three).startswith(
        "Of 2 filters with an RMSE of every run 'b' has the smallest RMSE of heading, 30.1 arcmin ("
    )
    text = said(several(three, three))
    assert "'b' has the smallest RMSE, or one that cannot be told from it, in 2 of 2 cases, of the" in text
    assert "of the filters with one of every run." in text


def test_where_all_failed_in_some_run_what_is_left_is_told_so(sound: xr.Dataset) -> None:
    sound["state"][0, 0, 1:] = State.failed
    sound["state"][0, 1, 3] = State.failed
    left = "'a' has the smallest RMSE of heading, over the runs that have one, 10.0 arcmin"
    assert left in said(sound)
    assert "in 2 of 2 cases; in 2 no filter has one of every run." in said(several(sound, sound))


def test_a_filter_without_a_figure_is_named(sound: xr.Dataset) -> None:
    sound["heading_rmse"][0, 1] = np.nan
    assert said(sound).startswith("'a' alone has an RMSE of heading, 10.0 arcmin (")
    assert "; 'b' has none. None of 8" in said(sound)
    other = sound.copy(deep=True)
    other["heading_rmse"][0, 1] = 90 * ARCMIN
    text = said(several(sound, other))
    assert "'a' has the smallest RMSE, or one that cannot be told from it, in 2 of 2 cases" in text
    assert "; 'b' has none in some of them." in text
    sound["heading_rmse"][:] = np.nan
    assert said(sound).startswith("None of 8 runs failed.")


def test_a_sentence_does_not_list_many(sound: xr.Dataset) -> None:
    many = xr.concat([sound, sound], "filter", data_vars="minimal").assign_coords(filter=list("abcd"))
    many["wrongly_sure_time"][:] = [20.0, 30.0, 25.0, 25.0]
    assert "4 filters were wrongly sure" in said(many)
