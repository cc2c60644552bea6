"""The verification matrix: every equation and figure of the papers, where it stands, and what has checked it.

A paper is a TOML file in this folder: how many equations, figures and tables it numbers, an entry for each
of them, and for what it computes without a number. `python tests/verification/matrix.py` writes the matrix,
`docs/verification.md`; `test_matrix.py` fails if the file is not what this writes, or if a line of it names a
file, a symbol, a test or an equation that does not exist.

An entry names its code as `file: symbol` and its tests as `Suite.Name` of GoogleTest, `file.py::name` of
pytest, or `bands: scenario` for the Monte-Carlo bands of `make bands`. Files are found by their names, so
that they may move.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, StringConstraints, model_validator

from sim_scenarios.catalogue import BANDS, files
from sim_scenarios.papers import load_paper

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FOLDER: Final = Path(__file__).parent
ROOT: Final = FOLDER.parents[1]
DOCUMENT: Final = ROOT / "docs" / "verification.md"

ORACLES: Final[Mapping[str, str]] = {
    "transcription": "the equation written out a second time in the test, with dense matrices or in long "
    "double. It finds slips, not misunderstandings.",
    "closed form": "a known result, worked out by other means: an inverse, a Joseph form, a period, a bias "
    "that is put in.",
    "differences": "difference quotients of what the derivative is taken of.",
    "two mechanisations": "the error of one strapdown mechanisation against another, run side by side; the "
    "mechanisation itself is that of pyins.",
    "pyins": "the package python-ins, written by others.",
    "prototype": "an independent filter in another language: bands of Monte-Carlo runs, `make bands`.",
    "dense filter": "an independent filter in numpy on the very same signals, `tests/python/papers`: every "
    "figure within 1 %.",
    "Monte Carlo": "statistics of many draws that must be what the equation says.",
    "drawn": "drawn and tabulated by `truenorth paper`; the test is that of the drawing. Nothing says that "
    "the paper's own curve is met but the comparison on its page.",
    "modelled, not checked": "nothing outside has looked at it.",
}
NOT_CHECKED: Final = "modelled, not checked"

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]
Oracle = Literal[
    "transcription",
    "closed form",
    "differences",
    "two mechanisations",
    "pyins",
    "prototype",
    "dense filter",
    "Monte Carlo",
    "drawn",
    "modelled, not checked",
]


class Strict(BaseModel):
    """What knows all of its entries."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Check(Strict):
    """Tests, and what they hold a thing against."""

    tests: tuple[Text, ...]
    checked: tuple[Oracle, ...]

    @model_validator(mode="after")
    def _says_one_of_both(self) -> Check:
        unchecked = self.checked == (NOT_CHECKED,)
        if not self.checked or (NOT_CHECKED in self.checked and not unchecked):
            raise ValueError(f"checked: names what has checked it, or '{NOT_CHECKED}' alone")
        if unchecked == bool(self.tests):
            raise ValueError(f"tests: there are some, or it is '{NOT_CHECKED}'")
        return self


class Equation(Check):
    """A numbered equation, or what is computed at a place of the paper without a number."""

    number: int | None = None
    place: Text | None = None
    says: Text
    here: Text
    code: Text

    @model_validator(mode="after")
    def _is_somewhere(self) -> Equation:
        if (self.number is None) == (self.place is None):
            raise ValueError("an equation has a number or a place")
        return self

    @property
    def title(self) -> str:
        """The first cell."""
        return f"({self.number})" if self.number else f"{self.place}"


class Verified(Strict):
    """A paper of this folder."""

    name: str
    paper: Text
    equations: int
    figures: int
    tables: int
    equation: tuple[Equation, ...]
    figure: dict[str, Check]

    def numbered_pictures(self) -> list[str]:
        """Figures and tables that the paper numbers."""
        return [
            *(f"Fig. {i + 1}" for i in range(self.figures)),
            *(f"Table {i + 1}" for i in range(self.tables)),
        ]


def papers() -> list[Verified]:
    """All papers."""
    return [
        Verified.model_validate({"name": path.stem, **tomllib.loads(path.read_text(encoding="utf-8"))})
        for path in sorted(FOLDER.glob("*.toml"))
    ]


