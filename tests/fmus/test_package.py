"""What is in the archive: validators, schema, symbols, documentation."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest
import vdmcheck
from calls import Fmu
from fmpy.validation import validate_fmu
from lxml import etree

from sim_scenarios import materials
from sim_scenarios.archives import read_archive
from sim_scenarios.html import policy

HEADER = Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h"
SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"


def functions_of_the_standard() -> set[str]:
    return set(re.findall(r"FMI2_Export fmi2\w+TYPE\s+(fmi2\w+);", HEADER.read_text()))


def test_fmpy_finds_nothing(archive: Path) -> None:
    assert validate_fmu(str(archive)) == []


def test_fmutool_finds_nothing(archive: Path) -> None:
    fmutool = Path(sys.executable).with_name("fmutool")
    result = subprocess.run(
        [fmutool, "-check", "-input", archive], capture_output=True, text=True, check=False
    )
    report = result.stdout + result.stderr
    assert "seems to be compliant with FMI-2.0" in report
    assert not re.search(r"error|warning", report.replace("No semantic error", ""), re.IGNORECASE), report


@pytest.mark.slow
def test_vdmcheck_finds_nothing(archive: Path) -> None:
    assert vdmcheck.verdict(archive) == vdmcheck.CLEAN
    assert vdmcheck.verdict(archive.parent / "fmi3" / archive.name, 3) == vdmcheck.CLEAN


def test_vdmcheck_finds_what_the_schema_cannot(fmus: dict[str, Fmu], tmp_path: Path) -> None:
    description = (fmus["Playback"].folder / "modelDescription.xml").read_text(encoding="utf-8")
    wrong = tmp_path / "modelDescription.xml"
    wrong.write_text(
        description.replace(
            'causality="output" variability="discrete"', 'causality="output" variability="fixed"', 1
        ),
        encoding="utf-8",
    )
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(etree.parse(wrong))
    assert "variability" in vdmcheck.verdict(wrong)


def test_schema(archive: Path) -> None:
    with zipfile.ZipFile(archive) as content:
        document = etree.fromstring(content.read("modelDescription.xml"))
    etree.XMLSchema(etree.parse(SCHEMA)).assertValid(document)


def test_exports_the_functions_of_the_standard_and_nothing_else(fmu: Fmu) -> None:
    table = subprocess.run(
        ["nm", "-D", "--defined-only", fmu.library._name], capture_output=True, text=True, check=True
    ).stdout
    exported = {line.split()[-1] for line in table.splitlines()}
    assert len(functions_of_the_standard()) == 44
    assert exported == functions_of_the_standard()


def test_needs_no_cpp_runtime(fmu: Fmu) -> None:
    headers = subprocess.run(
        ["objdump", "-p", fmu.library._name], capture_output=True, text=True, check=True
    ).stdout
    needed = re.findall(r"NEEDED\s+(\S+)", headers)
    assert "libc.so.6" in needed
    assert not [name for name in needed if name.startswith(("libstdc++", "libgcc"))]


def test_version_and_platform(fmu: Fmu) -> None:
    assert fmu.library.fmi2GetVersion() == b"2.0"
    assert fmu.library.fmi2GetTypesPlatform() == b"default"


def test_names_are_portable(fmu: Fmu) -> None:
    for name in fmu.variables:
        assert name.isascii()
        assert len(name) <= 63


def test_variables_are_fully_described(fmu: Fmu) -> None:
    for variable in fmu.variables.values():
        assert variable.description, variable.name
        if variable.type == "Real":
            assert variable.unit, variable.name
        if variable.causality in ("input", "output"):
            assert variable.variability == "discrete", variable.name


def test_value_references_are_unique(fmu: Fmu) -> None:
    references = [variable.valueReference for variable in fmu.variables.values()]
    assert len(set(references)) == len(references)


def test_content(fmu: Fmu) -> None:
    description = fmpy.read_model_description(fmu.archive)
    assert description.defaultExperiment.stopTime
    assert description.defaultExperiment.stepSize
    assert {category.name for category in description.logCategories} == {
        "logStatusError",
        "logEvents",
        "logAll",
    }
    assert "Copyright" in description.copyright
    assert (fmu.folder / "model.png").read_bytes().startswith(b"\x89PNG")
    assert "BSD 3-Clause" in (fmu.folder / "documentation/licenses/license.txt").read_text()
    assert "cereal" in (fmu.folder / "documentation/licenses/third_party.txt").read_text()


@pytest.mark.parametrize("version", [2, 3])
def test_every_binary_has_a_bill_of_materials(archive: Path, version: int) -> None:
    path = archive if version == 2 else archive.parent / "fmi3" / archive.name
    members = read_archive(path)
    platforms = {name.split("/")[1] for name in members if name.startswith("binaries/")}
    names = {name for name in members if name.endswith(".cdx.json")}
    assert names == {materials.name_in_fmu(platform) for platform in platforms}
    eigen = members["sources/Eigen/src/Core/util/Macros.h"].decode()
    for name in names:
        bill = json.loads(members[name])
        assert (bill["bomFormat"], bill["specVersion"], bill["version"]) == ("CycloneDX", "1.5", 1)
        assert bill.keys() == {"bomFormat", "specVersion", "version", "metadata", "components"}
        subject = bill["metadata"]["component"]
        description = etree.fromstring(members["modelDescription.xml"])
        assert (subject["name"], subject["version"]) == (archive.stem, description.get("version"))
        assert subject["licenses"] == [{"license": {"id": description.get("license")}}]
        parts = {part["name"]: part for part in bill["components"]}
        assert parts.keys() >= {"Eigen", "cereal", f"FMI {version} headers"}
        assert parts.keys() & {"libstdc++", "libc++"}  # the binary needs none of the machine
        assert ("RapidJSON" in parts) == any("/rapidjson/" in member for member in members)
        for number in parts["Eigen"]["version"].split("."):
            assert re.search(rf"_VERSION {number}\n", eigen)
        assert all(part["type"] == "library" and part["licenses"] for part in parts.values())


def test_the_page_names_every_variable_and_loads_nothing(fmu: Fmu) -> None:
    page = (fmu.folder / "documentation/index.html").read_text()
    for name in {re.sub(r"\[.*", "", name) for name in fmu.variables}:
        assert f"<code>{name}" in page
    assert not re.search(r"<(script|link|img|iframe)\b|url\(", page)
    allowed = f'<meta http-equiv="Content-Security-Policy" content="{policy([])}">'
    assert allowed in page.partition("<style>")[0]  # a policy holds for what stands behind it
    assert 'name="viewport"' in page


def test_the_page_shows_the_ports_and_a_run(fmu: Fmu) -> None:
    page = (fmu.folder / "documentation/index.html").read_text()
    block, run = re.findall(r"<svg [^>]*aria-label.*?</svg>", page.partition("</header>")[2], re.DOTALL)
    for name in {re.split(r"[._\[]", v.name)[0] for v in (*fmu.of("input"), *fmu.of("output"))}:
        assert f">{name}" in block
    assert len(re.findall(r"[\d.]+,[\d.]+", run)) > 200


@pytest.mark.parametrize(
    "tag", ["figure", "td", "tr", "table", "p", "ul", "li", "div", "h2", "sub", "sup", "code"]
)
def test_the_page_closes_its_tags(fmu: Fmu, tag: str) -> None:
    page = (fmu.folder / "documentation/index.html").read_text()
    assert len(re.findall(rf"<{tag}[\s>]", page)) == page.count(f"</{tag}>")
