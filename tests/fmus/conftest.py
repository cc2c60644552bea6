"""Every FMU in build/fmus (or in $TRUENORTH_FMUS) is tested, without being named anywhere."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from calls import OK, Fmu, Instance, Number

ROOT = Path(__file__).parents[2]
FMUS = Path(os.environ.get("TRUENORTH_FMUS", ROOT / "build" / "fmus"))
ARCHIVES = sorted(FMUS.glob("*.fmu"))
FILTERS = [archive.stem for archive in ARCHIVES if archive.stem.endswith("Filter")]

STEP = 0.01
SAMPLES = 2000


def pytest_configure() -> None:
    if not ARCHIVES:
        raise pytest.UsageError(f"no FMU in {FMUS}: build them first")


@pytest.fixture(scope="session", params=ARCHIVES, ids=lambda archive: archive.stem)
def archive(request: pytest.FixtureRequest) -> Path:
    path: Path = request.param
    return path


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Fmu]:
    """Every FMU, loaded."""
    return {path.stem: Fmu.load(path, tmp_path_factory.mktemp(path.stem)) for path in ARCHIVES}


@pytest.fixture(scope="session")
def fmu(archive: Path, fmus: dict[str, Fmu]) -> Fmu:
    """One FMU after the other."""
    return fmus[archive.stem]


@pytest.fixture
def instance(fmu: Fmu) -> Iterator[Instance]:
    """A new instance that logs everything."""
    with fmu.instance(logging=True) as instance:
        yield instance


@pytest.fixture(scope="session")
def signals(fmus: dict[str, Fmu]) -> list[dict[str, Number]]:
    """Outputs of the plant after each of SAMPLES steps; filters' inputs have the same names."""
    with fmus["TruthPlant"].instance() as plant:
        plant.start()
        samples = []
        for index in range(SAMPLES):
            assert plant.step(index * STEP, STEP) == OK, plant.journal.last
            samples.append(plant.read())
        return samples


def variants(fmu: Fmu) -> list[dict[str, Number]]:
    """Parameters that choose each error model of a filter in turn; of any other FMU, none."""
    chooser = fmu.variables.get("error_model")
    if chooser is None:
        return [{}]
    models = range(1, len(chooser.declaredType.items) + 1)
    return [{"error_model": model, **requirements(fmu, model)} for model in models]


def requirements(fmu: Fmu, model: int) -> dict[str, Number]:
    """What an error model asks of the other parameters: the Euler models, a stationary base."""
    name = fmu.variables["error_model"].declaredType.items[model - 1].name
    return {"initial.velocity[2]": 0.0} if name.startswith("euler") else {}
