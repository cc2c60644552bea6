"""What `truenorth export` writes: sound by the schemas, complete, and the same every time."""

from __future__ import annotations

import csv
import hashlib
import json
import shutil
import subprocess
import sys
import zipfile
from contextlib import closing
from pathlib import Path

import fmpy
import pyssp_standard
import pytest
import vdmcheck
from archives import FMUS
from fmpy.ssp.simulation import simulate_ssp
from fmpy.validation import validate_fmu
from lxml import etree
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.exchange import System, export
from sim_scenarios.exchange.evidence import FOLDER
from sim_scenarios.exchange.forms import FORMS, Form
from sim_scenarios.exchange.system import of_scenario
from sim_scenarios.fmus import Fmu, Fmus
from sim_scenarios.instance import Instance
from sim_scenarios.scenario import load_scenario
from sim_scenarios.stepping import EXPORTED_STEP

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
SCHEMAS_OF_SSP_2 = Path(pyssp_standard.__file__).parent / "resources" / "ssp2"
SHORT = {"duration": 20.0, "evaluation.start": 5.0}
RESULTS = "extra/org.fmi-standard.fmi-ls-ref"


@pytest.fixture(scope="module")
def fmus() -> Fmus:
    return Fmus({path.stem: Fmu(path) for path in FMUS.glob("*.fmu")})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, fmus: Fmus) -> Path:
    path = tmp_path_factory.mktemp("export")
    export("swaying_ship", path, set=SHORT, fmus=fmus)
    return path


@pytest.mark.parametrize(
    ("member", "schema"),
    [
        ("SystemStructure.ssd", "SystemStructureDescription.xsd"),
        ("resources/plant.ssv", "SystemStructureParameterValues.xsd"),
        ("resources/filter.ssv", "SystemStructureParameterValues.xsd"),
    ],
)
@pytest.mark.parametrize(("archive", "version"), [("swaying_ship", "1.0"), ("swaying_ship_fmi3", "2.0")])
def test_schemas(folder: Path, archive: str, version: str, member: str, schema: str) -> None:
    """FMPy has the schemas of SSP 1.0, pyssp-standard those of SSP 2.0."""
    schemas = SCHEMAS if version == "1.0" else SCHEMAS_OF_SSP_2
    with zipfile.ZipFile(folder / f"{archive}.ssp") as content:
        document = etree.fromstring(content.read(member))
    assert document.get("version") == version
    etree.XMLSchema(etree.parse(schemas / schema)).assertValid(document)


@pytest.fixture(scope="module")
def aligned(tmp_path_factory: pytest.TempPathFactory, fmus: Fmus) -> tuple[System, Path]:
    """An alignment that hands over to navigation after 6 s."""
    path = tmp_path_factory.mktemp("aligned")
    settings = {
        **SHORT,
        "alignment.error_model": "large_azimuth",
        "alignment.prior.heading_sigma": "0.4 deg",
        "alignment.convergence.hold_time": 5.0,
        "initial_error.misalignment": ["0.1 deg", "0.1 deg", "0.3 deg"],
    }
    return export("align_then_navigate", path, set=settings, fmus=fmus), path


@pytest.mark.parametrize(
    ("member", "schema"),
    [
        ("SystemStructure.ssd", "SystemStructureDescription.xsd"),
        ("resources/alignment.ssv", "SystemStructureParameterValues.xsd"),
        ("resources/filter.ssv", "SystemStructureParameterValues.xsd"),
    ],
)
def test_schemas_of_three_components(aligned: tuple[System, Path], member: str, schema: str) -> None:
    with zipfile.ZipFile(aligned[1] / "align_then_navigate.ssp") as content:
        document = etree.fromstring(content.read(member))
    etree.XMLSchema(etree.parse(SCHEMAS / schema)).assertValid(document)


def test_the_alignment_is_connected_to_all_that_navigation_starts_from(aligned: tuple[System, Path]) -> None:
    system, folder = aligned
    connected = {(c.start, c.end): c.outputs for c in system.connections}
    assert list(connected) == [("plant", "alignment"), ("plant", "filter"), ("alignment", "filter")]
    handed = connected["alignment", "filter"]
    assert handed.keys() == {n for n in system.filter.fmu.inputs() if n.startswith("initial.")}
    assert handed["initial.valid"] == "converged"
    assert handed["initial.time"] == "nav.time"
    assert handed["initial.gyro_bias[2]"] == "gyro_bias[2]"
    assert handed["initial.covariance[3,12]"] == "covariance[3,12]"
    osp = (folder / "OspSystemStructure.xml").read_text(encoding="utf-8")
    assert osp.count("<VariableConnection>") == sum(map(len, connected.values()))
    with zipfile.ZipFile(folder / "align_then_navigate.ssp") as content:
        ssd = etree.fromstring(content.read("SystemStructure.ssd"))
    inside = {(c.get("startElement"), c.get("endElement")) for c in ssd.iterfind(".//{*}Connection")}
    assert inside == connected.keys()


