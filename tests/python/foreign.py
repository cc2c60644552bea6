"""Filters of somebody else for tests: the binary of AlignmentFilter, of which a description tells less."""

from __future__ import annotations

from collections.abc import Container, Mapping
from pathlib import Path
from xml.etree import ElementTree

from sim_scenarios.archives import read_archive, write_archive
from sim_scenarios.fmus import Fmu

DESCRIPTION = "modelDescription.xml"


def foreign(
    fmu: Fmu,
    path: Path,
    outputs: Container[str] = ("nav.heading",),
    *,
    without: Container[str] = (),
    changed: Mapping[str, Mapping[str, str]] | None = None,
) -> Path:
    """Write such an FMU.

    Parameters
    ----------
    fmu : Fmu
        Whose binary it has.
    path : Path
        Where to.
    outputs : container of str
        Names, without indices, of the outputs that it has.
    without : container of str
        Names, without indices, of other variables that it does not have.
    changed : mapping, optional
        Attributes of the types of some variables (`{"nav.heading": {"unit": "deg"}}`).
    """
    members = {name: part for name, part in read_archive(fmu.path).items() if not name.startswith("sources/")}
    root = ElementTree.fromstring(members[DESCRIPTION])
    root.set("modelName", "Rival")
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    assert variables is not None
    assert structure is not None
    for variable in list(variables):
        name = variable.attrib["name"].partition("[")[0]
        is_output = variable.attrib["causality"] == "output"
        if (is_output and name not in outputs) or name in without:
            variables.remove(variable)
        variable[0].attrib.update((changed or {}).get(name, {}))
    structure.clear()
    unknowns = ElementTree.SubElement(structure, "Outputs")
    for index, variable in enumerate(variables, start=1):
        if variable.attrib["causality"] == "output":
            ElementTree.SubElement(unknowns, "Unknown", index=str(index))
    members[DESCRIPTION] = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    write_archive(path, members)
    return path
