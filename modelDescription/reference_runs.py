"""Draw a run of each FMU for its documentation page: `python modelDescription/reference_runs.py`.

Writes `documentation/<Name>.run.html`; they are committed because a build must not need a simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from numpy.typing import NDArray

import sim_scenarios
from sim_scenarios.exchange.recorded import playback
from sim_scenarios.fmus import PLAYBACK, Fmus
from sim_scenarios.recordings.feed import Feed

Array = NDArray[np.float64]
HERE = Path(__file__).parent
WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 720, 300, 60, 40, 30
COLOURS = ("#1f6fb2", "#c8372d", "#2e8b57")
POINTS = 300


@dataclass(frozen=True)
class Chart:
    """Curves over the time [s]; `bounds` are drawn dashed, on both sides of zero."""

    title: str
    unit: str
    time: Array
    curves: dict[str, Array]
    bounds: dict[str, Array]
    limit: float
    """Largest magnitude that is shown."""

    def figure(self) -> str:
        """As an HTML element."""
        signs = {f"{name} {sign}": value for name, value in self.bounds.items() for sign in ("+", "-")}
        ticks = [self.limit * part for part in (-1, -0.5, 0, 0.5, 1)]
        lines = [
            *(f'<path d="M{LEFT} {self._y(v):.1f}H{WIDTH}" stroke="#8884"/>' for v in ticks),
            *(self._text(LEFT - 6, self._y(v) + 4, f"{v:g}", "end") for v in ticks),
            *(
                self._text(self._x(t), HEIGHT - BOTTOM + 18, f"{t:g}", "middle")
                for t in np.linspace(self.time[0], self.time[-1], 7)
            ),
            self._text(WIDTH, HEIGHT - 4, "time [s]", "end"),
            *(
                self._line(value * (1 if name[-1] == "+" else -1), COLOURS[1], True)
                for name, value in signs.items()
            ),
            *(
                self._line(value, colour, False)
                for value, colour in zip(self.curves.values(), COLOURS, strict=False)
            ),
            *self._legend(),
        ]
        size = f'viewBox="0 0 {WIDTH + 20} {HEIGHT}" font-size="12" fill="none"'
        begin = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{self.title}">'
        end = f"</svg>\n<figcaption>{self.title}. Values beyond the scale are drawn at its edge.</figcaption>"
        return "\n".join(["<figure>", begin, *lines, end, "</figure>", ""])

    def _legend(self) -> Sequence[str]:
        names = [*zip(self.curves, COLOURS, strict=False), *((name, COLOURS[1]) for name in self.bounds)]
        return [
            f'<text x="{LEFT + 190 * i}" y="16" fill="{colour}">{name} [{self.unit}]</text>'
            for i, (name, colour) in enumerate(names)
        ]

    def _x(self, time: float) -> float:
        return LEFT + (WIDTH - LEFT) * float((time - self.time[0]) / (self.time[-1] - self.time[0]))

    def _y(self, value: float) -> float:
        middle = (TOP + HEIGHT - BOTTOM) / 2
        return middle - (HEIGHT - BOTTOM - TOP) / 2 * float(np.clip(value / self.limit, -1, 1))

    def _line(self, values: Array, colour: str, dashed: bool) -> str:
        every = max(1, len(self.time) // POINTS)
        points = " ".join(
            f"{self._x(t):.1f},{self._y(v):.1f}"
            for t, v in zip(self.time[::every], values[::every], strict=True)
        )
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        return f'<polyline points="{points}" stroke="{colour}"{dash}/>'

    @staticmethod
    def _text(x: float, y: float, text: str, anchor: str) -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="currentColor">{text}</text>'


def played(seconds: float, step: float) -> dict[str, Array]:
    """Outputs of Playback, by name and at each step, of what the plant puts out as it is built."""
    fmus = Fmus()
    signals = ["imu.sample", "imu.time", *(n for n in fmus.plant.outputs() if n.startswith("imu.delta_"))]
    span = {"start_time": 0.0, "stop_time": seconds, "output_interval": step}
    recorded = fmpy.simulate_fmu(str(fmus.plant.path), output=signals, **span)
    fed = Feed(recorded["imu.time"], {name: recorded[name] for name in signals})
    with TemporaryDirectory() as folder:
        fmu = playback(fmus[PLAYBACK], Path(folder), fed, None)
        result = fmpy.simulate_fmu(str(fmu.path), output=signals, **span)
    return {name: result[name] for name in result.dtype.names}


def charts() -> dict[str, Chart]:
    """By the name of the FMU."""
    tape = played(60.0, 0.01)
    ship = sim_scenarios.run("swaying_ship")
    flight = sim_scenarios.run("flight_loose_tight")
    time = ship["time"].to_numpy()
    minute = time <= 60.0
    attitude = {name: np.degrees(ship[f"truth.{name}"].to_numpy()[minute]) for name in ("roll", "pitch")}
    arcmin = np.degrees(1.0) * 60.0
    return {
        "TruthPlant": Chart(
            "The first minute of the scenario swaying_ship: truth.roll and truth.pitch",
            "deg", time[minute], attitude, {}, 10.0,
        ),
        "Playback": Chart(
            "The first minute of a recording of a swaying ship: imu.delta_velocity, right and forward",
            "m/s", tape["time"],
            {name: tape[f"imu.delta_velocity[{i}]"] for i, name in ((1, "right"), (2, "forward"))},
            {}, 0.02,
        ),
        "AlignmentFilter": Chart(
            "Scenario swaying_ship, seed 1: error of nav.heading and 3 heading_sigma",
            "arcmin", time,
            {"heading error": arcmin * ship["heading_error"].to_numpy()},
            {"three sigma": 3 * arcmin * ship["heading_sigma"].to_numpy()}, 100.0,
        ),
        "NavigationFilter": Chart(
            "Scenario flight_loose_tight, seed 1, loose model: position error and 3 position_sigma[1]",
            "m", flight["time"].to_numpy(),
            {name: flight["position_error"].to_numpy()[:, i] for i, name in enumerate(("east", "north"))},
            {"three sigma, east": 3 * flight["position_sigma"].to_numpy()[:, 0]}, 10.0,
        ),
    }  # fmt: skip


if __name__ == "__main__":
    for component, chart in charts().items():
        (HERE / "documentation" / f"{component}.run.html").write_text(chart.figure(), encoding="utf-8")