def test_fmpy_repeats_the_hand_over_of_the_reference_results(aligned: tuple[System, Path]) -> None:
    system, folder = aligned
    with (folder / "reference" / "NavigationFilter_ref.csv").open(newline="") as file:
        reference = list(csv.DictReader(file))
    navigates = [float(row["heading_sigma"]) > 0 for row in reference]
    assert navigates == [False] * 7 + [True] * (len(reference) - 7)  # a row each second
    archive = str(folder / f"{system.name}.ssp")
    result = simulate_ssp(archive, stop_time=SHORT["duration"], step_size=EXPORTED_STEP)
    for name in ("nav.heading", "heading_sigma", "nav.latitude", "nav.velocity[1]"):
        assert result[f"filter.{name}"][-1] == pytest.approx(float(reference[-1][name]), rel=1e-12)


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_the_fmus_stay_valid_and_carry_their_experiment(folder: Path, version: str) -> None:
    for archive in (folder / version).glob("*.fmu"):
        assert validate_fmu(str(archive)) == []
        with zipfile.ZipFile(archive) as content:
            experiments = etree.fromstring(content.read(f"{RESULTS}/experiments.xml"))
            experiment = experiments[0]
            assert experiments.get("name") == "swaying_ship"  # which the schema, v1.0.0-alpha.1, requires
            assert float(experiment.get("stopTime")) == SHORT["duration"]
            for part in experiment:
                assert content.read(f"{RESULTS}/{part.get('source')}")


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["TruthPlant", "AlignmentFilter", "NavigationFilter"])
def test_vdmcheck_finds_nothing(aligned: tuple[System, Path], name: str, version: int) -> None:
    assert vdmcheck.verdict(aligned[1] / f"fmi{version}" / f"{name}.fmu", version) == vdmcheck.CLEAN


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_fmusim_finds_nothing(aligned: tuple[System, Path], version: str) -> None:
    fmusim = shutil.which("fmusim")
    if fmusim is None:
        pytest.skip("there is no fmusim")
    for archive in (aligned[1] / version).glob("*.fmu"):
        finished = subprocess.run([fmusim, "validate", archive], check=False, capture_output=True, text=True)
        assert finished.returncode == 0, finished.stderr
        assert "error" not in finished.stderr


def test_enumerations_have_the_names_of_their_items(folder: Path) -> None:
    """As SSP wants it; libcosim could not set those of the OSP file, which has none."""
    for place in ("parameters", "parameters/fmi3"):
        document = etree.parse(folder / place / "filter.ssv")
        (corrector,) = document.xpath("//*[local-name()='Parameter'][@name='corrector']/*")
        assert (etree.QName(corrector).localname, corrector.get("value")) == ("Enumeration", "h_infinity")
    osp = (folder / "OspSystemStructure.xml").read_text(encoding="utf-8")
    assert 'variable="corrector"' not in osp
    assert 'variable="prior.heading_sigma"' in osp


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_what_is_set_is_in_the_fmu(folder: Path, fmus: Fmus, form: Form) -> None:
    """In modelDescription.xml and in the file that the binary reads; nothing else differs from the FMU."""
    system = of_scenario(
        load_scenario("swaying_ship", fmus, settings={**SHORT, "communication_step": EXPORTED_STEP}), fmus
    )
    for component in system.components:
        description = fmpy.read_model_description(folder / form.name / f"{component.fmu.name}.fmu")
        before = fmpy.read_model_description(form.archive(component.fmu))
        starts = {v.name: v.start for v in description.modelVariables}
        assert (description.defaultExperiment.stopTime, description.defaultExperiment.stepSize) == (
            "20.0",
            "0.1",
        )
        set_ = {entry.name for entry in form.entries(component, component.values)}
        changed = {v.name for v in before.modelVariables if v.start != starts[v.name]}
        assert changed
        assert changed <= set_
        for entry in form.entries(component, component.values):
            stated = [{"true": 1.0, "false": 0.0}.get(part) for part in starts[entry.name].split()]
            stated = [
                float(p) if v is None else v for p, v in zip(starts[entry.name].split(), stated, strict=True)
            ]
            assert stated == [float(component.value(element.name)) for element in entry.elements]


def test_the_partner_sees_platforms_and_final_values(folder: Path) -> None:
    text = (folder / "README.md").read_text()
    platforms = {
        path.split("/")[1]
        for path in zipfile.ZipFile(folder / "fmi2" / "TruthPlant.fmu").namelist()
        if path.startswith("binaries/")
    }
    assert f"binaries for {', '.join(sorted(platforms))}." in text
    with (folder / "reference" / "AlignmentFilter_ref.csv").open(newline="") as file:
        last = list(csv.DictReader(file))[-1]
    for name in ("nav.heading", "heading_sigma"):
        assert f"| `{name}` | {last[name]} |" in text


