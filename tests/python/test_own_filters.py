"""A filter of somebody else's beside ours.

It is the binary of AlignmentFilter under a description that tells less, so that it must find the heading of
AlignmentFilter to the last bit.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from foreign import DESCRIPTION, foreign

import sim_scenarios
from sim_scenarios.archives import read_archive, write_archive
from sim_scenarios.errors import InputError, SimulationError
from sim_scenarios.fmus import SIGNALS, Fmus
from sim_scenarios.matrix import judged
from sim_scenarios.metrics import judge
from sim_scenarios.metrics.navigation import NavigationVerdict
from sim_scenarios.recording import of_filter
from sim_scenarios.report import comparison_table, report_comparison, report_run
from sim_scenarios.scenario import load_scenario
from sim_scenarios.studies.campaign import campaign
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan
from sim_scenarios.studies.statistics import summarise
from sim_scenarios.studies.table import figures

SCENARIO = """
extends = "swaying_ship"
description = "Ours and theirs"
duration = 20.0
evaluation = { start = 10.0, stop = 20.0 }

[plant]
gnss.latency = 0.35
"""
PARAMETERS = """
predictor = "unscented"
corrector = "standard"
prior.heading_sigma = "10 deg"
prior.tilt_sigma = "0.5 deg"
"""
OURS = f"[compare.ours]\nfilter_fmu = 'AlignmentFilter'\n{PARAMETERS}"
THEIRS = f"[compare.theirs]\nfilter_fmu = 'rivals/mine.fmu'\n{PARAMETERS}"


NO_FMI_2 = """<fmiModelDescription fmiVersion="{version}" modelName="mine" guid="1" instantiationToken="1">
<{kind} modelIdentifier="mine"/><ModelVariables/><ModelStructure/></fmiModelDescription>"""


@pytest.fixture
def folder(fmus: Fmus, tmp_path: Path) -> Path:
    """With an FMU that tells nothing but its heading."""
    foreign(fmus.filter, tmp_path / "rivals" / "mine.fmu")
    return tmp_path


@pytest.fixture(scope="module")
def runs(fmus: Fmus, tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """Ours and theirs on the same signals."""
    folder = tmp_path_factory.mktemp("compared")
    foreign(fmus.filter, folder / "rivals" / "mine.fmu")
    return sim_scenarios.compare(scenario(folder, OURS + THEIRS), seed=4, fmus=fmus)


def scenario(folder: Path, text: str, head: str = SCENARIO) -> Path:
    path = folder / "mine.toml"
    path.write_text(head + text, encoding="utf-8")
    return path


def test_it_finds_the_heading_of_the_same_binary(runs: xr.Dataset) -> None:
    ours, theirs = (runs["nav.heading"].sel(filter=label).values for label in ("ours", "theirs"))
    assert np.ptp(ours) > 0
    np.testing.assert_array_equal(theirs, ours)
    verdicts = judged(runs)
    assert verdicts["theirs"].rmse == verdicts["ours"].rmse


def test_what_it_does_not_tell_is_empty(runs: xr.Dataset, tmp_path: Path) -> None:
    assert np.isnan(runs["heading_sigma"].sel(filter="theirs")).all()
    assert json.loads(runs["heading_sigma"].attrs["filters"]) == ["ours"]
    assert not runs["converged"].sel(filter="theirs").any()
    theirs, ours = (of_filter(runs, label) for label in ("theirs", "ours"))
    assert {"heading_sigma", "status", "nis", "fix_used"}.isdisjoint(map(str, theirs))
    assert {"heading_sigma", "status", "nis", "fix_used"} <= set(map(str, ours))
    verdicts = judged(runs)
    told = verdicts["theirs"].to_json()
    assert (told["heading_sigma_arcmin"], told["status"], told["used_fixes"]) == (None, None, None)
    heading, *rows = comparison_table(verdicts)
    cells = {row[0]: dict(zip(heading, row, strict=True)) for row in rows}
    assert [cells["theirs"][name] for name in ("sigma\n[']", "NIS /\nchan.", "refused")] == ["-"] * 3
    assert cells["ours"]["refused"] != "-"
    assert report_comparison(runs, tmp_path / "report").is_file()


def test_a_comparison_without_it_is_as_before(runs: xr.Dataset, folder: Path, fmus: Fmus) -> None:
    """Nothing that ours put out changes in its presence."""
    beside = of_filter(runs, "ours")
    alone = of_filter(sim_scenarios.compare(scenario(folder, OURS), seed=4, fmus=fmus), "ours")
    assert set(alone) == set(beside)
    for name, values in alone.items():
        np.testing.assert_array_equal(beside[name].values, values.values, err_msg=str(name))


def test_it_runs_alone(runs: xr.Dataset, folder: Path, fmus: Fmus, tmp_path: Path) -> None:
    """What is said of the filter that is extended is not for it: the tables `filter` and `compare`."""
    text = SCENARIO.replace("[plant]", 'filter_fmu = "rivals/mine.fmu"\n[plant]')
    path = scenario(folder, f"[filter]\n{PARAMETERS}", text)
    loaded = load_scenario(path, fmus)
    assert len(loaded.filter) == 4
    assert loaded.filters() == {}
    run = sim_scenarios.run(path, seed=4, fmus=fmus)
    np.testing.assert_array_equal(run["nav.heading"], runs["nav.heading"].sel(filter="ours"))
    assert judge(run).to_json()["status"] is None
    assert np.isnan(run["position_error"]).all()
    assert report_run(run, tmp_path / "report").is_file()
    by_setting = sim_scenarios.run(
        "swaying_ship", set={"filter_fmu": str(folder / "rivals/mine.fmu"), "duration": 301.0}, fmus=fmus
    )
    assert json.loads(by_setting.attrs["settings"])["filter"] == {}


def test_a_limit_of_the_position_makes_it_a_navigation(fmus: Fmus, tmp_path: Path) -> None:
    outputs = ("nav.latitude", "nav.longitude", "nav.height")
    path = foreign(fmus.filter, tmp_path / "mine.fmu", outputs)
    text = SCENARIO.replace("stop = 20.0", "stop = 20.0, horizontal_limit = 40.0")
    text = text.replace("[plant]", f"filter_fmu = '{path}'\n[plant]")
    run = sim_scenarios.run(scenario(tmp_path, "[filter]\nerror_model = 'invariant'", text), fmus=fmus)
    verdict = judge(run)
    assert isinstance(verdict, NavigationVerdict)
    assert 0 < verdict.horizontal < 40
    assert np.isnan(verdict.yaw)
    assert report_run(run, tmp_path / "report").is_file()


def test_it_is_connected_by_the_names_that_it_has(fmus: Fmus, tmp_path: Path) -> None:
    """Without an input for the sigmas of fixes it takes its own, as a fix without sigmas says; with none of
    GNSS it sees no fix at all."""
    less = foreign(fmus.filter, tmp_path / "less.fmu", without=("gnss.fix_velocity_sigma",))
    blind = foreign(
        fmus.filter,
        tmp_path / "blind.fmu",
        ("nav.heading", "used_fixes"),
        without=[name for name in fmus.filter.arrays if name.startswith("gnss.")],
    )
    text = "".join(f"[compare.{p.stem}]\nfilter_fmu = '{p}'\n{PARAMETERS}" for p in (less, blind))
    runs = sim_scenarios.compare(scenario(tmp_path, OURS + text), seed=4, fmus=fmus)
    heading = {str(label): runs["nav.heading"].sel(filter=label).values for label in runs["filter"].values}
    np.testing.assert_array_equal(heading["less"], heading["ours"])
    assert (runs["used_fixes"].sel(filter="blind") == 0).all()
    assert (runs["used_fixes"].sel(filter="ours") > 0).any()
    assert not np.array_equal(heading["blind"], heading["ours"])


@pytest.mark.parametrize("master", ["python", "auto"])
def test_a_campaign_has_the_figures_of_a_comparison(
    runs: xr.Dataset, folder: Path, fmus: Fmus, master: str
) -> None:
    path = scenario(folder, OURS + THEIRS)
    results = campaign(path, folder / master, runs=1, seed=4, workers=1, master=master, fmus=fmus)
    alone = judged(runs)
    rmse = results["heading_rmse"].isel(scenario=0, run=0)
    for label, verdict in alone.items():
        assert float(rmse.sel(filter=label)) == verdict.to_json()["heading_rmse_arcmin"] * np.pi / 10800
    assert np.isnan(results["heading_sigma"].sel(filter="theirs")).all()
    (summary,) = summarise(results)
    heading, *rows = figures(summary)
    cells = dict(zip(heading, next(row for row in rows if row[0] == "theirs"), strict=True))
    assert (cells["NIS /\nchannel"], cells["NEES at\nthe end"]) == ("-", "-")


def test_filters_of_a_campaign_stand_relative_to_its_file(folder: Path, fmus: Fmus) -> None:
    path = folder / "campaign.toml"
    filters = (OURS + THEIRS).replace("compare.", "filters.")
    path.write_text(f'scenarios = ["zigzag"]\n{filters}', encoding="utf-8")
    (case,) = cases(load_plan(path), fmus)
    assert case.scenario.fmu_of("theirs") == str(folder / "rivals/mine.fmu")
    (only,) = cases(load_plan(path, filters=("theirs",)), fmus)
    assert list(only.filters()) == ["theirs"]


def test_a_campaign_notices_another_fmu_of_that_name(folder: Path, fmus: Fmus) -> None:
    path = scenario(folder, THEIRS)
    campaign(path, folder / "out", runs=1, workers=1, fmus=fmus)
    campaign(path, folder / "out", runs=1, workers=1, fmus=Fmus(fmus))  # goes on
    foreign(fmus.filter, folder / "rivals" / "mine.fmu", ("nav.heading", "nav.roll"))  # with the same GUID
    unread = Fmus({name: fmus[name] for name in ("TruthPlant", "AlignmentFilter")})
    with pytest.raises(InputError, match="other settings, figures or FMUs"):
        campaign(path, folder / "out", runs=1, workers=1, fmus=unread)


def test_one_that_fails_does_not_touch_the_others(folder: Path, fmus: Fmus) -> None:
    broken = THEIRS.replace("theirs", "broken") + "robust.gamma = -1.0\n"
    path = scenario(folder, OURS + broken)
    with pytest.raises(SimulationError, match=r"broken \(mine.fmu\) failed in initialisation: robust.gamma"):
        sim_scenarios.compare(path, fmus=fmus)
    results = campaign(path, folder / "out", runs=1, workers=1, fmus=fmus)
    assert dict(zip(results["filter"].values, results["state"].values.ravel(), strict=True)) == {
        "ours": 1,
        "broken": 2,
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (THEIRS + "gain = 3", "compare.theirs: mine.fmu has no parameter 'gain'"),
        (THEIRS.replace("mine", "nobody"), "compare.theirs: there is no FMU .*rivals/nobody.fmu"),
        (THEIRS.replace("rivals/mine", "mine"), "compare.theirs: .*mine.fmu is not an FMU"),
        (THEIRS.replace("theirs", "filter"), "compare.filter: that is what the filter of the scenario is"),
        ("[rivals.mine]\nfilter_fmu = 'rivals/mine.fmu'", "mine.toml: rivals: there is no such entry"),
    ],
)
def test_bad_entries_are_refused(folder: Path, fmus: Fmus, text: str, message: str) -> None:
    (folder / "mine.fmu").write_bytes(b"PK")
    with pytest.raises(InputError, match=message):
        load_scenario(scenario(folder, text), fmus)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ({"outputs": ("nav.roll",)}, "mine.fmu has no output nav.heading, which the verdict is about"),
        (
            {"changed": {"nav.heading": {"unit": "deg"}}},
            "its output nav.heading is in deg: must be in rad",
        ),
        (
            {"changed": {"imu.delta_angle": {"unit": "rad/s"}}},
            r"its input imu.delta_angle\[1\] is in rad/s: must be in rad",
        ),
    ],
)
def test_fmus_that_do_not_fit_are_refused(
    fmus: Fmus, tmp_path: Path, told: dict[str, object], message: str
) -> None:
    foreign(fmus.filter, tmp_path / "rivals" / "mine.fmu", **told)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=message):
        load_scenario(scenario(tmp_path, THEIRS), fmus)


def test_one_without_signals_is_refused(fmus: Fmus, tmp_path: Path) -> None:
    names = [name for name in fmus.filter.arrays if name.startswith(SIGNALS)]
    foreign(fmus.filter, tmp_path / "rivals" / "mine.fmu", without=names)
    with pytest.raises(InputError, match=r"mine.fmu has no input for signals of TruthPlant"):
        load_scenario(scenario(tmp_path, THEIRS), fmus)


@pytest.mark.parametrize(
    ("version", "kind", "message"),
    [
        ("3.0", "CoSimulation", "mine.fmu is an FMU of FMI 3.0: must be one of FMI 2.0 for co-simulation"),
        ("2.0", "ModelExchange", "mine.fmu is an FMU of FMI 2.0, without co-simulation: must be one of"),
    ],
)
def test_other_kinds_of_fmus_are_refused(
    fmus: Fmus, tmp_path: Path, version: str, kind: str, message: str
) -> None:
    members = {DESCRIPTION: NO_FMI_2.format(version=version, kind=kind)}
    write_archive(tmp_path / "rivals" / "mine.fmu", members)
    with pytest.raises(InputError, match=message):
        load_scenario(scenario(tmp_path, THEIRS), fmus)


def test_one_for_another_machine_is_refused_before_anything_runs(folder: Path, fmus: Fmus) -> None:
    path = folder / "rivals" / "mine.fmu"
    members = read_archive(path)
    write_archive(path, {"binaries/riscv/mine.so": b"", DESCRIPTION: members[DESCRIPTION]})
    with pytest.raises(InputError, match=r"rivals/mine.fmu has no binary for \S+; it has riscv"):
        load_scenario(scenario(folder, THEIRS), fmus)


def test_it_follows_no_alignment_and_is_not_exported(folder: Path, fmus: Fmus) -> None:
    head = SCENARIO.replace("swaying_ship", "align_then_navigate")
    with pytest.raises(InputError, match=r"compare.theirs: .*mine.fmu cannot follow an alignment"):
        load_scenario(scenario(folder, THEIRS, head), fmus)
    mine = {"filter_fmu": str(folder / "rivals/mine.fmu")}
    with pytest.raises(InputError, match=re.escape("swaying_ship: ") + ".*mine.fmu is not exported"):
        sim_scenarios.export("swaying_ship", folder / "out", set=mine, fmus=fmus)
