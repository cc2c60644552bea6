"""The verification matrix is complete, names what there is, and is what is committed."""

from __future__ import annotations

import re

import pytest
from matrix import (
    DOCUMENT,
    NOT_CHECKED,
    ROOT,
    Check,
    Verified,
    code_of,
    document,
    file_of_test,
    tracked,
)
from matrix import papers as papers_of_matrix
from pydantic import ValidationError

from sim_scenarios.catalogue import papers
from sim_scenarios.papers import load_paper

PAPERS = {paper.name: paper for paper in papers_of_matrix()}
CITED = re.compile(r"eqs?\. (\d+(?:(?:, | and | to |-)\d+)*)")


def test_every_paper_is_there() -> None:
    assert PAPERS.keys() == papers().keys()


@pytest.mark.parametrize("name", PAPERS)
def test_every_numbered_equation_stands_once_and_in_order(name: str) -> None:
    numbers = [equation.number for equation in PAPERS[name].equation if equation.number is not None]
    assert numbers == list(range(1, PAPERS[name].equations + 1))


@pytest.mark.parametrize("name", PAPERS)
def test_every_numbered_figure_stands_in_both_lists(name: str) -> None:
    numbered = PAPERS[name].numbered_pictures()
    assert list(PAPERS[name].figure) == numbered
    assert [figure.number for figure in load_paper(name).figure if figure.number] == numbered


@pytest.mark.parametrize("name", PAPERS)
def test_code_and_tests_exist(name: str) -> None:
    paper = PAPERS[name]
    for equation in paper.equation:
        code_of(equation.code)
    for check in (*paper.equation, *paper.figure.values()):
        for test in check.tests:
            file_of_test(test)


@pytest.mark.parametrize("name", PAPERS)
def test_no_source_cites_an_equation_that_a_paper_does_not_have(name: str) -> None:
    """Of a file that cites one paper alone; the numbers of others belong to whom they name."""
    paper = PAPERS[name]
    known = {other.paper for other in PAPERS.values()}
    cited = 0
    for path in tracked():
        if path.parts[0] != "fmu_src" or path.suffix not in (".hpp", ".cpp"):
            continue
        text = (ROOT / path).read_text(encoding="utf-8")
        if {other for other in known if other in text} != {paper.paper}:
            continue
        for numbers in CITED.findall(text):
            cited += 1
            assert max(int(n) for n in re.findall(r"\d+", numbers)) <= paper.equations, (path, numbers)
    assert cited > 0


def test_the_committed_matrix_is_what_the_papers_say() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(), "run python tests/verification/matrix.py"


@pytest.mark.parametrize("name", PAPERS)
def test_every_paper_has_a_page(name: str) -> None:
    page = (DOCUMENT.parent / "papers" / f"{name}.md").read_text(encoding="utf-8")
    for what in ("Claim", "Condition", "What is reproduced", "What is not, and why", "Measured"):
        assert f"**{what}" in page, what
    assert f"truenorth paper {name} --list" in page
    (measured,) = re.findall(r"\*\*Measured\*\*.*", page)
    when = rf"\d{{4}}-\d\d-\d\d with `truenorth paper {name} -n \d+|not yet"
    assert re.search(when, measured), "when, and with how many runs; or that it was not"


def test_no_cell_is_empty() -> None:
    lines = [line for line in document().splitlines() if line.startswith("|")]
    assert len(lines) > 118  # equations that are numbered
    assert [line for line in lines if re.search(r"\|\s*\|", line)] == []


@pytest.mark.parametrize(
    ("tests", "checked"),
    [
        ([], ["closed form"]),
        (["Suite.Name"], []),
        (["Suite.Name"], [NOT_CHECKED]),
        ([], []),
        (["Suite.Name"], ["closed form", NOT_CHECKED]),
        (["Suite.Name"], ["belief"]),
    ],
)
def test_an_entry_that_says_nothing_is_refused(tests: list[str], checked: list[str]) -> None:
    with pytest.raises(ValidationError):
        Check.model_validate({"tests": tests, "checked": checked})


@pytest.mark.parametrize("missing", ["says", "here", "code"])
def test_an_empty_cell_is_refused(missing: str) -> None:
    equation = {
        "number": 1,
        "says": "x",
        "here": "x",
        "code": "x",
        "tests": ["A.B"],
        "checked": ["closed form"],
    }
    paper = {"name": "p", "paper": "P", "equations": 1, "figures": 0, "tables": 0, "figure": {}}
    Verified.model_validate({**paper, "equation": [equation]})
    with pytest.raises(ValidationError):
        Verified.model_validate({**paper, "equation": [{**equation, missing: " "}]})


@pytest.mark.parametrize(
    "reference",
    ["nowhere.hpp: Nothing", "h_infinity.hpp: forgotten", "CMakeLists.txt: add_library"],
)
def test_code_that_does_not_exist_is_found_out(reference: str) -> None:
    with pytest.raises(LookupError):
        code_of(reference)


@pytest.mark.parametrize("reference", ["Suite.Name", "test_matrix.py::test_nothing", "bands: nowhere"])
def test_a_test_that_does_not_exist_is_found_out(reference: str) -> None:
    with pytest.raises(LookupError):
        file_of_test(reference)