@cache
def tracked() -> tuple[Path, ...]:
    """Files of the project."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return tuple(Path(line) for line in listed.splitlines() if (ROOT / line).is_file())


def file_named(name: str, *folders: str) -> Path:
    """The one file of a name, or of the end of a path, below some folders of the project."""
    found = [p for p in tracked() if f"/{p.as_posix()}".endswith(f"/{name}") and p.parts[0] in folders]
    if len(found) != 1:
        raise LookupError(f"{name}: there are {len(found)} such files in {', '.join(folders)}")
    return found[0]


def code_of(reference: str) -> tuple[Path, str]:
    """File and symbol of a reference."""
    name, _, symbol = reference.partition(": ")
    path = file_named(name, "fmu_src", "sim_scenarios")
    if not re.search(rf"(?<![\w.]){re.escape(symbol)}(?!\w)", text_of(path)):
        raise LookupError(f"{path}: there is no '{symbol}' in it")
    return path, symbol


def file_of_test(reference: str) -> Path:
    """File of a test."""
    if reference.startswith("bands: "):
        path = files(BANDS).get(reference.removeprefix("bands: "))
        if path is None:
            raise LookupError(f"{reference}: there is no such band")
        return path.relative_to(ROOT)
    if "::" in reference:
        name, _, function = reference.partition("::")
        path = file_named(name, "tests")
        if not re.search(rf"^def {re.escape(function)}\(", text_of(path), re.MULTILINE):
            raise LookupError(f"{reference}: there is no such test")
        return path
    if reference not in gtests():
        raise LookupError(f"{reference}: there is no such test")
    return gtests()[reference]


@cache
def gtests() -> dict[str, Path]:
    """Files of the C++ tests, by `Suite.Name`."""
    declared = re.compile(r"^(?:TYPED_)?TEST(?:_[FP])?\((\w+),\s*(\w+)\)", re.MULTILINE)
    return {
        f"{suite}.{name}": path
        for path in tracked()
        if path.parts[:2] == ("tests", "cpp") and path.suffix == ".cpp"
        for suite, name in declared.findall(text_of(path))
    }


@cache
def text_of(path: Path) -> str:
    """Text of a file of the project."""
    return (ROOT / path).read_text(encoding="utf-8")


def document() -> str:
    """The matrix as Markdown."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield "# Verification matrix"
    yield ""
    yield "For those who check what the code does against the papers."
    yield ""
    yield (
        "Every equation, figure and table that the five papers number, and what they compute without a "
        "number: what it is here, the code, the test, and what it was checked against. Written by "
        "`python tests/verification/matrix.py` from the TOML files beside it; a test fails where a file, a "
        "symbol, a test or a number does not exist or a cell is empty. What of each paper holds: "
        + ", ".join(f"[{paper.paper}](papers/{paper.name}.md)" for paper in papers())
        + "."
    )
    yield ""
    yield from _rows(("Checked against", "means"), list(ORACLES.items()))
    for paper in papers():
        yield ""
        yield f"## {paper.paper}"
        yield ""
        heading = ("Equation", "says", "Here", "Code", "Test", "Checked against")
        yield from _rows(heading, [_equation(equation) for equation in paper.equation])
        yield ""
        drawn = {figure.number: figure for figure in load_paper(paper.name).figure}
        yield from _rows(
            ("Figure", "shows", "Here", "Code", "Test", "Checked against"),
            [
                (
                    number,
                    drawn[number].shows,
                    drawn[number].here,
                    _link(f"{paper.name}.toml", Path(f"sim_scenarios/papers/{paper.name}.toml")),
                    *_check(check),
                )
                for number, check in paper.figure.items()
            ],
        )


def _equation(equation: Equation) -> Sequence[str]:
    path, symbol = code_of(equation.code)
    code = f"{_link(path.name, path)} `{symbol}`"
    return equation.title, equation.says, equation.here, code, *_check(equation)


def _check(check: Check) -> tuple[str, str]:
    tests = "<br>".join(_link(test, file_of_test(test)) for test in check.tests)
    return tests or "none", ", ".join(check.checked)


def _link(text: str, path: Path) -> str:
    return f"[{text}](../{path.as_posix()})"


def _rows(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    for row in (heading, ["---"] * len(heading), *rows):
        yield f"| {' | '.join(' '.join(cell.split()).replace('|', '&#124;') for cell in row)} |"


if __name__ == "__main__":
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(document(), encoding="utf-8")
