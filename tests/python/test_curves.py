"""Curves of the page of a run: those of its data set, thinned, and drawn by the script of the page."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from drawn import drawn, node_is_there

from sim_scenarios import curves
from sim_scenarios.recording import of_filter
from sim_scenarios.report import report_comparison, report_run
from sim_scenarios.units import ARCMIN

LARGEST = 4_000_000
"""Bytes of a page beyond its pictures: plotly.js has 2 MB of them, compressed."""


@pytest.fixture(scope="module")
def page(ship: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> str:
    return report_run(ship, tmp_path_factory.mktemp("curves")).read_text(encoding="utf-8")


def content(page: str) -> list[curves.Panel]:
    found: list[curves.Panel] = json.loads(page.split('id="content">')[1].split("</script>")[0])
    return found


def test_the_page_has_the_curves_of_the_data_set(page: str, ship: xr.Dataset) -> None:
    panels = {panel["title"]: panel for panel in content(page)}
    heading = panels["Heading error, with 3 sigma of the filter"]
    [error, bound] = heading["curves"]
    rows = np.searchsorted(ship["time"].values, np.array(error["x"]) - 1e-6)
    assert len(rows) > 1000
    np.testing.assert_allclose(error["x"], ship["time"].values[rows], rtol=1e-4)
    np.testing.assert_allclose(error["y"], ship["heading_error"].values[rows] / ARCMIN, rtol=1e-4)
    np.testing.assert_allclose(error["upper"], 3 * ship["heading_sigma"].values[rows] / ARCMIN, rtol=1e-4)
    np.testing.assert_allclose(error["lower"], -np.array(error["upper"]))
    assert bound["y"][-1] == pytest.approx(ship["bound.heading_sigma"].values[-1] / ARCMIN, rel=0.05)
    assert "Velocity north: error with 3 sigma" in panels
    assert "Gyro bias up: error with 3 sigma" in panels
    assert len(panels["NIS / channels of each fix"]["curves"][0]["x"]) == ship.sizes["fix"]


def test_what_is_seen_first_is_what_the_filter_settles_to(page: str) -> None:
    [error, _] = content(page)[0]["curves"]
    low, high = content(page)[0]["range"]
    late = np.array(error["x"]) >= 120.0  # a fifth of the run
    for edge in ("lower", "y", "upper"):
        assert low < np.array(error[edge])[late].min()
        assert np.array(error[edge])[late].max() < high
    assert high == pytest.approx(np.array(error["upper"])[late].max(), rel=0.2)
    assert high < max(error["upper"]) / 3


def test_the_page_is_bounded(page: str, ship: xr.Dataset) -> None:
    """As is that of a run ten times as long."""
    pictures = sum(len(part.split('"', 1)[0]) for part in page.split("base64,")[1:])
    assert len(page) - pictures < LARGEST
    over_time = [name for name, values in ship.items() if "time" in values.dims and "truth" not in str(name)]
    panels = curves.of_replay(xr.concat([ship[over_time]] * 10, "time"))
    assert sum(len(v) for p in panels for c in p["curves"] for v in c.values() if isinstance(v, list)) <= (
        curves.MOST_NUMBERS
    )
    assert all(len(c["x"]) <= curves.MOST_POINTS for p in panels for c in p["curves"])


def test_what_is_no_number_is_left_out(ship: xr.Dataset) -> None:
    broken = ship.copy(deep=True)
    broken["heading_error"][::3] = np.nan
    curve = curves.of_run(broken)[0]["curves"][0]
    assert curve["y"].count(None) == pytest.approx(len(curve["y"]) / 3, abs=1)
    json.dumps(curve, allow_nan=False)


@node_is_there
def test_the_script_draws_what_is_chosen(page: str) -> None:
    panels = content(page)
    chosen = next(i for i, p in enumerate(panels) if p["title"].startswith("NIS"))
    shown = drawn(page, ("panel", str(chosen)))
    assert shown["options"]["panel"] == [panel["title"] for panel in panels]
    assert "plotly.js" in shown["ran"]
    first, second = shown["drawn"]
    lower, upper, error, bound = first["data"]
    assert (lower["y"], upper["y"]) == tuple(panels[0]["curves"][0][edge] for edge in ("lower", "upper"))
    assert upper["fill"] == "tonexty"
    assert [error["y"], bound["y"]] == [curve["y"] for curve in panels[0]["curves"]]
    assert error["line"]["color"] != bound["line"]["color"]
    assert first["layout"]["yaxis"]["title"]["text"] == "arcmin"
    assert first["layout"]["showlegend"]
    assert second["layout"]["yaxis"]["type"] == "log"
    assert second["data"][0]["y"] == panels[chosen]["curves"][0]["y"]


@node_is_there
def test_filters_beside_each_other(outliers: xr.Dataset, tmp_path: Path) -> None:
    shown = drawn(report_comparison(outliers, tmp_path).read_text(encoding="utf-8"))
    [plot] = shown["drawn"]
    assert [line["name"] for line in plot["data"]] == [str(label) for label in outliers["filter"].values]
    last = of_filter(outliers, plot["data"][1]["name"])["heading_error"].values / ARCMIN
    step = -(-len(last) // curves.MOST_POINTS)
    np.testing.assert_allclose(plot["data"][1]["y"], last[::step], rtol=1e-4)
