"""`truenorth replay`: its options, what it prints, writes and refuses."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from plant_signals import as_csv, sensed
from typer.testing import CliRunner, Result

from sim_scenarios import recording
from sim_scenarios.cli.application import app
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.recordings.exports import export
from sim_scenarios.recordings.readers import rtklib
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.units import DEGREE

LENGTH = 100.0  # s
HEADING = 0.0
SURE = ["--set", "convergence.heading_sigma=5 deg", "--set", "convergence.hold_time=10"]


def truenorth(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def ship(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("ship") / "ship.csv"
    return as_csv(sensed(Fmus(), "align_then_navigate", LENGTH), path)


@pytest.fixture(scope="module")
def navigated(ship: Path) -> tuple[Path, Result]:
    """Navigation with outages, everything written."""
    folder = ship.parent / "navigated"
    options = [
        "--filter",
        "navigation",
        "--heading",
        4,
        "--outages",
        10,
        "--every",
        40,
        "--evaluate-after",
        20,
    ]
    exports = [part for form in ("csv", "gpx", "kml", "mcap", "pos") for part in ("--export", form)]
    return folder, truenorth("replay", ship, *options, *exports, *SURE, "-o", folder, "--json")


def test_what_machines_are_told(navigated: tuple[Path, Result]) -> None:
    folder, result = navigated
    assert result.exit_code in (0, 1), result.output
    content = json.loads(result.stdout)
    assert content["converged"] == (result.exit_code == 0)
    assert content["headings"][0]["heading_deg"] == pytest.approx(4, abs=1e-3)
    assert content["report"] == str(folder / "report.html")
    assert content["recording"] == str(folder / "recording.nc")
    assert [(e["begin_s"], e["end_s"]) for e in content["outages"]["each"]] == [
        (pytest.approx(30), pytest.approx(40)),
        (pytest.approx(70), pytest.approx(80)),
    ]
    squares = [e["horizontal_m"] ** 2 for e in content["outages"]["each"]]
    assert content["outages"]["horizontal_rms_m"] == pytest.approx(np.sqrt(np.mean(squares)))
    assert content["against_fixes"]["fixes"] == 61  # of 81, from 20 s to 100 s, twenty in the dark
    assert "against_reference" not in content


def test_a_smoothed_navigation_stands_beside_the_filters(ship: Path, tmp_path: Path) -> None:
    options = ["--filter", "navigation", "--heading", 4, "--outages", 10, "--every", 40]
    told = truenorth("replay", ship, *options, "--smooth", "--export", "csv", "-o", tmp_path / "out")
    assert told.exit_code in (0, 1), told.output
    assert "largest, smoothed [m]" in told.stdout
    data = recording.load(tmp_path / "out" / "recording.nc")
    table = pd.read_csv(tmp_path / "out" / "track.csv")
    np.testing.assert_allclose(table["heading_deg"] * DEGREE, data["smoothed.nav.heading"], rtol=1e-14)
    np.testing.assert_allclose(
        table["position_sigma_up_m"], data["smoothed.position_sigma"][:, 2], rtol=1e-14
    )
    assert not np.array_equal(data["smoothed.nav.heading"], data["nav.heading"])
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Filtered and smoothed</h2>" in page
    for name in ("smoothed_heading", "smoothed_outages", "track"):
        assert f'<figure id="{name}">' in page
    assert "smoothed_fixes" not in page

    told = truenorth("replay", ship, *options, "--smooth", "-o", tmp_path / "out", "--json")
    content = json.loads(told.stdout)
    both = [content["outages"], content["smoothed"]["outages"]]
    assert [len(one["each"]) for one in both] == [2, 2]
    assert both[0]["largest_m"] == max(each["largest_m"] for each in both[0]["each"])
    assert content["smoothed"]["against_fixes"]["fixes"] == 0

    axis = ["--axis", "predictor=linearised,unscented"]
    told = truenorth("replay", ship, *options, "--smooth", *axis, "-o", tmp_path / "axis")
    assert "unscented, smoothed" in told.stdout, told.output


def test_the_report_shows_track_course_and_outages(navigated: tuple[Path, Result]) -> None:
    folder, _ = navigated
    page = (folder / "report.html").read_text(encoding="utf-8")
    for name in ("track", "course", "outages", "heading", "states", "innovations"):
        assert f'<figure id="{name}">' in page
        assert (folder / f"{name}.png").is_file()
    assert "RMS at the ends of 2 outages" in page
    assert "Heading minus course above 3 m/s" in page


def test_a_run_is_kept_whole(navigated: tuple[Path, Result]) -> None:
    data = recording.load(navigated[0] / "recording.nc")
    assert data.sizes["receiver"] == 100
    assert int(data["receiver.withheld"].sum()) == 20
    np.testing.assert_allclose(data["outage_end"], [40.0, 80.0])


@pytest.fixture(scope="module")
def data(navigated: tuple[Path, Result]) -> xr.Dataset:
    return recording.load(navigated[0] / "recording.nc")


def test_the_table_holds_the_navigation(navigated: tuple[Path, Result], data: xr.Dataset) -> None:
    table = pd.read_csv(navigated[0] / "track.csv")
    assert len(table) == data.sizes["time"]
    np.testing.assert_allclose(table["heading_deg"] * DEGREE, data["nav.heading"], rtol=1e-14)
    np.testing.assert_allclose(table["latitude_deg"] * DEGREE, data["nav.latitude"], rtol=1e-14)
    np.testing.assert_allclose(table["velocity_north_m_per_s"], data["nav.velocity"][:, 1], rtol=1e-14)
    np.testing.assert_allclose(table["position_sigma_up_m"], data["position_sigma"][:, 2], rtol=1e-14)


def test_another_program_reads_the_solution_file(navigated: tuple[Path, Result], data: xr.Dataset) -> None:
    """As the reader of RTKLIB's files has it: weeks and seconds, north before east."""
    contents = rtklib.read(navigated[0] / "track.pos")
    fixes = contents.gnss
    assert fixes is not None
    np.testing.assert_allclose(contents.epoch + fixes.time, data["time"], atol=1e-3)
    assert "% date      : not known" in (navigated[0] / "track.pos").read_text()
    np.testing.assert_allclose(fixes.position[:, 0], data["nav.latitude"], atol=1e-9 * DEGREE)
    np.testing.assert_allclose(fixes.position[:, 1], data["nav.longitude"], atol=1e-9 * DEGREE)
    np.testing.assert_allclose(fixes.position[:, 2], data["nav.height"], atol=1e-4)
    np.testing.assert_allclose(fixes.velocity, data["nav.velocity"], atol=1e-5)
    np.testing.assert_allclose(fixes.position_sigma, data["position_sigma"], atol=1e-4)
    np.testing.assert_allclose(fixes.velocity_sigma, data["velocity_sigma"], atol=1e-5)


