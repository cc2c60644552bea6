"""The page of a run that goes on: for who knows its address, on this machine, until the run has ended."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest
from browser import WINDOWS, browser_is_there, fits, opened, paths
from playwright.sync_api import Browser

from sim_scenarios.live.looks import Look
from sim_scenarios.live.server import Story, served

OTHER = "example.org"


def look(time: float) -> Look:
    heading = math.radians(350 + time)
    return Look(time, 20.0, heading % math.tau, 0.1 / (1 + time), 0.0, "aligning", (time, -time), (time, 0.0))


def asked(address: str, below: str = "", host: str | None = None) -> tuple[int, str]:
    """Status and text of an answer."""
    url = urlsplit(address)
    connection = HTTPConnection(str(url.hostname), url.port, timeout=60)
    connection.request("GET", url.path + below, headers={"Host": host or url.netloc})
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


@pytest.fixture
def story() -> Story:
    return Story()


@pytest.fixture
def address(story: Story) -> Iterator[str]:
    with served("<swaying>", story) as where:
        yield where


def test_the_page_is_for_who_knows_where_it_is(address: str) -> None:
    status, text = asked(address)
    assert status == 200
    assert "&lt;swaying&gt;" in text
    assert "connect-src &#39;self&#39;" in text
    url = urlsplit(address)
    assert url.hostname == "127.0.0.1"
    assert len(url.path) > 30
    root = f"{url.scheme}://{url.netloc}"
    for elsewhere in (f"{root}/", f"{root}/looks", address[:-2] + "/", f"{address}page"):
        assert asked(elsewhere)[0] == 404
    for below in ("", "looks"):
        assert asked(address, below, host=f"{OTHER}:{url.port}")[0] == 404  # a name that leads here


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root, for another user")
def test_another_user_sees_nothing(address: str) -> None:
    """Who connects, but does not know the address."""
    url = urlsplit(address)
    code = f"""
import os, http.client, encodings.idna  # what is needed later, too: others may not read Python
os.setgroups([]); os.setgid(65534); os.setuid(65534)
connection = http.client.HTTPConnection("{url.hostname}", {url.port}, timeout=60)
for path in ("/", "/looks", "/../", "//", "*"):
    connection.request("GET", path)
    answer = connection.getresponse()
    assert (answer.status, b"swaying" in answer.read()) == (404, False), path
"""
    done = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_late_reader_is_told_all_and_that_it_has_ended(story: Story) -> None:
    for time in range(3):
        story.tell(look(float(time)))
    story.end()
    told, end, rest = "".join(story.events()).split("\n\n")
    looks = json.loads(told.removeprefix("data: "))
    assert [one["time"] for one in looks] == [0.0, 1.0, 2.0]
    assert looks[1]["heading"] == pytest.approx(351)
    assert looks[1]["error"] == pytest.approx(-9)
    assert (looks[1]["place"], looks[1]["true_place"]) == ([1.0, -1.0], [1.0, 0.0])
    assert (end, rest) == ("event: end\ndata:", "")


def test_what_is_not_known_is_null(story: Story) -> None:
    nan = math.nan
    story.tell(Look(0.0, 1.0, nan, nan, 0.0, "", (nan, nan), (0.0, 0.0)))
    [one] = json.loads(next(story.events()).removeprefix("data: "))
    assert one["heading"] is one["sigma"] is one["error"] is None
    assert one["place"] == [None, None]


def test_at_the_end_it_is_gone(story: Story) -> None:
    with served("ship", story) as address:
        pass
    with pytest.raises(ConnectionError):
        asked(address)


@browser_is_there
@pytest.mark.parametrize(("width", "scheme"), WINDOWS)
def test_the_page_follows_the_run(story: Story, chromium: Browser, width: int, scheme: str) -> None:
    with served("ship", story) as address, opened(chromium, address, width, scheme) as page:
        for time in range(12):
            story.tell(look(float(time)))
        page.wait_for_function("() => document.getElementById('time').textContent.startsWith('11.0')")
        assert page.locator("#status").text_content() == "aligning"
        assert page.locator("#heading").text_content() == "1.000 deg"
        fits(page, scheme)
        for plot in ("headings", "errors", "track"):
            assert len([path for path in paths(page, plot) if path]) >= 2  # a gap where an error is zero
        before = paths(page, "errors")
        story.tell(look(15.0))
        page.wait_for_function("() => document.getElementById('time').textContent.startsWith('15.0')")
        assert paths(page, "errors") != before
        headings = page.evaluate("[...document.getElementById('headings').data[0].y]")
        assert headings == pytest.approx([*range(-10, 2), 5])  # without a leap at north
        story.end()
        page.wait_for_function("() => document.getElementById('state').textContent.includes('has ended')")
