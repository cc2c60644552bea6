"""Files of trajectories: read as written, or refused with the line and the rule."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios.attitude import wrap
from sim_scenarios.errors import InputError
from sim_scenarios.recording import save
from sim_scenarios.units import DEGREE
from sim_scenarios.vehicles.trajectory import vehicle

Array = NDArray[np.float64]
Rows = dict[str, Array]


def rows() -> Rows:
    """Ten seconds to the east on the equator at 10 m/s, turning clockwise."""
    time = np.arange(11.0)
    nothing = np.zeros(11)
    return {
        "time": time,
        "latitude": nothing,
        "longitude": 10 * time / 6378137 / DEGREE,
        "height": nothing,
        "roll": nothing,
        "pitch": nothing,
        "heading": 350 + 3 * time,
        **{
            f"velocity_{axis}": nothing + value
            for axis, value in zip(("east", "north", "up"), (10, 0, 0), strict=True)
        },
        **{f"acceleration_{axis}": nothing for axis in ("east", "north", "up")},
        **{
            f"rate_{axis}": nothing + value
            for axis, value in zip(("right", "forward", "up"), (0, 0, -3), strict=True)
        },
    }


def written(table: Rows, path: Path, **habits: str) -> Path:
    pd.DataFrame(table).to_csv(path, index=False, float_format="%.17g", **habits)
    return path


@pytest.mark.parametrize("habits", [{}, {"sep": ";"}, {"sep": "\t"}])
@pytest.mark.parametrize("without", [(), ("velocity",), ("acceleration", "rate", "velocity")])
def test_a_file_of_what_it_has(habits: dict[str, str], without: tuple[str, ...], tmp_path: Path) -> None:
    table = {name: values for name, values in rows().items() if not name.startswith(without or "-")}
    [state] = vehicle(written(table, tmp_path / "file.csv", **habits), "").states(np.array([3.5]))
    np.testing.assert_allclose(state[:4], [3.5, 0, 35 / 6378137, 0], atol=1e-14)
    np.testing.assert_allclose(state[4:7], [10, 0, 0], atol=1e-7)
    np.testing.assert_allclose(wrap(state[7:10] - [0, 0, 0.5 * DEGREE]), 0, atol=1e-9)
    np.testing.assert_allclose(state[10:], [0, 0, 0, 0, 0, -3 * DEGREE], atol=1e-7)


def changed(name: str, row: int, value: float) -> Callable[[Rows], Rows]:
    def change(table: Rows) -> Rows:
        values = table[name].copy()
        values[row] = value
        return {**table, name: values}

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (changed("pitch", 3, np.nan), "line 5: pitch must be a finite number"),
        (changed("velocity_up", 0, np.nan), "line 2: velocity_up must be a finite number"),
        (changed("time", 4, 3.0), "line 6: time = 3 s: must be greater than in the row before"),
        (changed("latitude", 9, 90.0), "line 11: latitude = 90 deg: must be at most 89.95 either way"),
        (changed("longitude", 5, 0.001), "line 7: latitude, longitude, height lie .* m off where velocities"),
        (
            lambda t: {**t, "velocity_east": t["velocity_north"], "velocity_north": t["velocity_east"]},
            "line 3: .* lie 14.1 m off where velocities lead to .* at most 0.1 m and 1% of the way of 10 m",
        ),
        (
            lambda t: {**t, "rate_up": t["rate_up"] * DEGREE},
            "rate_right, rate_forward, rate_up leave 29.5 deg of the 30 deg unexplained",
        ),
        (lambda t: {**t, "rate_up": -t["rate_up"]}, "leave 60 deg of the 30 deg unexplained"),
        (lambda t: {n: v for n, v in t.items() if n != "heading"}, "there is no column heading"),
        (lambda t: {n: v for n, v in t.items() if n != "rate_up"}, "there is no column rate_up"),
        (lambda t: {n: v[:1] for n, v in t.items()}, "line 2: is the only row of the trajectory"),
    ],
)
def test_what_is_wrong_is_named(change: Callable[[Rows], Rows], says: str, tmp_path: Path) -> None:
    path = written(change(rows()), tmp_path / "file.csv")
    with pytest.raises(InputError, match=f"^{re.escape(str(path))}: .*{says}"):
        vehicle(path, "")


def test_another_content_is_another_vehicle(tmp_path: Path) -> None:
    path = written(rows(), tmp_path / "file.csv")
    first = vehicle(path, "1")
    written({name: values[:5] for name, values in rows().items()}, path)
    assert (vehicle(path, "1").end, vehicle(path, "2").end) == (first.end, 4.0)


def test_a_run_is_a_trajectory(ship: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "recording.nc"
    save(ship, path)
    states = vehicle(path, "").states(ship["time"].values[:-1:100])
    for name, column in (("latitude", 1), ("longitude", 2), ("velocity", slice(4, 7)), ("roll", 7)):
        expected = ship[f"truth.{name}"].values[:-1:100]
        np.testing.assert_allclose(states[:, column], expected, rtol=1e-14, atol=1e-9)


def test_what_has_no_attitude_is_none(tmp_path: Path) -> None:
    path = tmp_path / "solution.pos"
    path.write_text(
        "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m)\n"
        + "".join(f"2100 {1 + k}.000 30.0 110.0 5.0 1 9 0.1 0.1 0.1 0 0 0\n" for k in range(3))
    )
    with pytest.raises(InputError, match=r"solution\.pos: has no trajectory"):
        vehicle(path, "")