def test_a_solution_file_of_a_dated_recording_has_its_date(ship: Path, tmp_path: Path) -> None:
    """In seconds since 1970: 2025-01-01 12:00 UTC, 18 leap seconds later in GPS time."""
    names = 'position = ["gnss_latitude", "gnss_longitude", "gnss_height"], velocity = ['
    names += '"gnss_velocity_east", "gnss_velocity_north", "gnss_velocity_up"]'
    description = tmp_path / "dated.toml"
    dated = f'file = "{ship}"\nclock = "unix"\noffset = 1735732800'
    description.write_text(
        f"[imu]\n{dated}\n[gnss]\n{dated}\n"
        f'columns = {{ time = "gnss_time", {names} }}\nunits = {{ position = "deg" }}\n'
    )
    result = truenorth("replay", description, "--heading", 4, "--export", "pos", "-o", tmp_path / "out")
    assert result.exit_code in (0, 1), result.output
    contents = rtklib.read(tmp_path / "out" / "track.pos")
    assert contents.clock is Clock.GPS
    assert contents.gnss is not None
    day = (np.datetime64("2025-01-01") - np.datetime64("1980-01-06")) / np.timedelta64(1, "s")
    begin = day + 12 * 3600 + 18
    assert contents.epoch + contents.gnss.time[-1] == pytest.approx(begin + LENGTH, abs=2e-3)
    assert contents.epoch + contents.gnss.time[0] < begin + LENGTH
    assert "not known" not in (tmp_path / "out" / "track.pos").read_text()


def test_maps_read_the_track(navigated: tuple[Path, Result], data: xr.Dataset) -> None:
    gpx = ElementTree.parse(navigated[0] / "track.gpx").getroot()
    points = gpx.findall(".//{http://www.topografix.com/GPX/1/1}trkpt")
    latitudes = [float(point.attrib["lat"]) * DEGREE for point in points]
    np.testing.assert_allclose(latitudes, data["nav.latitude"], atol=1e-9 * DEGREE)
    kml = ElementTree.parse(navigated[0] / "track.kml").getroot()
    (line,) = kml.findall(".//{http://www.opengis.net/kml/2.2}coordinates")
    places = np.array([place.split(",") for place in str(line.text).split()], dtype=float)
    np.testing.assert_allclose(places[:, 0] * DEGREE, data["nav.longitude"], atol=1e-9 * DEGREE)
    np.testing.assert_allclose(places[:, 2], data["nav.height"], atol=1e-4)