def test_exporting_again_gives_the_same_bytes(folder: Path, tmp_path: Path, fmus: Fmus) -> None:
    export("swaying_ship", tmp_path, set=SHORT, fmus=fmus)
    written = {
        path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()
    }
    assert len(written) > 10
    assert written == {
        path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRUENORTH_FMUS", str(FMUS))
    arguments = ["export", "swaying_ship", "--output", str(tmp_path / "partner"), "--json"]
    settings = [part for key, value in SHORT.items() for part in ("--set", f"{key}={value}")]
    result = CliRunner().invoke(app, [*arguments, *settings])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "partner" / "swaying_ship.ssp").exists()
    refused = CliRunner().invoke(app, [*arguments, *settings, "--step", "0.0123"])
    assert refused.exit_code == 2


def test_an_importer_goes_on_from_the_state_at_the_end(folder: Path) -> None:
    """The state lies in the FMU, too, and the manifest of FMI-LS-REF names it."""
    archive = folder / "fmi2" / "AlignmentFilter.fmu"
    fmu = Fmu(archive)
    with zipfile.ZipFile(archive) as content:
        manifest = etree.fromstring(content.read(f"{RESULTS}/fmi-ls-manifest.xml"))
        (source,) = (r.get("source") for r in manifest if r.get("role") == "serialized-state")
        state = content.read(f"{RESULTS}/{source}")
    assert state == (folder / "reference" / "AlignmentFilter_end.state").read_bytes()
    with (folder / "reference" / "AlignmentFilter_ref.csv").open(newline="") as file:
        last = list(csv.DictReader(file))[-1]
    with closing(Instance(fmu, "filter", {})) as instance:
        instance.restore(state)
        for name in ("nav.heading", "heading_sigma"):
            assert instance.read([name]) == [float(last[name])]
        instance.step(SHORT["duration"], EXPORTED_STEP)


def test_a_skeleton_begins_as_the_inputs_do(folder: Path) -> None:
    for place in ("", "fmi3/"):
        skeleton = (folder / "skeleton" / place / "AlignmentFilter_in.csv").read_text()
        inputs = (folder / "reference" / place / "AlignmentFilter_in.csv").read_text()
        assert inputs.startswith(skeleton)
        assert len(skeleton.splitlines()) == 3


def test_a_filter_alone_needs_no_counts(folder: Path, tmp_path: Path) -> None:
    """FMPy's command line, once with the inputs of the reference and once without their counts."""
    fmu, inputs = folder / "fmi2" / "AlignmentFilter.fmu", folder / "reference" / "AlignmentFilter_in.csv"
    with inputs.open(newline="") as file:
        rows = list(csv.reader(file))
    kept = [i for i, name in enumerate(rows[0]) if not name.endswith(".sample")]
    assert len(kept) < len(rows[0])
    uncounted = tmp_path / "uncounted.csv"
    with uncounted.open("w", newline="") as file:
        csv.writer(file).writerows([row[i] for i in kept] for row in rows)
    results = []
    for given in (inputs, uncounted):
        output = tmp_path / "out.csv"
        command = [sys.executable, "-m", "fmpy", "simulate", str(fmu), "--interface-type", "CoSimulation"]
        command += [
            "--input-file",
            str(given),
            "--output-file",
            str(output),
            "--stop-time",
            str(SHORT["duration"]),
        ]
        command += [
            "--output-interval",
            str(EXPORTED_STEP),
            "--output-variables",
            "nav.heading",
            "heading_sigma",
            "used_fixes",
        ]
        subprocess.run(command, check=True, capture_output=True)
        results.append(output.read_bytes())
    assert results[0] == results[1]
    assert float(results[0].splitlines()[-1].split(b",")[-1]) > 10


def test_the_evidence_is_that_of_the_fmus_and_settings(folder: Path, fmus: Fmus) -> None:
    """Provenance and bill of materials, beside the FMUs and in each of them."""
    said = json.loads((folder / "provenance.json").read_text())
    assert said["scenario"] == "swaying_ship"
    assert said["settings"] == {**SHORT, "seed": None}
    assert said["communication_step"] == EXPORTED_STEP
    assert said["stop_time"] == SHORT["duration"]
    built = {name: hashlib.sha256(fmus[name].path.read_bytes()).hexdigest() for name in said["fmus"]}
    assert built.keys() == {"TruthPlant", "AlignmentFilter"}
    assert {name: fmu["sha256"] for name, fmu in said["fmus"].items()} == built
    assert all(fmu["compilers"].values() for fmu in said["fmus"].values())
    bill = json.loads((folder / "sbom.cdx.json").read_text())
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.5")
    parts = {part["name"]: part for part in bill["components"]}
    assert {name: parts[name]["hashes"][0]["content"] for name in built} == built
    licences = {name: part["licenses"] for name, part in parts.items()}
    assert licences["Eigen"] == [{"expression": "MPL-2.0 AND Apache-2.0"}]
    assert licences["cereal"] == licences["TruthPlant"] == [{"license": {"id": "BSD-3-Clause"}}]
    assert all(licences.values())
    assert parts["Eigen"]["version"].startswith("3.4")
    with zipfile.ZipFile(folder / "fmi2" / "AlignmentFilter.fmu") as content:
        for name in ("provenance.json", "sbom.cdx.json"):
            assert content.read(f"{FOLDER}/{name}") == (folder / name).read_bytes()
