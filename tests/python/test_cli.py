"""The command line: exit codes, what stands where, words of refusal."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
from rich.console import Console
from typer.testing import CliRunner, Result

from sim_scenarios import catalogue, report
from sim_scenarios.cli import terminal
from sim_scenarios.cli.application import app
from sim_scenarios.cli.commands import COMMANDS, command
from sim_scenarios.cli.terminal import FEW, print_names, print_table, progress, say_messages
from sim_scenarios.version import product_version

SHORT = ["--set", "duration=60", "--set", "evaluation.start=30"]
LONG = ["--set", "duration=320"]


def truenorth(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.mark.parametrize("name", sorted(COMMANDS.keys() - {"list", "parameters", "verify"}))
def test_no_command_writes_into_a_folder_without_a_name(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`--output "$RESULTS"` of a variable that is not set would replace what lies in the own folder."""
    monkeypatch.chdir(tmp_path)
    result = truenorth(name, "swaying_ship", "--output", "")
    assert result.exit_code == 2
    assert "is empty" in result.output
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("fmus")
def test_run_converges(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *LONG, "--output", tmp_path)
    assert result.exit_code == 0
    for line in (
        "Converged: heading RMSE",
        "300 to 320 s",
        "arcmin (RMS over many runs; one run may lie below)",
        "eps_E / (w_ie cos L)",
    ):
        assert line in result.stdout
    assert str(tmp_path / "report.html") in result.stdout
    assert (tmp_path / "report.html").is_file()
    assert (tmp_path / "recording.nc").is_file()
    assert "100 %" in result.stderr
    assert "%" not in result.stdout


@pytest.mark.usefixtures("fmus")
def test_run_that_does_not_converge(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *SHORT, "--output", tmp_path)
    assert result.exit_code == 1
    assert "Not converged" in result.stdout


@pytest.mark.usefixtures("fmus")
def test_a_fault_is_set_and_named_beside_the_bound(tmp_path: Path) -> None:
    fault = ["fault.imu.kind=silence", "fault.imu.begin=40", "fault.imu.duration=5"]
    settings = [part for setting in fault for part in ("--set", setting)]
    result = truenorth("run", "swaying_ship", *SHORT, *settings, "--output", tmp_path)
    assert result.exit_code in (0, 1), result.stderr
    (line,) = (line for line in result.stdout.splitlines() if line.startswith("Bound leaves out"))
    assert line.split()[3:] == ["fault.imu.kind"]


@pytest.mark.usefixtures("fmus")
@pytest.mark.parametrize(
    ("command", "drawing", "verdict"),
    [
        ("run", "report_run", "Not converged"),
        ("compare", "report_comparison", "robust UKF"),
        ("bound", "report_bound", "Cramer-Rao bound"),
    ],
)
def test_what_was_found_stands_before_the_report_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, drawing: str, verdict: str
) -> None:
    def full(*_: object) -> Path:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(report, drawing, full)
    result = truenorth(command, "zigzag", *SHORT, "-o", tmp_path)
    assert result.exit_code == 2
    assert verdict in result.stdout
    assert "Report" not in result.stdout
    assert "No space left" in result.stderr


@pytest.mark.usefixtures("fmus")
def test_json_alone_stands_on_standard_output(tmp_path: Path) -> None:
    result = truenorth("run", "swaying_ship", *LONG, "--json", "--seed", 4, "-o", tmp_path)
    content = json.loads(result.stdout)
    assert content["seed"] == 4
    assert content["converged"] is True
    assert content["bound_arcmin"] == pytest.approx(17, abs=3)
    assert Path(content["report"]).is_file()


@pytest.mark.usefixtures("fmus")
def test_the_seed_decides(tmp_path: Path) -> None:
    figures = [
        json.loads(truenorth("run", "swaying_ship", *SHORT, "--json", "--seed", s, "-o", tmp_path).stdout)[
            "heading_rmse_arcmin"
        ]
        for s in (1, 1, 2)
    ]
    assert figures[0] == figures[1] != figures[2]


