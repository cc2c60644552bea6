"""The order of the site is that of the index: `docs/README.md` lists the pages below words in bold, and so does the menu."""

import re
from pathlib import PurePosixPath
from posixpath import normpath

from sphinx.application import Sphinx

INDEX = PurePosixPath("docs/README.md")
SECTION = re.compile(r"^\*\*(.+?)\.\*\*(.*?)(?=^\*\*|\Z)", re.MULTILINE | re.DOTALL)
PAGE = re.compile(r"\]\(([^)#:]+)\.md\)")


def menu(index: str) -> str:
    """The tables of contents that an index makes, one for each of its sections, which no reader of the page sees."""
    sections = {"The pages": [str(INDEX.with_suffix(""))]}
    for title, text in SECTION.findall(index):
        sections[title] = [normpath(INDEX.parent / page) for page in PAGE.findall(text)]
    tables = (
        f"```{{toctree}}\n:hidden:\n:caption: {title}\n" + "".join(f"/{page}\n" for page in pages) + "```\n"
        for title, pages in sections.items()
    )
    return "\n" + "\n".join(tables)


def _add_menu(app: Sphinx, name: str, source: list[str]) -> None:
    if name == app.config.root_doc:
        source[0] += menu((app.srcdir / INDEX).read_text(encoding="utf-8"))
        app.env.note_dependency(str(app.srcdir / INDEX))


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("source-read", _add_menu)
    return {"parallel_read_safe": True}
