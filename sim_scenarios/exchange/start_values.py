"""Values of an export inside the FMU: a tool that sets nothing runs what was exported.

The binary reads them from a file of its resources when it is instantiated, and finds by the checksum in the
token of modelDescription.xml whether the file, and the recording beside it, is the right one
(`fmu_src/fmi/start_values.hpp`).
modelDescription.xml states the same values, and the experiment, for tools that show or set what it states.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import lru_cache

from sim_scenarios.exchange import signals
from sim_scenarios.exchange.system import Component, System
from sim_scenarios.fmus import Number, Variable

FILE = "resources/start_values.txt"
DESCRIPTION = "modelDescription.xml"
TOKENS = ("guid", "instantiationToken")


def members(system: System, component: Component, fmu: Mapping[str, bytes]) -> dict[str, str]:
    """Members that replace those of an FMU, of FMI 2 or FMI 3, or come to them."""
    before = fmu.get(FILE, b"").decode()
    given = {name: text(component.fmu.variables[name], value) for name, value in component.values.items()}
    values = {**dict(line.split(" ") for line in before.splitlines()), **given}
    file = "".join(f"{name} {value}\n" for name, value in values.items())
    mark = _checksum(file.encode(), _of_recording(fmu.get(signals.FILE, b"")))
    return {FILE: file, DESCRIPTION: _described(fmu[DESCRIPTION].decode(), system, component, mark)}


def text(variable: Variable, value: Number) -> str:
    """A value as it reads back to the same bits: in CSV, in XML, in the file of the FMU."""
    return repr(float(value)) if variable.kind == "Real" else str(int(value))


def _described(description: str, system: System, component: Component, mark: int) -> str:
    """The model description with these start values, their mark in the token, and the experiment."""
    root = ET.fromstring(description, ET.XMLParser(target=ET.TreeBuilder(insert_comments=True)))
    token = next(name for name in TOKENS if name in root.attrib)
    root.set(token, f"{root.attrib[token].partition(':')[0]}:{mark:016x}")
    experiment = root.find("DefaultExperiment")
    assert experiment is not None
    experiment.attrib.update(startTime="0.0", stopTime=repr(system.stop), stepSize=repr(system.step))
    variables = root.find("ModelVariables")
    assert variables is not None
    for element in variables.iter():
        name = element.get("name")
        if element.get("causality") in ("parameter", "input") and name is not None:
            holder = element[0] if element.tag == "ScalarVariable" else element
            if (start := _start(component, name)) is not None:
                holder.set("start", start)
    return ET.tostring(root, encoding="unicode", xml_declaration=False).join(
        ('<?xml version="1.0" encoding="UTF-8"?>\n', "\n")
    )


def _start(component: Component, name: str) -> str | None:
    """Start value of a scalar or, in FMI 3, of an array; None where no element is set."""
    fmu = component.fmu
    scalars = [name] if name in fmu.variables else fmu.arrays[name]
    if not any(scalar in component.values for scalar in scalars):
        return None
    return " ".join(xml_text(fmu.variables[scalar], component.value(scalar)) for scalar in scalars)


def xml_text(variable: Variable, value: Number) -> str:
    """A value as XML has it."""
    return str(bool(value)).lower() if variable.kind == "Boolean" else text(variable, value)


@lru_cache(maxsize=2)  # nothing, and the recording of an export, which is the same in all versions of FMI
def _of_recording(content: bytes) -> int:
    return _checksum(content)


def _checksum(content: bytes, checksum: int = 0xCBF29CE484222325) -> int:
    """FNV-1a, 64 bits; of bytes that come after others, it goes on from their checksum."""
    for byte in content:
        checksum = (checksum ^ byte) * 0x100000001B3 % 2**64
    return checksum