def test_a_format_that_is_none_is_refused(data: xr.Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="format = 'shp': must be one of csv, gpx, kml, mcap, pos"):
        export(data, tmp_path / "track.shp")


def test_a_start_on_the_course_and_what_people_are_told(ship: Path, tmp_path: Path) -> None:
    options = ["--filter", "navigation", "--start", "course", "--course-speed", 5, "--evaluate-after", 20]
    result = truenorth("replay", ship, *options, "--outages", 10, "--every", 40, *SURE, "-o", tmp_path)
    assert result.exit_code in (0, 1), result.output
    assert "Heading minus course above 3 m/s" in result.stdout
    assert "outage from [s]" in result.stdout
    assert "RMS at the ends of 2 outages" in result.stdout
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "on the course of" in page


def test_an_alignment_before_navigation(ship: Path, tmp_path: Path) -> None:
    told = ["alignment.convergence.heading_sigma=20 deg", "alignment.convergence.hold_time=5"]
    settings = [part for value in told for part in ("--set", value)]
    options = ["--filter", "align_then_navigate", "--evaluate-after", 20, "--json", "-o", tmp_path]
    result = truenorth("replay", ship, *options, *settings)
    assert result.exit_code in (0, 1), result.output
    data = recording.load(tmp_path / "recording.nc")
    assert 0 < float(data["hand_over_time"]) < LENGTH
    judged = data["fix_time"].values >= max(20.0, float(data["hand_over_time"]))
    off = np.hypot(data["innovation"].values[judged, 0], data["innovation"].values[judged, 1])
    said = json.loads(result.stdout)
    assert said["against_fixes"]["horizontal_rms_m"] == pytest.approx(float(np.sqrt(np.mean(off**2))))
    assert all(row["sigma_deg"] > 0 for row in said["headings"])  # those of the alignment, then of navigation


def test_an_alignment_that_hands_nothing_over_is_told(ship: Path, tmp_path: Path) -> None:
    never = ["--set", "alignment.convergence.hold_time=500"]
    result = truenorth("replay", ship, "--filter", "align_then_navigate", "-o", tmp_path, *never)
    assert result.exit_code == 1, result.output
    assert "Navigation did not begin: the alignment handed nothing over, it is aligning" in result.stdout
    at_end = recording.load(tmp_path / "recording.nc")["alignment.heading_sigma"].values[-1] / DEGREE
    assert f"Its 1 sigma           {at_end:.3f} deg" in result.stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--filter", "navigation"], "the model loose of NavigationFilter needs a heading to start from"),
        (["--start", "course", "--heading", 5], "only one can be"),
        (["--start", "course", "--course-speed", 50], "no fix of the IMU's time is as fast as 50 m/s"),
        (
            ["--heading", 5, "--outages", 10, "--every", 5],
            "must be longer than 0 and shorter than their period",
        ),
        (["--heading", 5, "--outages", 10, "--every", 500], "the recording must be at least that long"),
        (["--heading", 5, "--position", "1,2"], "LATITUDE,LONGITUDE,HEIGHT"),
        (["--heading", 5, "--smooth"], "smoothing: AlignmentFilter does not navigate"),
        (
            ["--filter", "navigation", "--heading", 5, "--smooth", "--set", "error_model=full_state"],
            "error_model = full_state: cannot be smoothed",
        ),
    ],
)
def test_what_does_not_fit_is_refused(
    ship: Path, tmp_path: Path, options: list[object], message: str
) -> None:
    result = truenorth("replay", ship, *options, "-o", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert message in " ".join(result.stderr.split())
    assert not (tmp_path / "out").exists()


def test_a_filter_that_is_contradicted_is_told_of_derive(ship: Path, tmp_path: Path) -> None:
    """Fixes of 0.1 m/s, told to be good to 1 mm/s."""
    told = ["--set", "measurement.velocity_sigma=0.001", "--set", "measurement.position_sigma=0.01"]
    result = truenorth("replay", ship, "--filter", "navigation", "--heading", 0, *told, "-o", tmp_path / "r")
    assert result.exit_code == 1, result.output
    assert "`truenorth derive` finds their noise" in " ".join(result.output.split())
