"""Every FMU in build/fmus (or in $TRUENORTH_FMUS) is tested, without being named anywhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from archives import ARCHIVES, FMUS, SAMPLES, STEP
from calls import OK, Fmu, Instance, Number


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
