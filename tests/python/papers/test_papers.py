"""Papers: that their files name what there is, what stands beside what is printed, and the command."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_up import run_with
from typer.testing import CliRunner

from sim_scenarios.catalogue import papers
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics.folds import root_mean_square
from sim_scenarios.papers import Paper, load_paper
from sim_scenarios.papers.claims import Swept, Timed, points
from sim_scenarios.papers.page import draw, noise_scale
from sim_scenarios.papers.pictures import drawn
from sim_scenarios.papers.reproduction import Result, beside, plans
from sim_scenarios.scenario import load_scenario
from sim_scenarios.studies.ensemble import Ensemble
from sim_scenarios.studies.expectations import Expectations
from sim_scenarios.units import ARCMIN


@pytest.mark.parametrize("name", list(papers()))
def test_a_paper_names_scenarios_and_filters_that_exist(name: str, fmus: Fmus) -> None:
    paper = load_paper(name)
    for experiment in paper.experiment:
        scenario = load_scenario(experiment.scenario, fmus, settings=experiment.set)
        assert set(scenario.compare) >= set(experiment.labels())
        for table in experiment.expect:
            told = {figure for figures in table.figures.values() for figure in figures}
            assert set(table.why) <= told
            start, stop = table.window or (scenario.evaluation.start, scenario.evaluation.stop)
            assert 0 <= start < stop <= scenario.duration


def test_what_is_measured_stands_beside_what_is_printed() -> None:
    headings = {"UKF": [16.0, 12.0], "robust UKF": [8.0, 6.0]}
    runs = Ensemble(
        {
            label: [
                run_with([0.0, 1.0, 2.0], heading=np.array([600, one, one]) * ARCMIN, limit=30 * ARCMIN)
                for one in each
            ]
            for label, each in headings.items()
        }
    )
    table = Expectations(
        title="Fig. 3",
        window=(1.0, 2.0),
        figures={"UKF": {"heading": 16.9, "settling": "late"}, "robust UKF / UKF": {"heading": 0.25}},
        why={"heading": "so it is."},
    )
    result = beside(table, runs)
    interval = root_mean_square([16.0, 12.0])
    assert result.cells() == [
        ["Filter", "Figure", "Paper", "Here", "95 %", "Single runs"],
        [
            "UKF",
            "heading RMSE [']",
            "16.9",
            "14.1",
            f"{interval.lower:.3g} to {interval.upper:.3g}",
            "12 to 16",
        ],
        ["UKF", "heading settled [s]", "late", "1", "", "1 to 1"],
        ["robust UKF / UKF", "heading RMSE", "0.25", "0.5", "0.5 to 0.5", ""],
    ]
    assert result.differences == ["heading RMSE: so it is."]
    json.dumps(result.to_json(), allow_nan=False)


def test_a_figure_that_there_is_not_is_refused() -> None:
    with pytest.raises(ValueError, match="there is no figure 'headings'; did you mean 'heading'"):
        Expectations(figures={"UKF": {"headings": 1.0}})


def test_a_paper_that_there_is_not_is_refused() -> None:
    with pytest.raises(InputError, match="there is no paper 'zou'; did you mean 'zhou'"):
        load_paper("zou")


def test_a_single_run_has_no_interval() -> None:
    runs = Ensemble({"UKF": [run_with([0.0, 1.0], heading=12 * ARCMIN)]})
    (row,) = beside(Expectations(figures={"UKF": {"heading": 16.9}}), runs).rows
    assert row.measured == pytest.approx(12)
    assert row.interval is None


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"experiment": "nowhere"}, "there is no experiment 'nowhere'"),
        ({"filters": ["UFK"]}, "there is no filter 'UFK'; did you mean 'UKF'"),
        ({"panels": ["heding"]}, "there is no panel 'heding'; did you mean 'heading'"),
        ({"panels": []}, "at least 1 item"),
    ],
)
def test_a_picture_of_what_there_is_not_is_refused(change: dict[str, object], reason: str) -> None:
    picture = {"experiment": "e", "kind": "run", "panels": ["heading"], **change}
    table = {"title": "t", "figures": {"UKF": {"heading": 1.0}}}
    content = {
        "name": "p",
        "citation": "c",
        "verdict": "v",
        "runs": 1,
        "figure": [{"number": "Fig. 1", "shows": "s", "here": "h", "picture": [picture]}],
        "experiment": [{"name": "e", "scenario": "swaying_ship", "cost": 1.0, "expect": [table]}],
    }
    with pytest.raises(ValueError, match=reason):
        Paper.model_validate(content)


def with_noise(run: xr.Dataset, used: list[float], sigma: float) -> xr.Dataset:
    """A run whose filter has estimated the noise of its fixes, at some instants [s], as one sigma for all."""
    names = {"units": "m m m m/s m/s m/s"}
    return run.assign(
        measurement_sigma_estimate=(("fix", "axis6"), np.full((len(used), 6), sigma), names),
        fix_used=("fix", np.ones(len(used), dtype=bool)),
    ).assign_coords(fix_time=("fix", used))


def made_up() -> Ensemble:
    """Two runs of three instants: velocity errors 1, 2, 3 and 3, 2, 1 m/s, sigmas of 8 m."""
    true = ("time", "axis3"), np.array([[10.0, 0, 0], [20.0, 0, 0], [30.0, 0, 0]])
    runs = [
        run_with([0.0, 1.0, 2.0], window=(1.0, 2.0), velocity=np.outer(errors, [1, 0, 0]))
        for errors in ([1, 2, 3], [3, 2, 1])
    ]
    fixes = ([0.0, 2.0], [0.0, 1.0, 2.0])
    return Ensemble(
        {
            "UKF": [
                with_noise(run, used, 8.0).assign({"truth.velocity": true})
                for run, used in zip(runs, fixes, strict=True)
            ]
        }
    )


@pytest.mark.parametrize(
    ("kind", "panel", "x", "y"),
    [
        ("run", "velocity_east", [0, 1, 2], [1, 2, 3]),
        ("run", "sigma_height", [0, 2], [8, 8]),
        ("value", "value_velocity_east", [0, 1, 2], [11, 22, 33]),
        ("rms", "velocity_east", [0, 1, 2], np.sqrt([5.0, 4.0, 5.0])),
        ("distribution", "velocity_east", np.sqrt([2.5, 6.5]), [0.5, 1.0]),
    ],
)
def test_what_is_drawn_is_what_was_measured(kind: str, panel: str, x: object, y: object) -> None:
    runs = made_up()
    picture = drawn(runs, kind, [panel], ["UKF"], None, lambda name: told_velocity(runs, name))
    curves = {line.get_label(): line for line in picture.axes[0].get_lines()}
    assert ("true" in curves) == (kind == "value")
    np.testing.assert_allclose(curves["UKF"].get_xdata(), np.asarray(x, dtype=float))
    np.testing.assert_allclose(curves["UKF"].get_ydata(), np.asarray(y, dtype=float))


def told_velocity(runs: Ensemble, panel: str) -> np.ndarray | None:
    return runs.first["truth.velocity"].values[:, 0] if panel.startswith("value") else None


def test_an_estimate_stands_beside_what_is_true_and_not_upon_it() -> None:
    picture = drawn(made_up(), "value", ["sigma_height"], ["UKF"], None, lambda _: np.full(3, 5.0))
    curves = {line.get_label(): line.get_ydata().tolist() for line in picture.axes[0].get_lines()}
    assert curves == {"true": [5.0, 5.0, 5.0], "UKF": [8.0, 8.0]}


def test_a_window_cuts_curve_and_truth_alike() -> None:
    runs = made_up()
    picture = drawn(
        runs, "value", ["value_velocity_east"], ["UKF"], (1.0, 2.0), lambda name: told_velocity(runs, name)
    )
    for line in picture.axes[0].get_lines():
        np.testing.assert_array_equal(line.get_xdata(), [1.0, 2.0])


def test_the_true_noise_of_fixes_is_equation_21_of_jing_2023(fmus: Fmus) -> None:
    plant = load_scenario("flight_varying_noise", fmus).plant
    time = np.array([0.0, 599.0, 600.0, 1199.0, 1200.0, 2400.0, 2700.0, 2900.0, 3000.0])
    expected = [1, 1, 6, 6, 1, 1, 10, 1 + 9 * np.sin(2 * np.pi * 500 / 1200), 1]
    scale = noise_scale(time, lambda entry: float(plant[f"gnss.noise_scale.{entry}"]))
    np.testing.assert_allclose(scale, expected, rtol=1e-12)


@pytest.mark.parametrize("name", list(papers()))
def test_the_list_names_every_figure(name: str) -> None:
    result = CliRunner().invoke(app, ["paper", name, "--list", "--json"])
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["figures"]
    assert [row["number"] for row in rows] == [figure.title for figure in load_paper(name).figure]
    assert all(row["in_the_paper"] and row["here"] for row in rows)


@pytest.mark.parametrize("name", list(papers()))
def test_every_picture_is_drawn(name: str, fmus: Fmus) -> None:
    """Of errors that are made up: that the curves of each figure exist, and lie in a file of their own."""
    paper = load_paper(name)
    pictures = []
    for experiment in paper.experiment:
        scenario = load_scenario(experiment.scenario, fmus, settings=experiment.set)
        time = np.arange(0.0, scenario.duration + 5.0, 10.0)
        rng = np.random.default_rng(1)
        window = scenario.evaluation.start, scenario.evaluation.stop
        made = [
            run_with(
                time,
                window=window,
                heading=rng.standard_normal(len(time)),
                **{
                    name: rng.standard_normal((len(time), 3)) for name in ("attitude", "velocity", "position")
                },
            ).assign({"truth.velocity": (("time", "axis3"), np.ones((len(time), 3)))})
            for _ in range(2)
        ]
        runs = Ensemble(
            {
                label: [with_noise(run, time[1:].tolist(), 3.0) for run in made]
                for label in experiment.labels()
            }
        )
        result = Result(experiment, scenario, runs, [])
        pictures += draw(paper, result)
    assert len(pictures) == len(paper.pictures())
    assert len({drawn.file for drawn in pictures}) == len(pictures)
    for picture in pictures:
        assert picture.content[:4] == b"\x89PNG"


@pytest.mark.usefixtures("fmus")
def test_the_command(tmp_path: Path) -> None:
    command = ["paper", "zhao", "--seed", "5", "--json", "-o", str(tmp_path)]
    result = CliRunner().invoke(app, [*command, "-n", "1"])
    assert result.exit_code == 0, result.output
    paper = load_paper("zhao")
    cases = 3 + sum(len(sweep.values) for sweep in paper.sweep)
    assert f"zhao: {cases} of {cases} runs to do" in result.stderr
    content = json.loads(result.stdout)
    assert (content["paper"], content["runs"], content["seed"]) == ("zhao", 1, 5)
    assert len(content["tables"]) == 3 + 1 + 2  # of what is printed, of times, of sweeps
    headings = [
        row
        for table in content["tables"]
        for row in table.get("rows", [])
        if row.get("figure") == "heading" and row["unit"] == "'"
    ]
    assert [row["printed"] for row in headings] == [19.475, 16.403, 24.817, 20.639, 20.06, 19.97]
    assert all(0 < row["measured"] < 60 for row in headings)
    assert all(row["interval"] is None for row in headings)
    pictures = paper.pictures()
    assert len(content["pictures"]) == len(pictures) == len(set(content["pictures"]))
    assert all(Path(picture).is_file() for picture in content["pictures"])
    page = Path(content["report"]).read_text(encoding="utf-8")
    assert page.count("<table>") == len(content["tables"])
    assert page.count("data:image/png;base64,") == len(pictures) + len(paper.sweep)

    tables = (tmp_path / "measured.md").read_text(encoding="utf-8")
    assert "`truenorth paper zhao -n 1 --seed 5`" in tables
    assert all(table["title"] in tables for table in content["tables"])
    assert len(re.findall(r"^\|(?: --- \|)+$", tables, re.MULTILINE)) == len(content["tables"])

    # What is done is kept, and is the same when it is read again.
    files = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs/*/*.nc")}
    assert len(files) == cases
    again = CliRunner().invoke(app, [*command, "-n", "2"])
    assert f"zhao: {cases} of {2 * cases} runs to do" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in files} == files
    first = [row["smallest_and_largest_run"] for row in headings]
    both = [
        row["smallest_and_largest_run"]
        for table in json.loads(again.stdout)["tables"]
        for row in table.get("rows", [])
        if row.get("figure") == "heading" and row["unit"] == "'"
    ]
    assert all(alone[0] in pair for alone, pair in zip(first, both, strict=True))
    assert all(pair[0] < pair[1] for pair in both)


def test_another_setting_is_another_folder(tmp_path: Path, fmus: Fmus) -> None:  # noqa: ARG001
    paper = load_paper("li")
    changed = paper.experiment[0].model_copy(update={"set": {"gnss.rate": 2.0}})
    other = paper.model_copy(update={"experiment": (changed, *paper.experiment[1:])})
    one, two = ([plan.kept for plan in plans(each, [1], tmp_path).all] for each in (paper, other))
    assert one[0] != two[0]
    assert one[1:] == two[1:]


def test_an_experiment_without_its_recording_is_left_out_and_named(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    fmus: Fmus,  # noqa: ARG001
) -> None:
    monkeypatch.setenv("TRUENORTH_RECORDINGS", str(tmp_path))
    planned = plans(load_paper("zhou"), [1], tmp_path)
    assert "recorded" not in [plan.experiment.name for plan in planned.experiments]
    (sentence,) = planned.left_out
    assert "parked_vehicle_rlg.csv.gz is not in the folder" in sentence


def test_a_sweep_puts_each_value_where_it_belongs(tmp_path: Path, fmus: Fmus) -> None:  # noqa: ARG001
    paper = load_paper("zhao")
    planned = plans(paper, range(1, 3), tmp_path)
    (sweep, first), _ = planned.sweeps
    assert [len(plan.seeds) for plan in first] == [2] * len(sweep.values)
    errors = [plan.scenario.initial_error.misalignment for plan in first]
    np.testing.assert_allclose([np.rad2deg(error[2]) for error in errors], sweep.values)
    np.testing.assert_allclose([np.rad2deg(error[:2]) for error in errors], [[10, 20]] * len(errors))
    assert [planned.swept_by(plan) for plan in first] == [(sweep, value) for value in sweep.values]


def test_runs_that_stay_within_the_limit_have_converged() -> None:
    headings = [[3.0, 0.5, 0.5, 0.5], [3.0, 3.0, 0.5, 0.5], [3.0, 0.5, 0.5, 3.0]]
    runs = Ensemble({"EKF": [run_with(np.arange(4.0), window=(2.0, 3.0), heading=h) for h in headings]})
    sweep = load_paper("zhao").sweep[0].model_copy(update={"filters": ("EKF",), "values": (30.0,)})
    (point,) = points(sweep, 30.0, runs)
    assert (point.runs, point.settled) == (3, 2.0)
    assert point.converged.value == pytest.approx(2 / 3)
    swept = Swept(sweep, [point])
    assert swept.cells()[1][:3] == ["30", "EKF", "2 of 3"]
    json.dumps(swept.to_json(), allow_nan=False)


def test_times_stand_beside_what_is_said_of_them() -> None:
    experiment = load_paper("zhao").experiment[0]
    timed = Timed(experiment, {"EKF": 2e-6, "UKF": 5e-6})
    assert [row[2] for row in timed.cells()[1:]] == ["2.0 us", "5.0 us", "2.50"]


def test_an_interrupted_paper_goes_on_in_the_same_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without --output, too; and says where the runs are."""
    monkeypatch.chdir(tmp_path)
    folders: list[Path] = []

    def stopped(_: object, __: object, folder: Path) -> None:
        folders.append(folder)
        (folder / "runs").mkdir(exist_ok=True)
        raise KeyboardInterrupt

    monkeypatch.setattr("sim_scenarios.papers.reproduction.plans", stopped)
    for _ in range(2):
        result = CliRunner().invoke(app, ["paper", "zhou"])
        assert "in truenorth-results/paper-zhou runs that are done are kept" in result.stderr
    assert folders == [Path("truenorth-results/paper-zhou")] * 2
