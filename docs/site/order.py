"""The menu of the site: the index `docs/README.md`, whose words in bold are its headings."""

import re
from pathlib import PurePosixPath
from posixpath import normpath

from sphinx.application import Sphinx

INDEX = PurePosixPath("docs/README.md")
SECTION = re.compile(r"^\*\*(.+?)\.\*\*(.*?)(?=^\*\*|\Z)", re.MULTILINE | re.DOTALL)
PAGE = re.compile(r"\]\(([^)#:]+)\.md\)")


def menu(index: str) -> str:
    """Tables of contents, one for each section of an index, which the page that has them does not show."""
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


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("source-read", _add_menu)
    return {"parallel_read_safe": True}