@pytest.mark.usefixtures("fmus")
def test_compare(tmp_path: Path) -> None:
    result = truenorth("compare", "swaying_ship_printed", *LONG, "-o", tmp_path)
    assert result.exit_code == 0
    for label in ("EKF", "UKF", "robust UKF (printed)", "robust UKF (rate-invariant)"):
        assert label in result.stdout
    words = " ".join(result.stdout.split())
    assert "4.3' cannot be a statistic of them" in words
    assert (tmp_path / "comparison.png").is_file()


@pytest.mark.usefixtures("fmus")
def test_compare_json(tmp_path: Path) -> None:
    result = truenorth("compare", "zigzag", *SHORT, "--json", "-o", tmp_path)
    filters = json.loads(result.stdout)["filters"]
    assert {"EKF", "UKF", "robust UKF"} <= set(filters)
    assert result.exit_code == 1


@pytest.mark.usefixtures("fmus")
def test_compare_makes_a_matrix_of_combinations_and_scenarios(tmp_path: Path) -> None:
    axes = ["--axis", "predictor=linearised,unscented", "--axis", "corrector=standard,h_infinity"]
    result = truenorth("compare", "swaying_ship", "waves", *SHORT, *axes, "--json", "-o", tmp_path)
    content = json.loads(result.stdout)
    assert list(content) == ["swaying_ship", "waves"]
    for scenario in content.values():
        filters = scenario["filters"]
        assert list(filters) == [
            "nominal EKF",
            *(f"{p}, {c}" for p in ("linearised", "unscented") for c in ("standard", "h_infinity")),
        ]
        assert filters["linearised, standard"] == filters["nominal EKF"]
        for one in filters.values():
            over = one["heading_rmse_arcmin"] / filters["nominal EKF"]["heading_rmse_arcmin"]
            assert one["over_nominal_ekf"] == pytest.approx(over)
        assert Path(scenario["report"]).is_file()


@pytest.mark.usefixtures("fmus")
def test_compare_of_scenarios_has_the_filters_of_each(tmp_path: Path) -> None:
    result = truenorth("compare", "zigzag", "gnss_outliers", *SHORT, "-o", tmp_path)
    lines = {line.split("  ")[0]: line.split() for line in result.stdout.splitlines()}
    name, figures = 2, 4  # words; with a mark behind the error of each that failed
    assert len(lines["nominal EKF"]) == name + figures + 2
    assert "UKF, no gate" in lines
    assert lines["EKF"][1] == lines["nominal EKF"][2]


@pytest.mark.usefixtures("fmus")
def test_bound(tmp_path: Path) -> None:
    result = truenorth("bound", "zigzag", "--json", "-o", tmp_path)
    content = json.loads(result.stdout)
    assert result.exit_code == 0
    assert content["bound_arcmin"] == pytest.approx(5.53, rel=0.03)
    assert content["heading_sigma_arcmin"][0] == pytest.approx(600)
    better = truenorth("bound", "zigzag", "--set", "gnss.velocity_sigma=0.02", "-o", tmp_path)
    assert "1.76 arcmin" in better.stdout
    assert "bound_any_arcmin" in content
    assert content["bound_any_arcmin"] is None  # its prior is 10 deg
    unknown = truenorth("bound", "any_heading", "-o", tmp_path).stdout
    assert "GNSS velocity and position" in unknown
    assert "Of errors of any size" in unknown
    wide = json.loads(truenorth("bound", "any_heading", "--json", "-o", tmp_path).stdout)
    assert wide["bound_any_arcmin"] == pytest.approx(wide["bound_arcmin"], rel=0.01)
    assert 0 < wide["bound_any_standard_error_arcmin"] < 0.01 * wide["bound_any_arcmin"]
    assert wide["heading_sigma_any_arcmin"][0] == pytest.approx(60 * 180 / 3**0.5, rel=0.001)
    assert len(wide["heading_sigma_any_arcmin"]) == len(wide["time_s"])


