"""The report: complete, self-contained, and with the figures of the run."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

import sim_scenarios
from sim_scenarios.fmus import Fmus
from sim_scenarios.metrics import alignment, judge
from sim_scenarios.metrics.navigation import NavigationVerdict
from sim_scenarios.report import (
    RUN,
    bound_table,
    comparison_table,
    report_bound,
    report_comparison,
    report_run,
)
from sim_scenarios.units import ARCMIN

PNG = b"\x89PNG\r\n\x1a\n"
VOID = {"meta", "img", "link", "br", "input", "source"}


class Structure(HTMLParser):
    """Open tags, which must close in order, and what the page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "srcset")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def page(ship: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return report_run(ship, tmp_path_factory.mktemp("report"))


def test_the_page_is_well_formed_and_loads_nothing(page: Path) -> None:
    structure = Structure()
    structure.feed(page.read_text(encoding="utf-8"))
    assert structure.open == []
    assert len(structure.loads) == len(RUN)
    assert all(load.startswith("data:image/png;base64,") for load in structure.loads)
    assert not re.search(r"https?:", re.sub(r"base64,[^\"]*", "", page.read_text(encoding="utf-8")))


def test_the_pictures_of_the_page_are_the_files_beside_it(page: Path) -> None:
    embedded = re.findall(r"data:image/png;base64,([^\"]+)", page.read_text(encoding="utf-8"))
    files = [(page.parent / f"{drawing.name}.png").read_bytes() for drawing in RUN]
    assert [base64.b64decode(text) for text in embedded] == files
    assert all(content.startswith(PNG) for content in files)


def test_the_page_says_what_the_run_was_worth(page: Path, ship: xr.Dataset) -> None:
    text = page.read_text(encoding="utf-8")
    verdict = alignment.judge(ship)
    assert f"{verdict.heading_rmse / ARCMIN:.2f} arcmin" in text
    assert f"{ship.attrs['bound.heading_rms'] / ARCMIN:.2f} arcmin (RMS over many runs" in text
    assert "13.48 arcmin, eps_E / (w_ie cos L)" in text
    assert verdict.sentence() in text
    assert "filter: converged at" in text  # what the FMU said
    assert "prefers-color-scheme: dark" in text
    assert 'name="viewport"' in text


def test_comparison(outliers: xr.Dataset, tmp_path: Path) -> None:
    text = report_comparison(outliers, tmp_path).read_text(encoding="utf-8")
    verdicts = {
        str(label): alignment.judge(outliers.sel(filter=label)) for label in outliers["filter"].values
    }
    heading, *rows = comparison_table(verdicts)
    assert len(rows) == 4
    for row, verdict in zip(rows, verdicts.values(), strict=True):
        assert len(row) == len(heading)
        assert row[1] == f"{verdict.heading_rmse / ARCMIN:.2f}"
        cells = [f'<th scope="row">{row[0]}</th>', *(f"<td>{cell}</td>" for cell in row[1:])]
        assert "".join(cells) in text
    assert (tmp_path / "comparison.png").read_bytes().startswith(PNG)


def test_a_run_with_rejected_fixes_is_drawn(outliers: xr.Dataset, tmp_path: Path) -> None:
    run = outliers.sel(filter="robust UKF, gate")
    text = report_run(run, tmp_path).read_text(encoding="utf-8")
    assert f"{int(run['used_fixes'][-1])}, {int(run['rejected_fixes'][-1])}" in text


def test_an_alignment_that_measures_positions_too_is_drawn(fmus: Fmus, tmp_path: Path) -> None:
    settings = {"duration": 110.0, "evaluation.start": 50.0}
    run = sim_scenarios.run("any_heading", set=settings, fmus=fmus)
    assert (run["innovation_sigma"].values > 0).any(axis=0).all()  # three velocities, three positions
    report_run(run, tmp_path)
    assert (tmp_path / "innovations.png").read_bytes().startswith(PNG)


def test_bound(fmus: Fmus, tmp_path: Path) -> None:
    data = sim_scenarios.bound("turn", fmus=fmus)
    page = report_bound(data, tmp_path)
    assert "No filter knows the heading better than 5." in page.read_text(encoding="utf-8")
    table = bound_table(data)
    assert table[1] == ["0", "600.00", "600.00"]  # with the turn and without
    assert table[-1][0] == "600"


def test_a_filter_in_the_place_of_the_navigation_filter_is_judged_as_one(fmus: Fmus, tmp_path: Path) -> None:
    """The alignment filter takes its position from GNSS, so that it is as good as a fix and no better."""
    stand_in = Fmus({**fmus, "NavigationFilter": fmus.filter})
    settings = {"filter_fmu": "NavigationFilter", "duration": 120.0, "evaluation.start": 60.0}
    run = sim_scenarios.run("swaying_ship", set=settings, fmus=stand_in)
    verdict = judge(run)
    assert isinstance(verdict, NavigationVerdict)
    assert verdict.limit == pytest.approx(5 * 2**0.5)
    assert verdict.horizontal == pytest.approx(verdict.limit, rel=0.5)
    assert verdict.sentence() in report_run(run, tmp_path).read_text(encoding="utf-8")
    assert (tmp_path / "navigation.png").is_file()
