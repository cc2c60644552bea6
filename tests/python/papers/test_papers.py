"""Papers: that their files name what there is, what stands beside what is printed, and the command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.ensemble import COLUMNS, HEADING, Ensemble, Errors
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.papers import Printed, load_paper, shipped
from sim_scenarios.papers.reproduction import beside
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import ARCMIN


@pytest.mark.parametrize("name", list(shipped()))
def test_a_paper_names_scenarios_and_filters_that_exist(name: str, fmus: Fmus) -> None:
    paper = load_paper(name)
    for experiment in paper.experiment:
        scenario = load_scenario(experiment.scenario, fmus, settings=experiment.set)
        assert set(scenario.compare) >= set(experiment.labels())
        for table in experiment.table:
            told = {figure for figures in table.printed.values() for figure in figures}
            assert table.differences.keys() <= told
            start, stop = table.window or (scenario.evaluation.start, scenario.evaluation.stop)
            assert 0 <= start < stop <= scenario.duration


def test_what_is_measured_stands_beside_what_is_printed() -> None:
    headings = {"UKF": [16.0, 12.0], "robust UKF": [8.0, 6.0]}
    filters = {}
    for label, each in headings.items():
        values = np.zeros((2, 3, COLUMNS))
        values[:, 1:, HEADING] = np.array(each)[:, None] * ARCMIN
        values[:, 0, HEADING] = 600 * ARCMIN
        filters[label] = Errors(np.array([0.0, 1.0, 2.0]), values, 30 * ARCMIN)
    runs = Ensemble(filters, {"evaluation.start": 0.0, "evaluation.stop": 2.0})
    table = Printed(
        title="Fig. 3",
        window=(1.0, 2.0),
        printed={"UKF": {"heading": 16.9, "settling": "late"}, "robust UKF / UKF": {"heading": 0.25}},
        differences={"heading": "so it is."},
    )
    result = beside(table, runs)
    assert result.cells() == [
        ["Filter", "Figure", "Paper", "Here", "Single runs"],
        ["UKF", "heading RMSE [']", "16.9", "14.1", "12 to 16"],
        ["UKF", "heading settled [s]", "late", "1", "1 to 1"],
        ["robust UKF / UKF", "heading RMSE", "0.25", "0.5", ""],
    ]
    assert result.differences == ["heading RMSE: so it is."]
    json.dumps(result.to_json(), allow_nan=False)


def test_a_figure_that_there_is_not_is_refused() -> None:
    with pytest.raises(ValueError, match="there is no figure 'headings'; did you mean 'heading'"):
        Printed(title="", printed={"UKF": {"headings": 1.0}})


def test_a_paper_that_there_is_not_is_refused() -> None:
    with pytest.raises(InputError, match="there is no paper 'zou'; did you mean 'zhou'"):
        load_paper("zou")


@pytest.mark.usefixtures("fmus")
def test_the_command(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["paper", "zhao", "-n", "1", "--seed", "5", "--json", "-o", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert (content["paper"], content["runs"], content["seed"]) == ("zhao", 1, 5)
    assert len(content["tables"]) == 3
    headings = [
        row
        for table in content["tables"]
        for row in table["rows"]
        if row["figure"] == "heading" and row["unit"] == "'"
    ]
    assert [row["printed"] for row in headings] == [19.475, 16.403, 24.817, 20.639, 20.06, 19.97]
    assert all(0 < row["measured"] < 60 for row in headings)
    page = Path(content["report"]).read_text(encoding="utf-8")
    assert page.count("<table>") == 3
    assert page.count("data:image/png;base64,") == 3
    assert (tmp_path / "static_large_misalignment.png").is_file()
