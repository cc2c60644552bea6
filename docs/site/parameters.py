"""What the declarations say of the FMUs: tables of their parameters, and the page that each carries.

A block of code `{parameters} TruthPlant` becomes its table. A web view of the repository shows what the block
holds in its place: the command that lists the parameters.
"""

from __future__ import annotations

from shutil import copytree

import generate
from declaration import Declaration, Variable
from docutils import nodes
from reading import read
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from units import UNITS

TITLES = ("parameter", "unit", "default", "meaning")
LICENSES = generate.HERE / "documentation" / "licenses"
FOLDER = "fmus"
"""Of the site, for the pages that the FMUs carry."""


class Parameters(SphinxDirective):
    """The parameters of an FMU, below a link to its page."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """What stands in place of the block."""
        declaration = read(generate.HERE / f"{self.arguments[0]}.toml")
        address = f"{'../' * self.env.docname.count('/')}{FOLDER}/{declaration.name}.html"
        link = nodes.reference("", "Its own page", refuri=address)
        has = nodes.Text(" has the equations, the limits and every variable.")
        rows = [_row(declaration, one) for one in declaration.of("parameter", "tunable")]
        group = nodes.tgroup("", *(nodes.colspec() for _ in TITLES), cols=len(TITLES))
        group += [nodes.thead("", _line(*map(nodes.Text, TITLES))), nodes.tbody("", *rows)]
        return [nodes.paragraph("", "", link, has), nodes.table("", group, classes=["parameters"])]


def _row(declaration: Declaration, variable: Variable) -> nodes.row:
    unit = variable.display_unit or variable.unit_text
    factor = UNITS[variable.units[0]].display[unit] if variable.display_unit else 1
    real = variable.type == "Real"
    starts = (
        f"{factor * float(one):.6g}" if real else str(one).lower() for one in dict.fromkeys(variable.starts)
    )
    choices = declaration.enumeration.get(variable.type)
    items = f": {', '.join(item.name for item in choices.items)}" if choices else ""
    tunable = " (tunable)" if variable.causality == "tunable" else ""
    return _line(
        nodes.literal("", variable.name),
        nodes.Text("" if unit == "1" else unit),
        nodes.Text(", ".join(starts)),
        nodes.Text(variable.description + items + tunable),
    )


def _line(*cells: nodes.Node) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def _write_pages(app: Sphinx, error: Exception | None) -> None:
    if error is None:
        product = generate.product_of(app.config.release)
        for path in generate.HERE.glob("*.toml"):
            page = generate.page(read(path), product)
            generate.write(app.outdir / FOLDER / f"{path.stem}.html", page)
        copytree(LICENSES, app.outdir / FOLDER / "licenses", dirs_exist_ok=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.add_directive("parameters", Parameters)
    app.connect("build-finished", _write_pages)
    return {"parallel_read_safe": True}
