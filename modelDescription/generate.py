"""Write what follows from a component's declaration: C++, modelDescription.xml and the documentation page.

    generate.py code <Name>.toml <folder>           variables.hpp, variable_table.cpp
    generate.py settings shared/<name>.toml <folder>    settings/<name>.hpp: what all components share of it
    generate.py description <Name>.toml <folder>    fmi2/, fmi3/ (modelDescription.xml, terminals and icons,
                                                    build description), documentation/index.html, guid.cpp

Everything else goes to <folder>/<Name>/.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import sys
import uuid
from dataclasses import dataclass
from pathlib import Path

import jinja2
from declaration import Declaration, DeclarationError, Fragment, Variable
from fmi2 import Fmi2
from fmi3 import Fmi3
from markupsafe import Markup
from reading import read, read_settings, settings_header
from sources import closure
from structs import Cpp, nest, parameters
from terminals import terminals

HERE = Path(__file__).parent
ROOT = HERE.parent


@dataclass(frozen=True)
class Product:
    """What every FMU says about its origin."""

    version: str
    license: str
    license_text: str

    @property
    def copyright(self) -> str:
        """The line of the licence that names the owner."""
        return next(line for line in self.license_text.splitlines() if line.startswith("Copyright"))


def product_of(version: str) -> Product:
    """What is made here, in a version."""
    return Product(version, "BSD-3-Clause", (ROOT / "LICENSE").read_text(encoding="utf-8"))


def render(template: str, declaration: Fragment, **context: object) -> str:
    """Text of a template for the declaration of a component, or of settings."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader([HERE / "templates", HERE / "documentation"]),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=jinja2.select_autoescape(["xml", "html"]),
    )
    return environment.get_template(template).render(component=declaration, **context)


def code(declaration: Declaration) -> dict[str, str]:
    """C++ files: the structs a component is made of, and the table through which FMI reaches them."""
    cpp = Cpp(declaration)
    return {
        "variables.hpp": render(
            "variables.hpp", declaration, cpp=cpp, nest=nest, parameters=parameters(declaration)
        ),
        "variable_table.cpp": render("variable_table.cpp", declaration, cpp=cpp),
    }


def settings(fragment: Fragment, name: str) -> str:
    """The header of settings: enumerations, and a struct for each group."""
    return render("settings.hpp", fragment, cpp=Cpp(fragment), name=name, groups=nest(fragment.in_settings()))


def description(declaration: Declaration, product: Product, sources: list[Path]) -> dict[str, str]:
    """Files that describe the FMU; the guid is a hash of them and of the sources."""
    fmi2, fmi3 = Fmi2(declaration), Fmi3(declaration)

    def interfaces(guid: str) -> dict[str, str]:
        about = {"product": product, "guid": guid, "compiled": compiled_files(declaration, 2)}
        return {
            "fmi2/modelDescription.xml": render("modelDescription.xml", declaration, fmi2=fmi2, **about),
            "fmi3/modelDescription.xml": render("modelDescription3.xml", declaration, fmi3=fmi3, **about),
            "fmi2/terminalsAndIcons.xml": ports(declaration, arrays=False),
            "fmi3/terminalsAndIcons.xml": ports(declaration, arrays=True),
            "fmi2/buildDescription.xml": build(declaration, 2),
            "fmi3/buildDescription.xml": build(declaration, 3),
        }

    documentation = page(declaration, product)
    guid = content_hash([*interfaces("").values(), documentation, *code(declaration).values()], sources)
    return {
        **interfaces(guid),
        "documentation/index.html": documentation,
        "guid.cpp": render("guid.cpp", declaration, guid=guid),
    }


def page(declaration: Declaration, product: Product) -> str:
    """The FMU's own page: ports, equations, a run, every variable."""
    return render(
        "index.html",
        declaration,
        product=product,
        ports={
            "inputs": port_names(declaration.of("input")),
            "outputs": port_names(declaration.of("output")),
        },
        icon=written(f"{declaration.name}.svg"),
        theory=theory(declaration),
        run=written(f"{declaration.name}.run.html"),
    )


def theory(declaration: Declaration) -> Markup:
    """Equations, combinations and limits, in which `choices(<enumeration>)` are all that can be chosen."""

    def choices(name: str) -> Markup:
        return Markup(", ").join(
            Markup("<code>{}</code>").format(i.name) for i in declaration.enumeration[name].items
        )

    return Markup(render(f"{declaration.name}.html", declaration, choices=choices))


def written(name: str) -> Markup:
    """A part of the documentation page that is not generated."""
    return Markup((HERE / "documentation" / name).read_text(encoding="utf-8"))


def port_names(variables: list[Variable]) -> list[str]:
    """What the block picture shows: names, those that begin with the same word as one."""
    words: dict[str, list[str]] = {}
    for variable in variables:
        words.setdefault(re.split(r"[._]", variable.name)[0], []).append(variable.name)
    return [names[0] if len(names) == 1 else f"{word}*" for word, names in words.items()]


def ports(declaration: Declaration, *, arrays: bool) -> str:
    """Terminals of the component."""
    return render("terminalsAndIcons.xml", declaration, terminals=terminals(declaration, arrays=arrays))


def build(declaration: Declaration, version: int) -> str:
    """How the binary is compiled."""
    return render("buildDescription.xml", declaration, compiled=compiled_files(declaration, version))


def compiled_files(declaration: Declaration, version: int) -> list[str]:
    """Source files of the FMU's binary, relative to the folder of the sources."""
    begin = [f"fmi/fmi{version}.cpp", f"components/{declaration.snake_name}.hpp"]
    written = [name for name in closure(begin, [ROOT / "fmu_src"]) if name.endswith(".cpp")]
    return sorted([*written, f"{declaration.name}/guid.cpp", f"{declaration.name}/variable_table.cpp"])


def content_hash(parts: list[str], sources: list[Path]) -> str:
    """Fold texts and files, in the order given, into a guid."""
    digest = hashlib.sha256()
    for part in (*(text.encode() for text in parts), *(source.read_bytes() for source in sources)):
        digest.update(len(part).to_bytes(8, "little"))
        digest.update(part)
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"


def write(path: Path, text: str) -> None:
    """Write a text unless the file has it already, so that nothing is compiled anew without need."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["code", "settings", "description"])
    parser.add_argument("declaration", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--version", default="0", help="version of the product")
    arguments = parser.parse_args()
    try:
        if arguments.what == "settings":
            text = settings(read_settings(arguments.declaration), arguments.declaration.name)
            write(arguments.folder / settings_header(arguments.declaration.name), text)
            return 0
        declaration = read(arguments.declaration)
    except DeclarationError as error:
        print(error, file=sys.stderr)
        return 1
    if arguments.what == "code":
        files = code(declaration)
    else:
        product = product_of(arguments.version)
        written = (ROOT / "fmu_src").rglob("*.[ch]pp")
        sources = sorted(path for path in written if path.parent.name != "runner")  # is in no FMU
        files = description(declaration, product, sources)
    for name, text in files.items():
        write(arguments.folder / declaration.name / name, text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
