"""Pages hold what they show, load nothing, and run no script but their own."""

from __future__ import annotations

import base64
import hashlib
import re

import pytest

from sim_scenarios.html import policy, render, source

SLY = "<script>alert(1)</script>"


@pytest.fixture
def campaign() -> str:
    """The page of a campaign without cases."""
    script = source("campaign.js")
    return render(
        "campaign.html",
        **{"title": SLY, "description": SLY, "found": SLY, "runs": 1, "seed": 1, "cases": []},
        **{"expected": [], "reasons": [], "about": {}, "content": "{}", "plotly": ""},
        **{"script": script, "scripts": [script, "plotly"]},
    )


def allowed(page: str) -> str:
    found = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', page)
    assert found is not None
    assert page.index("<style>") > found.start()  # a policy holds for what stands behind it
    assert not re.search(r"<(script|link|img)", page[: found.start()])
    return found[1].replace("&#39;", "'")


def digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_the_policy_names_the_scripts_of_the_page_and_no_others(campaign: str) -> None:
    scripts = re.findall(r"<script>(.*?)</script>", campaign, flags=re.DOTALL)
    assert len(scripts) == 1
    rules = dict(rule.split(" ", 1) for rule in allowed(campaign).split("; "))
    assert rules["script-src"].split() == [digest(scripts[0]), digest("plotly")]
    assert rules["default-src"] == "'none'"
    assert "unsafe" not in rules["script-src"]


def test_a_page_without_scripts_runs_none() -> None:
    assert "script-src 'none'" in policy([])
    assert "script-src 'none'" in allowed(render("page.html"))


def test_what_is_given_is_no_script(campaign: str) -> None:
    assert SLY not in campaign
