"""A ship simulator, an FMU in C, drives TruthPlant, and a filter aligns on what its IMU measures."""

from __future__ import annotations

import math
import shutil
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from c_program import HEADERS
from calls import OK, Fmu, Instance, Number
from fmpy import platform, sharedLibraryExtension

NAME = "ship_simulator"
EXTERNAL = 4
STOP = 240.0
STATE = ("position", "velocity", "attitude", "acceleration", "body_rate")
RATES = ("external.acceleration", "external.body_rate")

Values = dict[str, Number]


@pytest.fixture(scope="module")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    folder = tmp_path_factory.mktemp(NAME)
    library = folder / f"{NAME}{sharedLibraryExtension}"
    options = ["-std=c11", "-O1", "-shared", "-fPIC", f"-I{HEADERS}"]
    source = Path(__file__).with_name(f"{NAME}.c")
    subprocess.run([compiler, *options, source, "-lm", "-o", library], check=True)
    archive = folder / f"{NAME}.fmu"
    with zipfile.ZipFile(archive, "w") as content:
        content.writestr("modelDescription.xml", description())
        content.write(library, f"binaries/{platform}/{library.name}")
    return Fmu.load(archive, folder / "unpacked")


def description() -> str:
    names = ["external.time", *(f"external.{name}[{i}]" for name in STATE for i in (1, 2, 3))]
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="output"><Real/>'
        "</ScalarVariable>"
        for reference, name in enumerate(names)
    )
    outputs = "".join(f'<Unknown index="{index}"/>' for index in range(1, len(names) + 1))
    return (
        f'<fmiModelDescription fmiVersion="2.0" modelName="{NAME}" guid="{{{NAME}}}">'
        f'<CoSimulation modelIdentifier="{NAME}" canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure><Outputs>{outputs}</Outputs></ModelStructure></fmiModelDescription>"
    )


@pytest.fixture
def ship(simulator: Fmu) -> Iterator[Instance]:
    with simulator.instance() as instance:
        yield instance.start()


@pytest.fixture
def plant(fmus: dict[str, Fmu], ship: Instance) -> Iterator[Instance]:
    """A plant with a perfect IMU and receiver, which knows where the ship is at the beginning."""
    with fmus["TruthPlant"].instance(logging=True) as instance:
        instance.set("motion.kind", EXTERNAL)
        for sensor in ("gyro", "accelerometer"):
            for error in ("bias_sigma", "white_noise"):
                assert instance.set(f"imu.{sensor}.{error}", 0.0) == OK
        tell(instance, ship.read())
        yield instance.start()


def tell(instance: Instance, values: Values) -> None:
    instance.inputs.assign(values)
    assert instance.inputs.write(instance) == OK


def wrapped(angle: Number) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi


def apart(plant: Values, ship: Values) -> float:
    """Largest difference of the plant's truth from the ship, in m, m/s and rad."""
    position, velocity, attitude = (
        [ship[f"external.{name}[{i}]"] for i in (1, 2, 3)] for name in ("position", "velocity", "attitude")
    )
    radius = 6.4e6
    return max(
        radius * abs(plant["truth.latitude"] - position[0]),
        radius * abs(wrapped(plant["truth.longitude"] - position[1])),
        abs(plant["truth.height"] - position[2]),
        *(abs(plant[f"truth.velocity[{i}]"] - velocity[i - 1]) for i in (1, 2, 3)),
        *(
            abs(wrapped(plant[f"truth.{name}"] - angle))
            for name, angle in zip(("roll", "pitch", "heading"), attitude, strict=True)
        ),
    )


@pytest.mark.parametrize("told", [True, False], ids=["with rates", "without"])
@pytest.mark.parametrize("step", [0.01, 0.1])
def test_the_plant_is_where_the_ship_is(told: bool, step: float, plant: Instance, ship: Instance) -> None:
    """The ship steps first and stamps its state; headings turn through north, and no state is refused."""
    headings = []
    for index in range(round(60.0 / step)):
        assert ship.step(index * step, step) == OK
        state = ship.read()
        tell(plant, {name: value for name, value in state.items() if told or not name.startswith(RATES)})
        assert plant.step(index * step, step) == OK
        put_out = plant.read()
        assert put_out["imu.time"] == pytest.approx((index + 1) * step, abs=1e-9)
        assert apart(put_out, state) < 1e-8
        headings.append(put_out["truth.heading"])
    assert plant.get("external.rejected") == 0
    assert min(headings) < 0.2 < 6.1 < max(headings)


def test_a_master_that_steps_all_at_once_is_one_step_late(plant: Instance, ship: Instance) -> None:
    step = 0.1
    for index in range(200):
        told = ship.read()
        tell(plant, told)
        assert ship.step(index * step, step) == OK
        assert plant.step(index * step, step) == OK
        put_out = plant.read()
        assert put_out["truth.time"] == pytest.approx(index * step, abs=1e-9)
        assert apart(put_out, told) < 1e-8
    assert plant.get("external.rejected") == 0


def test_a_filter_finds_the_heading_of_the_ship(
    plant: Instance, ship: Instance, fmus: dict[str, Fmu]
) -> None:
    """From 10 deg off, against what the simulator says, not the plant."""
    step = 0.05
    with fmus["AlignmentFilter"].instance() as alignment:
        begin = ship.read()
        start = {f"initial.velocity[{i}]": begin[f"external.velocity[{i}]"] for i in (1, 2, 3)}
        for of, names in (
            ("position", ("latitude", "longitude", "height")),
            ("attitude", ("roll", "pitch", "heading")),
        ):
            start |= {f"initial.{name}": begin[f"external.{of}[{i}]"] for i, name in enumerate(names, 1)}
        start["initial.heading"] += math.radians(10)
        for name, value in start.items():
            assert alignment.set(name, value) == OK
        tell(alignment, plant.read())
        alignment.start()
        for index in range(round(STOP / step)):
            assert ship.step(index * step, step) == OK
            tell(plant, ship.read())
            assert plant.step(index * step, step) == OK
            tell(alignment, plant.read())
            assert alignment.step(index * step, step) == OK
        error = wrapped(alignment.get("nav.heading") - ship.get("external.attitude[3]"))
        sigma = alignment.get("heading_sigma")
    assert sigma < math.radians(0.5)
    assert abs(error) < 3 * sigma
