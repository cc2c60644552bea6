"""What the declarations of the FMUs say, in the site: tables of parameters, and the page that each FMU carries.

A block of code `{parameters} TruthPlant` becomes its table. What the block holds is shown by a web view of the
repository in its place: the command that lists the parameters.
"""

from __future__ import annotations

from shutil import copytree

import generate
from declaration import Variable
from docutils import nodes
from reading import read
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from units import UNITS

TITLES = ("parameter", "unit", "default", "tunable", "meaning")
DOCUMENTATION = generate.HERE / "documentation"
FOLDER = "fmus"
"""Of the site, for the pages that the FMUs carry."""


class Parameters(SphinxDirective):
    """The parameters of an FMU."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """A link to the page of the FMU, and the table."""
        path = generate.HERE / f"{self.arguments[0]}.toml"
        self.env.note_dependency(str(path))
        declaration = read(path)
        address = f"{'../' * self.env.docname.count('/')}{FOLDER}/{declaration.name}.html"
        link = nodes.reference("", "Its own page", refuri=address)
        about = nodes.paragraph("", "", link, nodes.Text(" has the equations, the limits and every variable."))
        choices = {name: [item.name for item in e.items] for name, e in declaration.enumeration.items()}
        group = nodes.tgroup("", *(nodes.colspec() for _ in TITLES), cols=len(TITLES))
        group += nodes.thead("", _row(*(nodes.Text(title) for title in TITLES)))
        group += nodes.tbody(
            "", *(_parameter(one, choices) for one in declaration.of("parameter", "tunable"))
        )
        return [about, nodes.table("", group)]


def _parameter(variable: Variable, choices: dict[str, list[str]]) -> nodes.row:
    unit = variable.display_unit or variable.unit_text
    factor = UNITS[variable.units[0]].display[unit] if variable.display_unit else None
    starts = dict.fromkeys(variable.starts)
    defaults = (f"{start * factor:.6g}" if factor else str(start).lower() for start in starts)
    size = f" ({len(variable.indices)})" if variable.shape else ""
    return _row(
        nodes.literal("", variable.name + size),
        nodes.Text("" if unit == "1" else unit),
        nodes.Text(", ".join(defaults)),
        nodes.Text("yes" if variable.causality == "tunable" else ""),
        nodes.Text(": ".join([variable.description, *filter(None, [", ".join(choices.get(variable.type, []))])])),
    )


def _row(*cells: nodes.Node) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def _write_pages(app: Sphinx, error: Exception | None) -> None:
    if error is None:
        product = generate.product_of(app.config.release)
        for path in generate.HERE.glob("*.toml"):
            page = generate.page(read(path), product)
            generate.write(app.outdir / FOLDER / f"{path.stem}.html", page)
        copytree(DOCUMENTATION / "licenses", app.outdir / FOLDER / "licenses", dirs_exist_ok=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.add_directive("parameters", Parameters)
    app.connect("build-finished", _write_pages)
    return {"parallel_read_safe": True}
