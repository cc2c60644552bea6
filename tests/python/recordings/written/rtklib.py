"""Solution files, as RTKLIB's `outsolhead` and `outpos` write them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

ABOVE = "% program   : RTKLIB ver.2.4.3\n% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,ns=# of satellites)\n%\n"
HEADER = (
    "%  {scale}                  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)"
    "  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)      sdvn     sdve     sdvu"
    "    sdvne    sdveu    sdvun\n"
)


def row(
    stamp: str,
    q: int = 1,
    place: tuple[float, float, float] = (40.0966268, -7.8474483, 1601.474),
    velocity: tuple[float, float, float] = (-2.5, 1.25, 0.125),
) -> str:
    """Latitude, longitude [deg], height [m]; velocity east, north, up [m/s]."""
    latitude, longitude, height = place
    east, north, up = velocity
    return (
        f"{stamp} {latitude:14.9f} {longitude:14.9f} {height:10.4f} {q:3d}  21   0.0098   0.0097   0.0100"
        f"   0.0000   0.0000   0.0000   0.00    2.0 {north:10.5f} {east:10.5f} {up:10.5f}"
        "   0.05869  0.05868  0.05867  0.00000  0.00000  0.00000\n"
    )


def solution(scale: str = "GPST", *stamps: str) -> str:
    """A file of the same solution at some times."""
    rows = stamps or ("2025/01/01 19:34:18.499", "2025/01/01 19:34:18.749")
    return of_rows(map(row, rows), scale)


def of_rows(rows: Iterable[str], scale: str = "GPST") -> str:
    """A file of solutions."""
    return ABOVE + HEADER.format(scale=scale) + "".join(rows)


def written(folder: Path, text: str) -> Path:
    """A file of a text."""
    path = folder / "x.pos"
    path.write_text(text)
    return path
