"""Scenarios and campaigns that leave their folder or make no sense: refused, and nothing is written."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest
from damage import refusals
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.scenario import load_scenario
from sim_scenarios.studies.cases import cases
from sim_scenarios.studies.plan import load_plan

NAMES = ["../..", "/abs", "a/b", "..", ".x", "-x", "a\\b", "a b", "a\nb", "a\x1b[2J", "a\x00", "x" * 300, ""]
SIGMAS = {
    "bound": ["tilt", "heading", "velocity", "gyro_bias", "accelerometer_bias", "position"],
    "initial_error": ["misalignment", "velocity", "position"],
}
NUMBERS_OF_DIGITS = [10**400, "9" * 5000, int("f" * 5000, 16)]
NO_NUMBERS = [float("nan"), float("inf"), "1e999 s", "nan s", True, [], *NUMBERS_OF_DIGITS]


def toml_string(text: str) -> str:
    return '"' + "".join(f"\\u{ord(one):04x}" for one in text) + '"'


def scenario(folder: Path, file_name: str = "x.toml", **entries: str) -> Path:
    file = folder / file_name
    lines = ['description = "Given"', 'extends = "zigzag"', *(f"{k} = {v}" for k, v in entries.items())]
    file.write_text("\n".join(lines), encoding="utf-8")
    return file


def files(folder: Path) -> set[Path]:
    return set(folder.rglob("*"))


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_keeps_to_the_rule_of_names(fmus: Fmus, tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"name: .* must have letters"):
        load_scenario(scenario(tmp_path, name=toml_string(name)), fmus)


@pytest.mark.parametrize("file", ["...toml", ".x.toml", "a b.toml", "-x.toml", f"{'x' * 101}.toml"])
def test_a_file_name_is_a_name_unless_there_is_another(fmus: Fmus, tmp_path: Path, file: str) -> None:
    with pytest.raises(InputError, match=r"name: .* must have letters"):
        load_scenario(scenario(tmp_path, file), fmus)
    assert load_scenario(scenario(tmp_path, file, name='"mine"'), fmus).name == "mine"


@pytest.mark.parametrize("label", ["a\\nb", "a\\u001b[2J", "\\u0000", " ", "x" * 300])
def test_a_scenario_keeps_to_the_rule_of_labels(fmus: Fmus, tmp_path: Path, label: str) -> None:
    file = scenario(tmp_path)
    file.write_text(f'{file.read_text()}\n[compare."{label}"]\ncorrector = "standard"\n', encoding="utf-8")
    with pytest.raises(InputError, match="label"):
        load_scenario(file, fmus)


@pytest.mark.parametrize("entry", ["description", "notes"])
def test_texts_have_no_control_characters(fmus: Fmus, tmp_path: Path, entry: str) -> None:
    file = tmp_path / "x.toml"
    file.write_text(f'extends = "zigzag"\n{entry} = "a\\u001b[2J"', encoding="utf-8")
    with pytest.raises(InputError, match=f"{entry}: has the control character"):
        load_scenario(file, fmus)


@pytest.mark.parametrize("name", NAMES)
def test_a_campaign_keeps_to_the_rule_of_names(tmp_path: Path, name: str) -> None:
    file = tmp_path / "plan.toml"
    file.write_text(f'scenarios = ["zigzag"]\nname = {toml_string(name)}', encoding="utf-8")
    with pytest.raises(InputError, match=r"name: .* must have letters"):
        load_plan(file)


@pytest.mark.parametrize("command", ["run", "export", "compare", "bound", "campaign"])
def test_nothing_is_written_outside(
    fmus: Fmus,  # noqa: ARG001
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
) -> None:
    work = tmp_path / "a" / "b"
    work.mkdir(parents=True)
    monkeypatch.chdir(work)
    file = scenario(work, name='"../../outside\\u001b[2J"')
    before = files(tmp_path)
    result = CliRunner().invoke(app, [command, str(file)])
    assert result.exit_code == 2
    assert "must have letters" in " ".join(result.stderr.split())
    assert "\x1b" not in result.output
    assert files(tmp_path) == before


@pytest.mark.parametrize(("table", "name"), [(t, name) for t, names in SIGMAS.items() for name in names])
def test_a_sigma_is_not_negative(fmus: Fmus, table: str, name: str) -> None:
    entry = f"{table}.{name}_sigma"
    given: object = -1e-9 if table == "bound" else [0.0, -1e-9, 0.0]
    with pytest.raises(InputError, match=rf"{entry}\S*: -1e-09: a sigma must be at least 0"):
        load_scenario("zigzag", fmus, settings={entry: given})


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: str(type(value)))
@pytest.mark.parametrize("name", ["duration", "bound.tilt_sigma", "gnss.rate", "seed"])
def test_what_is_no_number_is_refused(fmus: Fmus, name: str, value: object) -> None:
    with pytest.raises(InputError) as refused:
        load_scenario("zigzag", fmus, settings={name: value})
    assert len(str(refused.value)) < 500


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"duration": 1e15}, "duration = 1e+15 s: must be at most 100000000 times the communication_step"),
        ({"communication_step": 1e-12}, "must be at most 100000000 times the communication_step of 1e-12 s"),
        ({"recording_period": 1e9}, "must be at least one recording_period"),
        ({"recording_period": 0.0}, "recording_period = 0 s: must be greater than 0"),
        ({"recording_period": -1.0}, "must be greater than 0"),
        ({"recording_period": 1e-6, "communication_step": 1e-5}, "times the recording_period"),
    ],
)
def test_times_without_measure_are_refused(fmus: Fmus, settings: dict[str, object], words: str) -> None:
    with pytest.raises(InputError) as refused:
        load_scenario("zigzag", fmus, settings=settings)
    assert words in str(refused.value)


@pytest.mark.parametrize("runs", [2**31 - 1, 10**9, 10**400, 0, -1])
def test_runs_without_measure_are_refused(runs: int) -> None:
    with pytest.raises(InputError, match="runs: input should be"):
        load_plan("zigzag", runs=runs)


def test_a_grid_without_measure_is_refused(fmus: Fmus) -> None:
    grid = {f"gnss.velocity_sigma[{i}]": [0.1 + k for k in range(100)] for i in (1, 2, 3)}
    with pytest.raises(InputError, match="makes 1000000 cases, must make at most 10000"):
        cases(load_plan("zigzag", grid=grid), fmus)


def test_files_that_extend_each_other_by_two_names(fmus: Fmus, tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    one, other = tmp_path / "one.toml", tmp_path / "other.toml"
    one.write_text(f'extends = "{tmp_path}/below/../other.toml"', encoding="utf-8")
    other.write_text(f'extends = "{tmp_path}/below/../one.toml"', encoding="utf-8")
    with pytest.raises(InputError, match="extends this file in turn"):
        load_scenario(one, fmus)


def test_damaged_scenarios_are_read_or_refused(fmus: Fmus, tmp_path: Path) -> None:
    shipped = resources.files("sim_scenarios") / "scenarios" / "swaying_ship.toml"
    (tmp_path / "ship.toml").write_bytes(shipped.read_bytes())
    assert len(refusals(lambda path: load_scenario(path, fmus), tmp_path / "ship.toml")) > 50


def test_damaged_campaigns_are_read_or_refused(fmus: Fmus, tmp_path: Path) -> None:
    shipped = resources.files("sim_scenarios") / "campaigns" / "heading_unknown.toml"
    (tmp_path / "any.toml").write_bytes(shipped.read_bytes())
    assert len(refusals(lambda path: cases(load_plan(path), fmus), tmp_path / "any.toml")) > 50
