"""What a campaign keeps of a run, against errors that are known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.studies.quantities import figures, kept


@pytest.mark.parametrize("name", ["heading_error", "state", "horizontal_bound_rms"])
def test_a_figure_that_has_the_name_of_another_variable_is_refused(
    register: Callable[[dict[str, str]], None], name: str
) -> None:
    register({name: "own_figures:heading_peak"})
    with pytest.raises(InputError, match=f"figure {name} .*: a campaign has another variable of that name"):
        figures()


def test_every_error_is_that_of_its_components(fmus: Fmus) -> None:
    run = sim_scenarios.run("swaying_ship", set={"duration": 20.0, "evaluation.start": 10.0}, fmus=fmus)
    constant = {"attitude": (3e-3, 4e-3, 9e-3), "position": (3.0, 4.0, 7.0), "velocity": (0.2, 0.3, 0.6)}
    rows = run.sizes["time"]
    made = run.assign(
        {f"{name}_error": (("time", "axis3"), np.tile(error, (rows, 1))) for name, error in constant.items()}
    ).assign(heading_error=("time", np.full(rows, -0.01)))
    for name, sigma in {"velocity": (0.1, 0.2, 0.2), "position": (2.0, 3.0, 6.0)}.items():
        made[f"{name}_sigma"] = ("time", "axis3"), np.tile(sigma, (rows, 1))
    figures = kept(made, 1.0)
    expected = {"heading": 0.01, "tilt": 5e-3, "velocity": 0.7, "horizontal": 5.0, "vertical": 7.0}
    assert {name: float(figures[f"{name}_rmse"]) for name in expected} == pytest.approx(expected)
    assert figures["heading_error"] == pytest.approx(np.full(21, -0.01))
    assert figures["vertical_error"] == pytest.approx(np.full(21, 7.0))
    assert figures["velocity_sigma"] == pytest.approx(np.full(21, 0.3))
    assert figures["position_sigma"] == pytest.approx(np.full(21, 7.0))
    assert figures["velocity_deviation"] == pytest.approx(np.full(21, 3.0))  # up: 0.6 of 0.2
