"""Every FMU in build/fmus (or in $TRUENORTH_FMUS) is tested, without being named anywhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from archives import ARCHIVES, FMUS, SAMPLES, STEP, give_recording
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
    """Every FMU, loaded; Playback has a recording of what the plant puts out."""
    loaded = {path.stem: Fmu.load(path, tmp_path_factory.mktemp(path.stem)) for path in ARCHIVES}
    give_recording(loaded["Playback"].folder, put_out_by(loaded["TruthPlant"]))
    return loaded


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
    return put_out_by(fmus["TruthPlant"])


def put_out_by(plant: Fmu) -> list[dict[str, Number]]:
    """Outputs of a plant after each of SAMPLES steps."""
    with plant.instance() as instance:
        instance.start()
        samples = []
        for index in range(SAMPLES):
            assert instance.step(index * STEP, STEP) == OK, instance.journal.last
            samples.append(instance.read())
        return samples
