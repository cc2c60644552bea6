"""The page of a campaign in headless Chromium: no error, curves that follow the switches, right figures."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator
from pathlib import Path

import browser
import pytest
import xarray as xr
from browser import browser_is_there
from drawn import drawn, node_is_there
from playwright.sync_api import Browser, Page

from sim_scenarios.studies import page as campaign_page
from sim_scenarios.studies import table
from sim_scenarios.studies.findings import found
from sim_scenarios.studies.statistics import CaseSummary, summarise
from sim_scenarios.studies.store import State, open_results
from sim_scenarios.units import ARCMIN


@pytest.fixture(scope="module")
def data(results_folder: Path) -> xr.Dataset:
    return open_results(results_folder)


@pytest.fixture(scope="module")
def cases(data: xr.Dataset) -> list[CaseSummary]:
    return list(summarise(data))


@pytest.fixture(scope="module")
def files(
    data: xr.Dataset, cases: list[CaseSummary], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str]:
    return campaign_page.write(data, cases, tmp_path_factory.mktemp("page"))


@pytest.fixture(scope="module", params=[1280, 390])
def opened(chromium: Browser, files: dict[str, str], request: pytest.FixtureRequest) -> Iterator[Page]:
    """The page in a window of a width, without network; ends with a look at what the console said."""
    with browser.opened(chromium, Path(files["report"]).as_uri(), request.param) as page:
        page.wait_for_selector("#nis .main-svg")
        yield page


def curves(opened: Page, plot: str) -> list[str]:
    """Names of the curves of a plot that have a drawn path."""
    names = opened.evaluate(f"document.getElementById('{plot}').data.flatMap(trace => trace.name || [])")
    paths = browser.paths(opened, plot)
    assert len(paths) == len(names)
    assert all(len(path) > 20 for path in paths)
    return list(names)


def choose(opened: Page, control: str, value: str) -> None:
    opened.select_option(f"#{control}", label=value)


@browser_is_there
def test_curves_are_drawn_and_follow_the_switches(opened: Page) -> None:
    for plot in ("error", "runs", "nees", "nis"):
        assert set(curves(opened, plot)) - {"bound"} == {"EKF", "UKF"}
    opened.get_by_label("EKF", exact=True).uncheck()
    for plot in ("error", "runs", "nees", "nis"):
        assert "EKF" not in curves(opened, plot)
    opened.get_by_label("EKF", exact=True).check()
    opened.get_by_label("median to 90th percentile").check()
    assert len(opened.evaluate("document.getElementById('error').data")) == 7  # two areas of two edges each
    opened.get_by_label("median to 90th percentile").uncheck()
    choose(opened, "quantity", "Velocity")
    assert curves(opened, "error") == ["EKF", "UKF"]  # the bound is that of the heading
    assert opened.locator("#error .ytitle").text_content() == "m/s"
    choose(opened, "quantity", "Heading")
    choose(opened, "case", "overconfident_prior gnss.rate=1.0")
    assert curves(opened, "error") == ["bound", "UKF"]
    choose(opened, "case", "zigzag gnss.rate=1.0")


@browser_is_there
def test_hovering_shows_figures_and_a_box_zooms(opened: Page) -> None:
    box = opened.locator("#error .nsewdrag").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    opened.mouse.move(x, y)
    opened.wait_for_selector("#error .hoverlayer .hovertext")
    assert "UKF" in str(opened.locator("#error .hoverlayer").text_content())
    whole = opened.evaluate("document.getElementById('error').layout.xaxis.range")
    opened.mouse.down()
    opened.mouse.move(x + box["width"] / 4, y + 60, steps=4)
    opened.mouse.up()
    part = opened.evaluate("document.getElementById('error').layout.xaxis.range")
    assert part[1] - part[0] == pytest.approx((whole[1] - whole[0]) / 4, rel=0.1)


@browser_is_there
def test_the_curves_are_those_of_the_data_set(opened: Page, data: xr.Dataset) -> None:
    drawn = opened.evaluate(
        "Array.from(document.getElementById('error').data.find(trace => trace.name === 'UKF').y)"
    )
    one = data.sel(scenario="zigzag gnss.rate=1.0", filter="UKF")
    rms = (one["heading_error"] ** 2).mean("run").values ** 0.5
    assert drawn == pytest.approx((rms / ARCMIN).tolist(), rel=1e-4)


@browser_is_there
def test_the_tables_have_the_figures_of_the_data_set(opened: Page, cases: list[CaseSummary]) -> None:
    for i, case in enumerate(cases):
        for j, rows in enumerate((table.figures(case), table.certainty(case), table.errors(case))):
            shown = opened.locator("section").nth(i).locator("table").nth(j).locator("tbody tr")
            texts = shown.evaluate_all(
                "rows => rows.map(row => [...row.cells].map(cell => cell.textContent))"
            )
            assert texts == rows[1:]


@browser_is_there
def test_nothing_is_wider_than_the_window(opened: Page) -> None:
    width = opened.evaluate("innerWidth")
    browser.fits(opened, "light")
    plot = opened.locator("#error .main-svg").first.bounding_box()
    assert plot is not None
    assert 0.8 * width - 40 < plot["width"] <= width


@browser_is_there
def test_the_plots_follow_a_dark_screen(opened: Page) -> None:
    opened.emulate_media(color_scheme="dark")
    opened.wait_for_function("() => document.getElementById('error').layout.font.color === '#e6edf3'")
    browser.fits(opened, "dark")
    opened.emulate_media(color_scheme="light")
    opened.wait_for_function("() => document.getElementById('error').layout.font.color === '#24292f'")


@node_is_there
def test_the_script_draws_all_plots_of_a_case(files: dict[str, str]) -> None:
    """Without a browser: no filter is switched on, the bound stays."""
    shown = drawn(Path(files["report"]).read_text(encoding="utf-8"))
    assert [plot["id"] for plot in shown["drawn"]] == ["error", "runs", "nees", "nis"]
    assert [curve["name"] for curve in shown["drawn"][0]["data"]] == ["bound"]
    assert "Heading" in shown["options"]["quantity"]


def test_pictures_and_table_lie_beside_the_page(files: dict[str, str], cases: list[CaseSummary]) -> None:
    folder = Path(files["report"]).parent
    names = {path.name for path in folder.iterdir()}
    for case in cases:
        stem = case.label.replace(" ", "_")
        assert {f"{stem}.png", f"{stem}.svg"} <= names
    first = Path(files["table"]).read_text(encoding="utf-8").strip().split("\n\n")[0]  # that of the RMSE
    heading, _, *lines = [line for line in first.splitlines() if line.startswith("|")]
    assert [cell.strip() for cell in heading.split("|")[2:-1]] == ["EKF", "UKF", "bound"]
    assert [line.split("|")[1].strip() for line in lines] == [
        f"{case.label}: heading [arcmin]" for case in cases
    ]


def test_the_page_opens_with_what_was_found(
    files: dict[str, str], data: xr.Dataset, cases: list[CaseSummary]
) -> None:
    text = Path(files["report"]).read_text(encoding="utf-8")
    said = html.unescape(text.split('<p class="verdict">')[1].split("</p>")[0])
    assert said == found(data, cases)
    assert "30 runs failed" in said
    assert text.index('class="verdict"') < text.index("<form") < text.index("<table")


def test_the_page_names_the_command_of_a_run_alone(files: dict[str, str]) -> None:
    text = Path(files["report"]).read_text(encoding="utf-8")
    assert "truenorth compare zigzag --seed 3" in text
    assert "--set gnss.rate=2.0" in text


def test_a_campaign_whose_runs_all_failed_has_a_page(data: xr.Dataset, tmp_path: Path) -> None:
    failed = data.assign(state=xr.full_like(data["state"], State.failed))
    written = campaign_page.write(failed, list(summarise(failed)), tmp_path)
    assert "<td>5 / 5</td>" in Path(written["report"]).read_text(encoding="utf-8")


def test_labels_cannot_end_the_script(data: xr.Dataset, tmp_path: Path) -> None:
    sly = data.assign_coords(filter=["</script><b>", "UKF"])
    written = campaign_page.write(sly, list(summarise(sly))[:1], tmp_path)
    text = Path(written["report"]).read_text(encoding="utf-8")
    content = text.split('id="content">')[1].split("</script>")[0]
    assert json.loads(content)["filters"][0] == "</script><b>"
