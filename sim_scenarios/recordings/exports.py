"""The result of a replay for other programs: CSV, GPX, KML, RTKLIB's .pos, and MCAP (`mcap`).

Times are seconds of the recording's own clock. A .pos file has them as weeks and seconds of GPS time, or,
where the recording does not tell the date, from week 0 on, and says so; a GPX file has none.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.recordings import mcap, track
from sim_scenarios.recordings.choices import Format
from sim_scenarios.recordings.readers.gps_time import WEEK
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

FLOAT: Final = 2
"""RTKLIB's quality of a solution that is not fixed to whole wavelengths."""


def export(run: xr.Dataset, path: Path) -> Path:
    """Write the navigation of a replay, from where it has one.

    Parameters
    ----------
    run : Dataset
        Of `recordings.replay`.
    path : Path
        Its ending says the format: .csv, .gpx, .kml, .mcap, .pos.

    Returns
    -------
    Path
        The same.
    """
    form = Format(path.suffix.removeprefix("."))
    part = run.isel(time=run["time"].values >= track.navigates_from(run))
    if form is Format.mcap:
        mcap.write(part, path)
    else:
        writer = {Format.csv: _csv, Format.gpx: _gpx, Format.kml: _kml, Format.pos: _pos}[form]
        path.write_text(writer(part), encoding="utf-8")
    return path


def check(form: Format) -> None:
    """Refuse, before the work, a format that cannot be written for want of a package."""
    if form is Format.mcap:
        mcap.packages()


def _csv(run: xr.Dataset) -> str:
    """Angles in deg, all else in SI; sigmas of attitude and heading, east, north, up."""
    latitude, longitude, height = track.positions(run).T
    table = {
        "time": run["time"].values,
        "latitude_deg": latitude / DEGREE,
        "longitude_deg": longitude / DEGREE,
        "height_m": height,
        **_vector("velocity", "m_per_s", run["nav.velocity"].values),
        **{f"{angle}_deg": run[f"nav.{angle}"].values / DEGREE for angle in ("roll", "pitch", "heading")},
        **_vector("position_sigma", "m", run["position_sigma"].values),
        **_vector("velocity_sigma", "m_per_s", run["velocity_sigma"].values),
        "heading_sigma_deg": run["heading_sigma"].values / DEGREE,
        "converged": run["converged"].values.astype(int),
    }
    text: str = pd.DataFrame(table).to_csv(index=False, float_format="%.15g", lineterminator="\n")
    return text


def _gpx(run: xr.Dataset) -> str:
    root = ElementTree.Element(
        "gpx", {"xmlns": "http://www.topografix.com/GPX/1/1", "version": "1.1", "creator": "TrueNorth"}
    )
    of_track = ElementTree.SubElement(root, "trk")
    ElementTree.SubElement(of_track, "name").text = run.attrs["recording"]
    segment = ElementTree.SubElement(of_track, "trkseg")
    for latitude, longitude, height in _places(run):
        point = ElementTree.SubElement(segment, "trkpt", {"lat": latitude, "lon": longitude})
        ElementTree.SubElement(point, "ele").text = height
    return _document(root)


def _kml(run: xr.Dataset) -> str:
    root = ElementTree.Element("kml", {"xmlns": "http://www.opengis.net/kml/2.2"})
    place = ElementTree.SubElement(ElementTree.SubElement(root, "Document"), "Placemark")
    ElementTree.SubElement(place, "name").text = run.attrs["recording"]
    line = ElementTree.SubElement(place, "LineString")
    ElementTree.SubElement(line, "coordinates").text = " ".join(
        f"{longitude},{latitude},{height}" for latitude, longitude, height in _places(run)
    )
    return _document(root)


def _pos(run: xr.Dataset) -> str:
    """Columns of RTKLIB 2.4 with velocities; standard deviations north, east, up, without covariances."""
    week, second = np.divmod(run.attrs.get("epoch", 0.0) + run["time"].values, WEEK)
    latitude, longitude, height = track.positions(run).T
    east, north, up = run["nav.velocity"].values.T
    sigma, velocity_sigma = (run[f"{name}_sigma"].values[:, [1, 0, 2]].T for name in ("position", "velocity"))
    none = np.zeros(len(week))
    columns = {
        "%4d": (week,),
        "%10.3f": (second,),
        "%14.9f": (latitude / DEGREE, longitude / DEGREE),
        "%10.4f": (height,),
        "%3d": (np.full_like(week, FLOAT), none),
        "%8.4f": (*sigma, none, none, none),
        "%6.2f": (none, none),
        "%10.5f": (north, east, up, *velocity_sigma, none, none, none),
    }
    formats = [form for form, values in columns.items() for _ in values]
    rows = np.column_stack([column for values in columns.values() for column in values])
    line = " ".join(formats)
    names = (
        "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) "
        "age(s) ratio vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu sdvne sdveu sdvun"
    )
    head = ["% program   : TrueNorth", f"% inp file  : {run.attrs['recording']}"]
    if "epoch" not in run.attrs:
        head.append("% date      : not known; seconds of the recording's own clock, from week 0 on")
    return "\n".join([*head, names, *(line % tuple(row) for row in rows)]) + "\n"


def _vector(name: str, unit: str, values: Array) -> dict[str, Array]:
    return {f"{name}_{axis}_{unit}": values[:, i] for i, axis in enumerate(("east", "north", "up"))}


def _places(run: xr.Dataset) -> list[tuple[str, str, str]]:
    """Latitude and longitude [deg], height [m], as text."""
    places = track.positions(run) / [DEGREE, DEGREE, 1.0]
    places[:, 1] = (places[:, 1] + 180) % 360 - 180
    return [(f"{place[0]:.9f}", f"{place[1]:.9f}", f"{place[2]:.4f}") for place in places]


def _document(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"
