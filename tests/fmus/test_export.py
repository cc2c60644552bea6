"""What `truenorth export` writes: sound by the schemas, complete, and the same every time."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from archives import FMUS
from fmpy.validation import validate_fmu
from lxml import etree
from typer.testing import CliRunner

from sim_scenarios.cli.application import app
from sim_scenarios.exchange import export
from sim_scenarios.fmus import Fmu, Fmus

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
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
def test_schemas(folder: Path, member: str, schema: str) -> None:
    with zipfile.ZipFile(folder / "swaying_ship.ssp") as content:
        document = etree.fromstring(content.read(member))
    etree.XMLSchema(etree.parse(SCHEMAS / schema)).assertValid(document)


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_the_fmus_stay_valid_and_carry_their_experiment(folder: Path, version: str) -> None:
    for archive in (folder / version).glob("*.fmu"):
        assert validate_fmu(str(archive)) == []
        with zipfile.ZipFile(archive) as content:
            experiment = etree.fromstring(content.read(f"{RESULTS}/experiments.xml"))[0]
            assert float(experiment.get("stopTime")) == SHORT["duration"]
            for part in experiment:
                assert content.read(f"{RESULTS}/{part.get('source')}")


def test_a_scenario_that_libcosim_cannot_set_says_so(folder: Path, tmp_path: Path, fmus: Fmus) -> None:
    """The corrector of this scenario is not the default one."""
    assert not (folder / "OspSystemStructure.xml").exists()
    assert "libcosim knows no enumerations and cannot set corrector" in (folder / "README.md").read_text()
    export("swaying_ship", tmp_path, set={**SHORT, "corrector": "standard"}, fmus=fmus)
    assert (tmp_path / "OspSystemStructure.xml").exists()


def test_exporting_again_gives_the_same_bytes(folder: Path, tmp_path: Path, fmus: Fmus) -> None:
    export("swaying_ship", tmp_path, set=SHORT, fmus=fmus)
    written = {path.relative_to(tmp_path): path.read_bytes() for path in tmp_path.rglob("*.*")}
    assert len(written) > 10
    assert written == {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.*")}


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRUENORTH_FMUS", str(FMUS))
    arguments = ["export", "swaying_ship", "--output", str(tmp_path / "partner"), "--json"]
    settings = [part for key, value in SHORT.items() for part in ("--set", f"{key}={value}")]
    result = CliRunner().invoke(app, [*arguments, *settings])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "partner" / "swaying_ship.ssp").exists()
    refused = CliRunner().invoke(app, [*arguments, *settings, "--step", "0.0123"])
    assert refused.exit_code == 2