def test_list() -> None:
    said = truenorth("list").stdout
    assert all(name in said for name in ("swaying_ship", "filters_by_scenario", "Zhou 2011"))
    assert json.loads(truenorth("list", "--json").stdout) == catalogue.scenarios()
    assert json.loads(truenorth("list", "--campaigns", "--json").stdout) == catalogue.campaigns()
    only = truenorth("list", "--papers").stdout
    assert "zhou" in only
    assert "swaying_ship" not in only


SLOW = {"dask", "fmpy", "matplotlib", "numpy", "pydantic", "scipy", "xarray", "zarr"}


def said_at_once(arguments: list[str], **environment: str) -> str:
    """What the command says, having imported nothing that takes long."""
    code = (
        "import sys, sim_scenarios.cli as cli\n"
        "sys.argv[0] = 'truenorth'\n"
        "try: cli.main()\n"
        f"except SystemExit as end: print(end.code, sorted({SLOW} & sys.modules.keys()), file=sys.stderr)"
    )
    command, env = [sys.executable, "-c", code, *arguments], {**os.environ, **environment}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True, env=env)
    assert done.stderr.splitlines()[-1] == "0 []"
    return done.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        *(["--help"], ["list"], ["list", "--json"], ["--version"]),
        *([name, "--help"] for name in COMMANDS if name != "derive"),  # which has the name of an FMU
    ],
)
def test_what_answers_at_once_imports_nothing_that_takes_long(arguments: list[str]) -> None:
    assert said_at_once(arguments)


@pytest.mark.parametrize(
    ("words", "found"),
    [("run zig", "zigzag"), ("replay a.csv --zero", "--zero-velocity"), ("paper zha", "zhao")],
)
def test_a_completion_imports_nothing_that_takes_long(words: str, found: str) -> None:
    number = str(len(words.split()))
    environment = {"COMP_WORDS": f"truenorth {words}", "COMP_CWORD": number}
    assert said_at_once([], _TRUENORTH_COMPLETE="complete_bash", **environment) == f"{found}\n"


def imported_by(code: str, modules: set[str]) -> list[str]:
    """Those of the modules that a program has imported at its end."""
    command = [sys.executable, "-c", f"{code}\nimport sys; print(*sorted({modules} & sys.modules.keys()))"]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout.split()


def test_a_verdict_waits_neither_for_pictures_nor_for_a_scheduler(tmp_path: Path) -> None:
    code = (
        "import xarray\nfrom pathlib import Path\n"
        "from sim_scenarios import recording, report, simulation\n"
        f"recording.save(xarray.Dataset({{'one': ('time', [1.0])}}), Path({str(tmp_path / 'one.nc')!r}))"
    )
    assert imported_by(code, {"distributed", "matplotlib", "plotly", "scipy.interpolate"}) == []


def test_a_worker_of_a_campaign_loads_no_cluster() -> None:
    code = "from sim_scenarios.studies import execution"
    assert imported_by(code, {"dask", "distributed", "scipy.interpolate"}) == []


def test_the_help_tells_of_every_command_what_its_own_help_begins_with() -> None:
    said = " ".join(truenorth("--help").stdout.replace("│", " ").split())
    for name in COMMANDS:
        summary = " ".join((command(name).help or "").partition("\n\n")[0].replace("`", "").split())
        assert f"{name} {summary}" in said


