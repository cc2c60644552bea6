"""The site of the pages: built without a warning, whole, and readable without a network."""

from __future__ import annotations

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from browser import WINDOWS, browser_is_there, fits, opened
from playwright.sync_api import Browser, expect
from reading import read

import sim_scenarios

pytest.importorskip("furo", reason="the site's tools are not installed")
pytest.importorskip("myst_parser", reason="the site's tools are not installed")

ROOT = Path(__file__).parents[2]
FETCHED = {"src", "srcset", "poster", "data"}
"""Attributes whose addresses a browser asks for by itself; of `link` also `href`."""


def build(source: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """As `make docs` does."""
    command = [
        *(sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going"),
        *("-d", folder / "doctrees", "-c", ROOT / "docs" / "site", source, folder / "site"),
    ]
    return subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)


class Html(HTMLParser):
    """What a page refers to, and what can be referred to in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.anchors = {""}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors.add(given.get("id", ""))
        self.links += [given["href"]] if tag == "a" and "href" in given else []
        self.fetched += [given[name] for name in FETCHED & given.keys()]
        self.fetched += [given["href"]] if tag == "link" else []


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("built")
    done = build(ROOT, folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "site"


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Html]:
    return {path: Html(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def elsewhere(address: str) -> bool:
    return re.match(r"(?:\w+:)?//", address) is not None


def test_every_page_of_the_index_is_there(site: Path) -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        assert (site / page.relative_to(ROOT)).with_suffix(".html").is_file()


def test_every_link_leads_somewhere(pages: dict[Path, Html]) -> None:
    def lost(page: Path, address: str) -> bool:
        name, _, anchor = address.partition("#")
        target = (page.parent / unquote(name.partition("?")[0])).resolve() if name else page
        if target in pages:
            return unquote(anchor) not in pages[target].anchors
        return not target.is_file()

    assert len(pages) > 30
    assert not [
        (page.name, address)
        for page, html in pages.items()
        for address in (*html.links, *html.fetched)
        if not elsewhere(address) and not address.startswith(("data:", "mailto:")) and lost(page, address)
    ]


def test_nothing_is_fetched_from_elsewhere(site: Path, pages: dict[Path, Html]) -> None:
    assert not [address for html in pages.values() for address in html.fetched if elsewhere(address)]
    styles = [path.read_text(encoding="utf-8") for path in site.rglob("*.css")]
    assert styles
    asked = re.compile(r"(?:@import\s+|url\(\s*)['\"]?(?:\w+:)?//")
    assert not [style for style in styles if asked.search(style)]


def test_a_page_that_asks_elsewhere_is_found() -> None:
    html = Html(
        '<link href="https://a/b.css"><script src="//a/b.js"></script><img src="c.png"><a href="https://d">'
    )
    assert [address for address in html.fetched if elsewhere(address)] == ["https://a/b.css", "//a/b.js"]


def test_what_python_offers_is_explained(pages: dict[Path, Html], site: Path) -> None:
    explained = {name.removeprefix("module-") for name in pages[site / "docs" / "python.html"].anchors}
    assert {f"sim_scenarios.{name}" for name in sim_scenarios.__all__} <= explained


def test_every_parameter_has_its_row(site: Path) -> None:
    page = (site / "docs" / "parameters.html").read_text(encoding="utf-8")
    rows = [re.findall(r">([^<>\n]+)<", row) for row in re.findall(r"<tr.*?</tr>", page, re.DOTALL)]
    assert ["imu.gyro.white_noise", "deg/h^0.5", "0.005"] in [row[:3] for row in rows]
    shown = {row[0] for row in rows}
    for name in ("TruthPlant", "Playback", "AlignmentFilter", "NavigationFilter"):
        declared = read(ROOT / "modelDescription" / f"{name}.toml")
        assert {variable.name for variable in declared.of("parameter", "tunable")} <= shown


def test_what_is_broken_fails(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(
        "# Home\n\n[page](docs/nowhere.md) [file](docs/nothing.py) [anchor](docs/README.md#never)\n"
    )
    (tmp_path / "docs" / "README.md").write_text("# Index\n")
    (tmp_path / "docs" / "forgotten.md").write_text("# Forgotten\n")
    done = build(tmp_path, tmp_path / "built")
    assert done.returncode == 1
    for broken in ("nowhere.md", "nothing.py", "never", "forgotten.md"):
        assert len(re.findall(rf"WARNING: .*{broken}|{broken}: WARNING", done.stderr)) == 1, done.stderr


SHOWN = ("README", "docs/status", "docs/verification", "docs/python", "docs/parameters")


@browser_is_there
@pytest.mark.parametrize(("width", "scheme"), WINDOWS)
def test_pages_as_a_browser_shows_them(site: Path, chromium: Browser, width: int, scheme: str) -> None:
    for name in SHOWN:
        address = (site / f"{name}.html").as_uri()
        with opened(chromium, address, width, scheme, site.as_uri()) as page:
            fits(page, scheme)


@browser_is_there
def test_what_is_searched_is_found_without_a_server(site: Path, chromium: Browser) -> None:
    with opened(chromium, (site / "index.html").as_uri(), 1280, site=site.as_uri()) as page:
        page.wait_for_url("**/README.html")
        page.get_by_placeholder("Search").fill("standstill")
        page.keyboard.press("Enter")
        page.locator("#search-results a", has_text="Aids").first.click()
        expect(page.locator("h1")).to_contain_text("Aids")
