"""Write everything that follows from a component's declaration."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import jinja2
from declaration import Declaration, DeclarationError, read
from structs import Cpp, nest

TEMPLATES = Path(__file__).parent / "templates"


def render(template: str, declaration: Declaration, **context: object) -> str:
    """Text of a template for a declaration."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=jinja2.select_autoescape(["xml", "html"]),
    )
    return environment.get_template(template).render(
        component=declaration, cpp=Cpp(declaration), nest=nest, **context
    )


def write(path: Path, text: str) -> None:
    """Write a text, making its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


def variables(declaration: Declaration, folder: Path) -> None:
    """`<Name>/variables.hpp`: the structs a component is made of."""
    write(folder / declaration.name / "variables.hpp", render("variables.hpp", declaration))


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("variables", help="the C++ structs")
    command.add_argument("declaration", type=Path)
    command.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    try:
        variables(read(arguments.declaration), arguments.folder)
    except DeclarationError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