def test_a_shell_completes_commands_options_and_scenarios(monkeypatch: pytest.MonkeyPatch) -> None:
    def completed(words: str, word: int) -> list[str]:
        monkeypatch.setenv("_TRUENORTH_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(word))
        return CliRunner().invoke(app, prog_name="truenorth").stdout.split()

    assert completed("truenorth pa", 1) == ["parameters", "paper"]
    assert "--output" in completed("truenorth run --", 2)
    assert completed("truenorth run zig", 2) == ["zigzag"]
    assert completed("truenorth compare waves zig", 3) == ["zigzag"]
    assert completed("truenorth run waves --seed 7 --json --out", 6) == ["--output"]
    assert completed("truenorth run waves zig", 3) == []
    assert completed("truenorth campaign fau", 2) == ["faults"]
    assert completed("truenorth campaign zig", 2) == ["zigzag"]
    assert completed("truenorth paper zh", 2) == ["zhao", "zhou"]


def test_version() -> None:
    assert truenorth("--version").stdout == f"truenorth {product_version()}\n"


@pytest.mark.usefixtures("fmus")
def test_quiet_and_verbose(tmp_path: Path) -> None:
    """Of a filter that is fed with values that are no numbers for 20 s."""
    fault = ["fault.imu.kind=not_a_number", "fault.imu.begin=5", "fault.imu.duration=20"]
    run = ["run", "swaying_ship", *SHORT, *(part for one in fault for part in ("--set", one)), "-o", tmp_path]
    quiet, normal, verbose = (truenorth(*how, *run) for how in (["-q"], [], ["-v"]))
    assert quiet.stdout == normal.stdout == verbose.stdout
    assert quiet.stderr == ""
    assert "swaying_ship: 100 %" in normal.stderr
    said = [line for line in verbose.stderr.splitlines() if not line.endswith(" %")]
    told = [line for line in normal.stderr.splitlines() if not line.endswith(" %")]
    assert said[:FEW] == told[:FEW]
    assert said
    assert len(said) <= FEW or told[-1] == f"... and {len(said) - FEW} more messages, in the report"


@pytest.mark.usefixtures("fmus")
def test_parameters() -> None:
    """As the model description has them: in their display units, with arrays in one line."""
    found = json.loads(truenorth("parameters", "gyro", "--json").stdout)
    assert set(found) == {"TruthPlant", "Playback", "AlignmentFilter", "NavigationFilter"}
    sigma = next(one for one in found["TruthPlant"] if one["name"] == "imu.gyro.bias_sigma")
    assert (sigma["unit"], sigma["default"], sigma["elements"]) == ("deg/h", ["0.05"], 1)
    assert (sigma["units"][0], sigma["tunable"]) == ("rad/s", False)
    noise = next(one for one in found["AlignmentFilter"] if one["name"] == "process.angle_random_walk")
    assert noise["tunable"]
    lines = truenorth("parameters", "AlignmentFilter", "corrector").stdout
    assert "standard, h_infinity" in lines
    assert "TruthPlant" not in lines
    assert "gnss.lever_arm (3)" in truenorth("parameters", "AlignmentFilter", "lever").stdout


@pytest.mark.usefixtures("fmus")
def test_a_scenario_of_the_folder_needs_no_toml(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_ship.toml").write_text('extends = "swaying_ship"\n')
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "zigzag.toml").write_text('extends = "turn"\n')
    own = json.loads(truenorth("run", "my_ship", *SHORT, "--json").stdout)
    assert own["scenario"] == "my_ship"
    assert catalogue.scenario_path("below/zigzag") == Path("below/zigzag.toml")
    assert catalogue.scenario_path("zigzag").parent == catalogue.SCENARIOS


@pytest.mark.usefixtures("fmus")
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["parameters", "gyroscope"],
            "no parameter of TruthPlant, Playback, AlignmentFilter, NavigationFilter has",
        ),
        (["parameters", "Plant", "gyro"], "there is no FMU 'Plant'; there are TruthPlant"),
        (["run", "swaying_shp"], "did you mean 'swaying_ship'"),
        (["run", "nowhere.toml"], "there is no scenario file nowhere.toml"),
        (["run", "swaying_ship", "--set", "robust.gama=1"], "did you mean 'robust.gamma'"),
        (
            ["run", "swaying_ship", "--set", "process.gyro_bias_random_walk=1"],
            "(of TruthPlant and AlignmentFilter)",
        ),
        (["run", "swaying_ship", "--set", "robust.gamma"], "write NAME=VALUE"),
        (["run", "swaying_ship", "--set", "prior.heading_sigma=10 mg"], "not in a unit"),
        (["run", "swaying_ship", "--set", "robust.gamma=-1"], "robust.gamma"),
        (["run", "swaying_ship", "--seed", "2147483648"], "not a whole number from 0 to 2147483647"),
        (["run", "swaying_ship", "--seed", "-1"], "seed: -1 is not a whole number from 0"),
        (["run", "swaying_ship", "--set", "motion.latitude=95 deg"], "motion.latitude = 95 deg: must be at"),
        (["run", "swaying_ship", "--set", "evaluation.heading_limit=-1 deg"], "must be greater than 0"),
        (["compare", "swaying_ship", "--set", "duration=-3"], "duration = -3 s"),
        (["compare", "zigzag", "--axis", "igg"], "write NAME=VALUE,VALUE"),
        (["compare", "zigzag", "--axis", "corrector=igg", "--axis", "corrector=igg"], "given before"),
        (["compare", "zigzag", "--axis", "corrector=igg,igg"], "give each value once"),
        (["compare", "zigzag", "--axis", "corrector=1,'1'"], "give each value once"),
        (["compare", "zigzag", "waves", "zigzag"], "zigzag, zigzag: each scenario must have a name"),
        (["compare", "zigzag", "nowhere.toml"], "there is no scenario file nowhere.toml"),
        (["compare", "zigzag", "--axis", "corrector=standart"], "settings: compare.standart: corrector:"),
        (["compare", "zigzag", "--axis", "error_model=loose"], "'loose' is none of"),
        (["bound", "swaying_ship", "--set", "gnss.velocity_sigma=0"], "the bound needs GNSS"),
        (["replay", "absent.csv", "--heading", "10"], "there is no recording absent.csv"),
        (["replay", "absent.csv", "--heading", "10", "--zero-velocity"], "LATITUDE,LONGITUDE,HEIGHT"),
        (["run"], "SCENARIO"),
        (["run", "swaying_ship", "--sed", "3"], "--sed"),
        (["run", "zigzag", "--set", "name=x"], "the setting name: name is no setting"),
        (["run", "zigzag", "--set", "compare.EKF.corrector=igg"], "compare is no setting"),
        (["run", "zigzag", "--set", "evaluation.start=700"], "evaluation.start = 700 s: must be at least 0"),
        (["run", "zigzag", "--set", "evaluation.stop=9"], "before evaluation.stop (9 s)"),
        (
            ["run", "zigzag", "--set", "duration=20.05", "--set", "evaluation.start=20.02"],
            "evaluation.start = 20.02 s: nothing is recorded from there to 20.05 s",
        ),
        (["run", "zigzag", "--set", "evaluation.heading_limit=0"], "evaluation.heading_limit = 0: must be"),
        (["replay", "absent.csv", "--heading-sigma", "-5"], "--heading-sigma -5: must be at least 0 deg"),
        (["replay", "absent.csv", "--course-speed", "-1"], "--course-speed -1: must be greater than 0 m/s"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(arguments: list[str], words: str) -> None:
    result = truenorth(*arguments)
    assert result.exit_code == 2
    assert words.lower() in " ".join(result.stderr.lower().split())
    assert "Traceback" not in result.output
    assert result.stdout == ""


@pytest.mark.usefixtures("fmus")
@pytest.mark.parametrize("folder", ["file", "file/below"])
def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").touch()
    result = truenorth("run", "swaying_ship", "-o", tmp_path / folder)
    assert result.exit_code == 2
    assert "file is not a folder" in " ".join(result.stderr.split())
    assert "25 %" not in result.stderr


@pytest.mark.usefixtures("fmus")
def test_results_without_a_folder_keep_earlier_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    pages = [json.loads(truenorth("bound", "turn", "--json").stdout)["report"] for _ in range(3)]
    names = ["turn-bound", "turn-bound-2", "turn-bound-3"]
    assert pages == [f"truenorth-results/{name}/report.html" for name in names]
    assert all(Path(page).is_file() for page in pages)
    truenorth("bound", "turn", "-o", "mine")
    assert (
        json.loads(truenorth("bound", "turn", "--json", "-o", "mine").stdout)["report"] == "mine/report.html"
    )


@pytest.mark.usefixtures("fmus")
def test_a_filter_that_coasts_at_the_end_has_not_converged(tmp_path: Path) -> None:
    outage = ["--set", "gnss.outage.begin=[305,0,0,0]", "--set", "gnss.outage.end=[1000,0,0,0]"]
    result = truenorth("run", "swaying_ship", *LONG, *outage, "-o", tmp_path)
    assert result.exit_code == 1
    assert "Not converged: the filter is coasting at the end" in result.stdout
    assert "gnss.outage.begin, gnss.outage.end" in result.stdout  # what the bound leaves out


@pytest.mark.usefixtures("fmus")
def test_notes_of_a_changed_scenario_say_that_it_is_changed(tmp_path: Path) -> None:
    changed = truenorth("compare", "zigzag", *SHORT, "-o", tmp_path).stdout
    assert "before duration, evaluation.start changed: The bound falls" in " ".join(changed.split())
    assert "changed:" not in truenorth("compare", "zigzag", "-o", tmp_path).stdout


def test_figures_stay_whole_at_80_columns(capsys: pytest.CaptureFixture[str]) -> None:
    """The widest table that a shipped scenario makes: the labels fold, no figure does."""
    cells = ["12.34", "0.98", "123.45", "12.34", "176 s", "1.23", "123"]
    heading = [
        "RMSE\n[']",
        "/\nbound",
        "largest\n[']",
        "sigma\n[']",
        "in limit\nsince",
        "NIS /\nchan.",
        "refused",
    ]
    rows = [["Filter", *heading], ["robust UKF, L = I (printed), and more of it", *cells]]
    print_table(rows, Console(width=80))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    assert any(all(cell in line for cell in cells) for line in lines)


@pytest.mark.parametrize("width", range(40, 240, 10))
def test_a_wide_table_loses_neither_names_nor_figures(capsys: pytest.CaptureFixture[str], width: int) -> None:
    """That of a campaign, which has a dozen columns."""
    titles = ["heading\nRMSE [arcmin]", "95 %\ninterval", "/ EKF\n(95 %)", *(f"figure {i}" for i in range(8))]
    spans = [f"0.09{i} (0.0000 to 13.7996)" for i in range(4)]
    cells = ["17.21", "15.30 to 19.36", "0.981 (0.942 to 1.021)", *spans, *(f"{i}.234" for i in range(4))]
    labels = ["robust UKF [ceiling]", "EKF"]
    print_table([["filter", *titles], *([label, *cells] for label in labels)], Console(width=width))
    out = capsys.readouterr().out
    assert "\u2026" not in out
    assert max(map(len, out.splitlines())) <= width
    assert all(out.count(cell) == len(labels) for cell in cells)
    assert all(word in out for word in ("robust", "[ceiling]"))


@pytest.mark.parametrize("label", ["UKF [tuned]", "UKF [/old]", "[red]UKF", r"UKF \[x]"])
def test_labels_stand_as_they_are(capsys: pytest.CaptureFixture[str], label: str) -> None:
    """None of it is markup, neither in tables nor in the title of a progress."""
    for printed in (print_table, print_names):
        printed([["Filter [1]", "RMSE"], [label, "1.23"]], Console(width=80))
        out = capsys.readouterr().out
        assert label in out
        assert "Filter [1]" in out


def test_a_progress_has_the_title_that_it_is_given(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "Console", lambda stderr: Console(stderr=stderr, force_terminal=True))
    with progress("imu [/1].csv") as advance:
        advance(1.0)
    assert "imu [/1].csv" in capsys.readouterr().err


def test_what_an_fmu_says_commands_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    said = "the start is far\x1b[2J, [bold] and \x9b2J"
    say_messages(xr.Dataset(attrs={"messages": json.dumps([said])}))
    assert capsys.readouterr().err == "the start is far\\x1b[2J, [bold] and \\x9b2J\n"


def test_names_are_whole_where_the_terminal_is_narrow(capsys: pytest.CaptureFixture[str]) -> None:
    rows = [["scenario", "what happens"], ["flight_accelerometer_fault", "words " * 40]]
    print_names(rows, Console(width=60))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 60
    assert lines[1].startswith("flight_accelerometer_fault")


@pytest.mark.usefixtures("fmus")
@pytest.mark.parametrize("imported", ["typer", "numpy", "pandas", "sim_scenarios.simulation"])
def test_an_interruption_ends_in_one_line(tmp_path: Path, imported: str) -> None:
    """While modules are imported, and when the run begins."""
    command = [sys.executable, "-X", "importtime", "-m", "sim_scenarios.cli", "run", "swaying_ship"]
    options = ["--set", "duration=100000", "-o", str(tmp_path)]
    with subprocess.Popen([*command, *options], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert any(line.split("|")[-1].strip() == imported for line in process.stderr)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "truenorth: interrupted" in said.splitlines()
    assert "Traceback" not in said


@pytest.mark.usefixtures("fmus")
def test_replay_shows_the_heading_over_time(tmp_path: Path) -> None:
    """A vehicle at rest, level and heading north on the equator, sensed without error."""
    n, rate, g = 6001, 7.292115e-5, 9.7803253359
    table = pd.DataFrame({"time": [0.01 * (i + 1) for i in range(n)]})
    for kind, vector in (("angle", (0, rate * 0.01, 0)), ("velocity", (0, 0, g * 0.01))):
        for axis, value in zip("xyz", vector, strict=True):
            table[f"delta_{kind}_{axis}"] = value
    table.to_csv(tmp_path / "still.csv", index=False)
    options = ["--heading", 5, "--zero-velocity", "--position", "0,0,0", "-o", tmp_path]
    result = truenorth("replay", tmp_path / "still.csv", *options)
    assert result.exit_code == 1  # one minute is too short
    assert "Heading at the end" in result.stdout
    content = json.loads(truenorth("replay", tmp_path / "still.csv", *options, "--json").stdout)
    assert content["headings"][0]["heading_deg"] == pytest.approx(5)
    end = content["headings"][-1]["heading_deg"]
    assert abs((end + 180) % 360 - 180) < 5

    never = truenorth("replay", tmp_path / "still.csv", *options, "--rate", 0.001)
    assert never.exit_code == 1
    assert "no fix came, it is waiting at the end" in never.stdout


@pytest.mark.parametrize("command", ["run", "compare", "bound", "replay"])
def test_help_teaches_with_examples(command: str) -> None:
    result = truenorth(command, "--help")
    assert result.exit_code == 0
    assert "For example" in result.stdout
    assert f"truenorth {command}" in result.stdout
    for option in ("--output", "--seed", "--set", "--json"):
        assert option in result.stdout


@pytest.mark.usefixtures("fmus")
def test_scenarios_of_one_name_are_refused_before_any_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the name that a file says, too, under which its results would be written."""
    monkeypatch.chdir(tmp_path)
    for folder, said in (("a", ""), ("b", ""), ("c", 'name = "my"\n')):
        Path(folder).mkdir()
        file = Path(folder, "other.toml" if said else "my.toml")
        file.write_text(f'extends = "waves"\n{said}', encoding="utf-8")
    for second in ("b/my.toml", "c/other.toml"):
        result = truenorth("compare", "a/my.toml", second)
        assert result.exit_code == 2
        assert f"a/my.toml, {second}: each scenario must have a name of its own" in result.stderr
        assert "%" not in result.stderr
