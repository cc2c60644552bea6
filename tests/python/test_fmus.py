"""Finding FMUs, and values in the units that they declare."""

import zipfile
from pathlib import Path

import fmpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_scenarios.archives import write_archive
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmu, Fmus, Unit, find, search_path
from sim_scenarios.instance import Instance

DEG = Unit("rad", {"deg": (57.29577951308232, 0.0)})
FAHRENHEIT = Unit("K", {"degF": (1.8, -459.67)})


@given(st.floats(-1e6, 1e6))
def test_display_units_invert(value: float) -> None:
    assert DEG.to_si(f"{value!r} deg") == pytest.approx(value / 57.29577951308232)
    assert DEG.to_si(f"{value!r} rad") == DEG.to_si(f"{value!r}") == DEG.to_si(value) == value


def test_display_units_with_an_offset() -> None:
    assert FAHRENHEIT.to_si("32 degF") == pytest.approx(273.15)


@pytest.mark.parametrize("text", ["10 mg", "ten deg", "10 deg deg", "", "deg", "1e", "nan deg"])
def test_refuses_what_is_no_quantity(text: str) -> None:
    with pytest.raises(InputError, match=r"neither a number nor|not in a unit"):
        DEG.to_si(text)


def test_says_which_units_there_are() -> None:
    with pytest.raises(InputError, match=r"'10 mg' is not in a unit of this quantity: rad, deg"):
        DEG.to_si("10 mg")


