"""The examples run as they are, and find what they are there to show."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
TUTORIALS = {path.stem: path for path in (EXAMPLES.parent / "docs" / "tutorials").glob("[a-z]*.md")}
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")


def blocks(tutorial: str, language: str) -> list[str]:
    """What a tutorial shows in a language; a tutorial has the name of its example."""
    text = TUTORIALS[tutorial].read_text() if tutorial in TUTORIALS else ""
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def same(one: str, other: str) -> bool:
    """Whether two lines have the same words, and the same numbers but for the rounding of another machine."""
    words, numbers = zip(
        *((NUMBER.sub("#", x).split(), NUMBER.findall(x)) for x in (one, other)), strict=True
    )
    figures = [[float(number) for number in line] for line in numbers]
    return words[0] == words[1] and figures[0] == pytest.approx(figures[1], rel=0.01, abs=0.02)


def aligns(said: str) -> None:
    assert re.search(r"^Converged: heading RMSE [\d.]+ arcmin", said, re.MULTILINE)
    assert Path(re.search(r"^Pictures: (.*)$", said, re.MULTILINE)[1]).name == "report.html"


def shows_what_the_gate_is_worth(said: str) -> None:
    rmse = dict(re.findall(r"^(.*?)  +heading RMSE +([\d.]+) arcmin", said, re.MULTILINE))
    assert set(rmse) == {f"{one}, {gate}" for one in ("UKF", "robust UKF") for gate in ("gate", "no gate")}
    for one in ("UKF", "robust UKF"):
        assert 3 * float(rmse[f"{one}, gate"]) < float(rmse[f"{one}, no gate"])


def finds_the_heading_that_was_made(said: str) -> None:
    heading, sigma, made = map(
        float, re.search(r"is ([\d.]+) deg .* of ([\d.]+) deg; .* be ([\d.]+)", said).groups()
    )
    assert sigma < 0.2
    assert abs(heading - made) < 4 * sigma


def tells_intervals(said: str) -> None:
    for label in ("EKF", "UKF"):
        found = re.search(
            rf"^{label}: heading RMSE ([\d.]+) arcmin \(([\d.]+) to ([\d.]+)\) over 4 runs",
            said,
            re.MULTILINE,
        )
        value, lower, upper = map(float, found.groups())
        assert lower < value < upper


def aligns_within_its_sigma(said: str) -> None:
    error, sigma = map(float, re.search(r"error ([-+\d.]+) arcmin, sigma ([\d.]+)", said).groups())
    assert 5 < sigma < 30
    assert abs(error) < 4 * sigma


def aligns_on_the_ship_it_was_told(said: str) -> None:
    refused, off = map(float, re.search(r"refused (\d+) states and ends ([-+.e\d]+) m from", said).groups())
    assert refused == 0
    assert off < 1e-6
    aligns_within_its_sigma(said)


FINDS: dict[str, Callable[[str], None]] = {
    "first_alignment": aligns,
    "compare_filters": shows_what_the_gate_is_worth,
    "own_imu": finds_the_heading_that_was_made,
    "small_campaign": tells_intervals,
    "own_vehicle": aligns_on_the_ship_it_was_told,
    "fmpy_alone": aligns_within_its_sigma,
}


def test_every_example_is_run_and_listed() -> None:
    assert {path.stem for path in EXAMPLES.glob("*.py")} == FINDS.keys()
    listed = (EXAMPLES / "README.md").read_text()
    assert all(f"({name}.py)" in listed for name in FINDS)


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_shows_what_its_example_does(name: str) -> None:
    shown = blocks(name, "python")
    assert shown
    assert blocks(name, "text")
    script = (EXAMPLES / f"{name}.py").read_text()
    assert [block for block in shown if block not in script] == []


def test_another_figure_is_found() -> None:
    assert same("UKF:   heading RMSE  6.70 arcmin", "UKF: heading RMSE 6.71 arcmin")
    assert not same("UKF: heading RMSE 6.70 arcmin", "UKF: heading RMSE 6.90 arcmin")
    assert not same("UKF: heading RMSE 6.70 arcmin", "EKF: heading RMSE 6.70 arcmin")


@pytest.mark.parametrize("name", FINDS)
def test_an_example_runs_as_it_is(tmp_path: Path, name: str) -> None:
    command = [sys.executable, str(EXAMPLES / f"{name}.py")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=1200, check=False)
    assert done.returncode == 0, done.stderr
    FINDS[name](done.stdout)
    for line in "".join(blocks(name, "text")).splitlines():
        assert any(same(line, said) for said in done.stdout.splitlines()), line
