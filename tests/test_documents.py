"""The pages: what they link to exists, the commands that they show parse, and the front door is short."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path

import pytest
from typer.main import get_command

from sim_scenarios import toml
from sim_scenarios.cli.application import app
from sim_scenarios.cli.commands import COMMANDS, command

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "examples").glob("*.md"),
        ROOT / "modelDescription" / "README.md",
        *(ROOT / "fmu_src").rglob("*.md"),
    ]
)
FENCED = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s#]*)(?:#([^)\s]+))?\)")
ENVIRONMENT = r"(?:[A-Z_]+=\S+\s+)*"
PROMPTED = re.compile(rf"^(?: {{4,}}|\$ )?{ENVIRONMENT}(truenorth [^\n`]*)$", re.MULTILINE)
QUOTED = re.compile(rf"`{ENVIRONMENT}(truenorth [^`]+)`")


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


def anchors(page: Path) -> set[str]:
    """Those that GitHub gives the headings of a page."""
    titles = re.findall(r"^#+ (.*)$", FENCED.sub("", page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def commands(text: str) -> Iterator[list[str]]:
    """Arguments of every command in a page: in blocks of code, a line each, and within sentences."""
    joined = text.replace("\\\n", " ")
    shown = [*PROMPTED.findall(joined), *(quoted.replace("\n", " ") for quoted in QUOTED.findall(joined))]
    for line in shown:
        yield [
            word.strip("[]") if word.isupper() or word[0] == "[" else word
            for word in shlex.split(line, comments=True)[1:]
        ]


def check(arguments: list[str]) -> None:
    """Parse a command as the command line does, without running it; one without arguments is a mention."""
    group = get_command(app)
    known = {option for one in group.params for option in one.opts} | {"--help", "-h"}
    flags = list(takewhile(lambda word: word.startswith("-"), arguments))
    assert known.issuperset(flags)
    if name := arguments[len(flags) :]:
        mentioned = len(name) == 1 or "--help" in name
        command(name[0]).make_context(name[0], name[1:], resilient_parsing=mentioned)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target, anchor in LINK.findall(FENCED.sub("", page.read_text())):
        if target.startswith(("http:", "https:", "mailto:")):
            continue
        path = page.parent / target if target else page
        assert path.exists(), target
        if anchor and path.suffix == ".md":
            assert anchor in anchors(path), f"{target}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_command_of_a_page_parses(page: Path) -> None:
    for arguments in commands(page.read_text()):
        print(f"truenorth {shlex.join(arguments)}")  # which a failure shows
        check(arguments)


def test_commands_are_found_and_wrong_ones_refused() -> None:
    text = "Say `FMUS=x truenorth list\n--json`:\n\n    truenorth run zigzag --sed 3   # no\n\n"
    text += "```\ntruenorth paper zhou\n```\n"
    found = list(commands(text))
    assert sorted(found) == [["list", "--json"], ["paper", "zhou"], ["run", "zigzag", "--sed", "3"]]
    for wrong in (
        ["run", "zigzag", "--sed", "3"],
        ["rum"],
        ["-w", "list"],
        ["campaign", "zigzag", "-n", "many"],
    ):
        with pytest.raises(Exception):  # noqa: B017, PT011  (of click, whose classes differ from version to version)
            check(wrong)


def test_every_command_is_shown_in_its_page() -> None:
    page = (ROOT / "docs" / "command.md").read_text()
    assert not [
        name for name in COMMANDS if f"truenorth {name} " not in page and f"truenorth {name}`" not in page
    ]


@pytest.mark.parametrize("page", [page for page in PAGES if page != ROOT / "README.md"], ids=name_of)
def test_a_page_says_for_whom_it_is(page: Path) -> None:
    title, first = page.read_text().split("\n\n")[:2]
    assert title.startswith("# ")
    assert first.startswith("For those who ")


def test_the_pages_of_docs_are_listed() -> None:
    listed = {target for target, _ in LINK.findall((ROOT / "docs" / "README.md").read_text())}
    pages = {str(page.relative_to(ROOT / "docs")) for page in (ROOT / "docs").rglob("*.md")} - {"README.md"}
    assert pages <= listed


def test_the_front_door_is_short() -> None:
    assert (ROOT / "README.md").stat().st_size <= 8 * 1024


def test_the_citation_is_of_this_version() -> None:
    version = toml.read(ROOT / "pyproject.toml")["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