def test_the_environment_names_the_only_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Other FMUs than those that were asked for would be worse than none."""
    monkeypatch.delenv("TRUENORTH_FMUS", raising=False)
    assert [folder.name for folder in search_path()] == ["fmus", "fmus"]
    monkeypatch.setenv("TRUENORTH_FMUS", str(tmp_path))
    assert search_path() == [tmp_path]
    with pytest.raises(InputError, match=rf"TruthPlant.fmu is not in {tmp_path};"):
        find("TruthPlant")
    (tmp_path / "TruthPlant.fmu").touch()
    assert find("TruthPlant") == tmp_path / "TruthPlant.fmu"


def test_whole_numbers_keep_their_declared_range(fmus: Fmus) -> None:
    assert fmus.plant.assignments("seed", 2**31 - 1) == {"seed": 2**31 - 1}
    for seed in (-1, 2**31):
        with pytest.raises(InputError, match=rf"seed: {seed} is not a whole number from 0 to 2147483647"):
            fmus.plant.assignments("seed", seed)


def test_what_an_fmu_says_is_shown_in_the_units_that_people_read(fmus: Fmus) -> None:
    said = "motion.latitude = 1.6580627893946132: must be at most 1.5707963267948966"
    assert fmus.plant.readable(said) == "motion.latitude = 95 deg: must be at most 90 deg"
    for other in ("seed = -1: must be at least 0", "teapot = 1.5: must be at most 1", "no rule at all"):
        assert fmus.plant.readable(other) == other


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_refuses_what_is_not_finite(number: float) -> None:
    with pytest.raises(InputError, match="not a finite number"):
        DEG.to_si(number)


def test_a_missing_fmu_is_explained() -> None:
    with pytest.raises(InputError, match=r"Teapot.fmu is not in .*run `make fmus`.*TRUENORTH_FMUS"):
        find("Teapot")


def test_what_is_no_fmu_is_refused(tmp_path: Path) -> None:
    (tmp_path / "Broken.fmu").write_bytes(b"PK")
    with pytest.raises(InputError, match=r"Broken.fmu is not an FMU"):
        Fmu(tmp_path / "Broken.fmu")


def with_binary_for(platform: str, fmu: Fmu, folder: Path) -> Fmu:
    """A copy with the binary of this machine as if it were that of a platform."""
    with zipfile.ZipFile(fmu.path) as content:
        members = {"modelDescription.xml": content.read("modelDescription.xml")}
        members[f"binaries/{platform}/{fmu.library.name}"] = fmu.library.read_bytes()
    write_archive(folder / fmu.path.name, members)
    return Fmu(folder / fmu.path.name)


def test_binaries_are_found_where_fmi_2_has_no_name_for_the_platform(fmus: Fmus, tmp_path: Path) -> None:
    fmu = with_binary_for(fmpy.platform_tuple, fmus.plant, tmp_path)
    Instance(fmu, "plant", {}).close()


def test_an_fmu_for_other_machines_says_so(fmus: Fmus, tmp_path: Path) -> None:
    fmu = with_binary_for("riscv64-linux", fmus.plant, tmp_path)
    with pytest.raises(InputError, match=rf"no binary for {fmpy.platform_tuple}; it has riscv64-linux"):
        Instance(fmu, "plant", {})


def test_quantities_of_the_fmus(fmus: Fmus) -> None:
    hour = 3600.0
    expected = {
        ("plant", "imu.gyro.bias_sigma", "0.05 deg/h"): 0.05 / 57.29577951308232 / hour,
        ("plant", "imu.accelerometer.bias_sigma", "1 mg"): 9.80665e-3,
        ("plant", "imu.accelerometer.white_noise", "50 ug/Hz^0.5"): 50e-6 * 9.80665,
        ("filter", "process.angle_random_walk", "0.005 deg/h^0.5"): 0.005 / 57.29577951308232 / hour**0.5,
        # 0.005 deg/h^0.5 as a density (IEEE Std 952): a sixtieth of 0.3 (deg/h)/Hz^0.5.
        ("filter", "process.angle_random_walk", "0.3 deg/h/Hz^0.5"): 0.005 / 57.29577951308232 / hour**0.5,
        ("filter", "process.angle_random_walk", "0.01 deg/s/Hz^0.5"): 0.6 / 57.29577951308232 / hour**0.5,
        ("filter", "process.velocity_random_walk", "0.03 m/s/h^0.5"): 0.03 / hour**0.5,
        ("filter", "prior.heading_sigma", "10 deg"): 10 / 57.29577951308232,
    }
    for (which, name, text), value in expected.items():
        fmu: Fmu = getattr(fmus, which)
        assert fmu.assignments(name, text) == {name: pytest.approx(value, rel=1e-12)}


def test_arrays_elements_and_lists(fmus: Fmus) -> None:
    names = [f"imu.gyro.bias[{i}]" for i in (1, 2, 3)]
    plant = fmus.plant
    assert plant.assignments("imu.gyro.bias", 1e-7) == dict.fromkeys(names, 1e-7)
    assert plant.assignments("imu.gyro.bias", [1, 2, 3]) == dict(zip(names, (1.0, 2.0, 3.0), strict=True))
    assert plant.assignments("imu.gyro.bias[2]", 1e-7) == {names[1]: 1e-7}


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("imu.gyro.bais", 0.0, "TruthPlant has no parameter 'imu.gyro.bais'; did you mean 'imu.gyro.bias'"),
        ("imu.gyro.bias[4]", 0.0, r"no element imu.gyro.bias\[4\]; the indices run from 1 to 3"),
        ("imu.gyro.bias", [1.0, 2.0], "imu.gyro.bias has 3 elements, 2 are given"),
        ("truth.heading", 0.0, "truth.heading is an output of TruthPlant, not a parameter"),
        ("seed", 1.5, "seed: '1.5' is not a whole number"),
        ("seed", True, "seed: 'True' is not a whole number"),
        (
            "motion.kind",
            "shp",
            "motion.kind: 'shp' is none of ship, parked_vehicle, flight, external, road_vehicle; "
            "did you mean 'ship'",
        ),
    ],
)
def test_refuses_with_name_value_and_rule(fmus: Fmus, name: str, given: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        fmus.plant.assignments(name, given)


def test_booleans_and_enumerations(fmus: Fmus) -> None:
    assert fmus.filter.assignments("gate.enabled", False) == {"gate.enabled": False}
    assert fmus.filter.assignments("predictor", "linearised") == fmus.filter.assignments("predictor", 1)
    with pytest.raises(InputError, match="neither true nor false"):
        fmus.filter.assignments("gate.enabled", "yes")


def test_values_are_shown_in_display_units(fmus: Fmus) -> None:
    for name, text, shown in (
        ("prior.heading_sigma", "10 deg", "10 deg"),
        ("corrector", "h_infinity", "h_infinity"),
        ("gate.enabled", True, "true"),
        ("robust.gamma", 2.0, "2"),
    ):
        (value,) = fmus.filter.assignments(name, text).values()
        assert fmus.filter.variables[name].display(value) == shown
