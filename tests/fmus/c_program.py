"""What `system.c` reads and writes: a system of FMUs run without Python, in FMI 2 or FMI 3."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import fmpy
import numpy as np
from numpy.typing import NDArray

from sim_scenarios.exchange.forms import Entry, Form
from sim_scenarios.exchange.system import System
from sim_scenarios.fmus import Number

HEADERS = Path(fmpy.__file__).parent / "c-code"
KINDS = {"Real": "R", "Integer": "I", "Enumeration": "I", "Boolean": "B"}


def compiled(compiler: Sequence[str], form: Form, program: Path, libraries: Sequence[str]) -> Path:
    """The program for a version of FMI."""
    source = Path(__file__).with_name("system.c")
    options = ["-O1", f"-DFMI={form.fmi}", f"-I{HEADERS}"]
    subprocess.run([*compiler, *options, source, *libraries, "-o", program], check=True)
    return program


def orders(
    system: System, form: Form, references: Mapping[str, Mapping[str, int]], *, with_parameters: bool
) -> str:
    """What the program reads, with value references by the names of component and variable."""

    def word(component: str, entry: Entry) -> str:
        return f"{KINDS[entry.kind]} {references[component][entry.name]} {len(entry.elements)}"

    def number(value: Number) -> str:
        return float(value).hex()

    components = {component.name: component for component in system.components}
    index = {name: k for k, name in enumerate(components)}
    lines = [f"{system.step.hex()} {round(system.stop / system.step)}"]
    for component in system.components:
        given = component.values if with_parameters else {}
        parameters = [
            " ".join(
                [word(component.name, entry), *(number(component.value(e.name)) for e in entry.elements)]
            )
            for entry in form.entries(component, given)
        ]
        lines.append(_listed(parameters))
        lines.append(_listed([word(component.name, e) for e in form.entries(component, component.outputs)]))
    pairs = []
    for connection in system.connections:
        start, end = components[connection.start], components[connection.end]
        for input_, output in form.connections(connection).items():
            (source,), (sink,) = form.entries(start, [output]), form.entries(end, [input_])
            pairs.append(
                f"{index[start.name]} {word(start.name, source)} {index[end.name]} {word(end.name, sink)}"
            )
    return "\n".join([*lines, _listed(pairs), ""])


def outputs(command: Sequence[str | Path], given: str, folder: Path) -> NDArray[np.float64]:
    """What the program writes: a row after each step, a column for each scalar output."""
    finished = subprocess.run(command, input=given, capture_output=True, text=True, check=False, cwd=folder)
    assert finished.returncode == 0, finished.stderr
    return np.array([[float.fromhex(word) for word in line.split()] for line in finished.stdout.splitlines()])


def _listed(words: Sequence[str]) -> str:
    return " ".join([str(len(words)), *words])
