"""What a campaign keeps of a run, against errors that are known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from made_up import run_with

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.studies.quantities import Asked, figures, kept


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


def test_the_nis_of_a_row_is_that_of_the_fixes_since_the_row_before() -> None:
    """Of those that were used, the first at a row's own time; what comes after the last row is in none."""
    sigma = [[1, 1, 1], [1, 1, 0], [1, 0, 0], [1, 1, 1], [1, 0, 0], [1, 1, 1]]
    run = run_with(np.arange(0.0, 5.0, 0.5)).assign(
        nis=("fix", [7.0, 1.5, 3.0, 9.0, 5.0, 8.0]),
        innovation_sigma=(("fix", "axis3"), np.array(sigma, dtype=float)),
        fix_used=("fix", [True, True, True, False, True, True]),
    )
    series = kept(run.assign_coords(fix_time=("fix", [0.0, 0.5, 1.0, 1.5, 2.2, 4.5])), 1.0)
    assert series["nis"] == pytest.approx([7.0, 4.5, 0.0, 5.0, 0.0])
    assert series["nis_channels"] == pytest.approx([3.0, 3.0, 0.0, 1.0, 0.0])


def test_errors_at_every_instant_are_kept_where_they_are_asked_for() -> None:
    run = run_with([0.0, 0.5, 1.0, 1.5, 2.0], heading=[0.1, 0.2, 0.3, 0.4, 0.5])
    assert not [name for name in kept(run, 1.0) if name.startswith("recorded.")]
    found = kept(run, 1.0, Asked(errors=True))
    assert found["recorded.heading_error"] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert found["recorded.position_error"].shape == (5, 3)
    assert found["heading_error"] == pytest.approx([0.1, 0.3, 0.5])
