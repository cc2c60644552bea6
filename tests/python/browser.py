"""Pages in headless Chromium: opened in a window of a size and a scheme, with an ear for what goes wrong."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Browser, Page, expect

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
]
PATIENCE = 300_000  # ms; a busy machine is no failure
WINDOWS = [(1280, "light"), (390, "dark")]  # both widths, both schemes: neither depends on the other
PAPERS = {"light": "rgb(255, 255, 255)", "dark": "rgb(13, 17, 23)"}

browser_is_there = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed: page not tested")


@contextmanager
def opened(
    chromium: Browser, address: str, width: int, scheme: str = "light", site: str | None = None
) -> Iterator[Page]:
    """A page that asks nobody but itself, or its site; at the end the console must have been silent."""
    context = chromium.new_context(viewport={"width": width, "height": 900}, offline=address[:5] == "file:")
    page = context.new_page()
    page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    page.set_default_timeout(PATIENCE)
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda r: None if r.url.startswith((site or address, "data:")) else said.append(r.url))
    page.goto(address)
    yield page
    assert said == []
    context.close()


def fits(page: Page, scheme: str) -> None:
    """Nothing is wider than the window, every picture is there, the paper has the colour of the scheme."""
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    broken = "[...document.images].filter(image => !(image.complete && image.naturalWidth)).length"
    assert page.evaluate(broken) == 0
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == PAPERS[scheme]


def paths(page: Page, plot: str) -> list[str]:
    """What is drawn of each curve of a plot."""
    lines = page.locator(f"#{plot} .scatterlayer .trace .js-line")
    return lines.evaluate_all(
        "all => all.filter(l => parseFloat(l.style.strokeWidth)).map(l => l.getAttribute('d'))"
    )


def ranges(page: Page, plot: str) -> list[list[float]]:
    """What of x and y is seen of a plot."""
    return page.evaluate(
        f"['xaxis', 'yaxis'].map(axis => [...document.getElementById('{plot}')._fullLayout[axis].range])"
    )


def chooses_and_zooms(page: Page) -> None:
    """Every panel of the curves of a run is drawn, can be read and zoomed into, and comes back."""
    page.wait_for_selector("#curve .main-svg")
    titles = page.locator("#panel option").all_text_contents()
    assert len(titles) > 5
    before: list[str] = []
    for title in (titles[-1], titles[0], titles[2]):
        page.select_option("#panel", label=title)
        shown = paths(page, "curve")
        assert shown != before
        assert all(len(path) > 20 for path in shown)
        before = shown
        legend, below = page.locator("#curve .legend"), page.locator("#curve .xtitle").bounding_box()
        if legend.count():
            names = legend.bounding_box()
            assert names is not None
            assert below is not None
            assert names["y"] + names["height"] < below["y"]
    page.locator("#curve").scroll_into_view_if_needed()
    box = page.locator("#curve .nsewdrag").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    expect(page.locator("#curve .hoverlayer .hovertext").first).to_be_visible(timeout=PATIENCE)
    whole = ranges(page, "curve")
    page.mouse.down()
    page.mouse.move(x + box["width"] / 4, y + 60, steps=4)
    page.mouse.up()
    part = ranges(page, "curve")
    assert part[0][1] - part[0][0] == pytest.approx((whole[0][1] - whole[0][0]) / 4, rel=0.1)
    page.locator('#curve .modebar-btn[data-title="Reset axes"]').click()
    assert ranges(page, "curve") == [pytest.approx(one) for one in whole]
