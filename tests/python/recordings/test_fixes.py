"""What is made of fixes before a filter gets them."""

from __future__ import annotations

import numpy as np

from sim_scenarios.recordings import fixes
from sim_scenarios.recordings.tables import FixTable


def test_no_fix_is_surer_than_it_is_told_to_be() -> None:
    nothing = np.zeros((2, 3))
    told = np.array([[0.01, 0.02, 0.03], [0.5, 0.0, 0.9]])
    gnss = FixTable(np.arange(2.0), nothing, nothing, told, 0.1 * told)
    raised = fixes.no_surer_than(gnss, position=0.05, velocity=0.02)
    np.testing.assert_array_equal(raised.position_sigma, [[0.05, 0.05, 0.03], [0.5, 0.0, 0.9]])
    np.testing.assert_allclose(raised.velocity_sigma, [[0.02, 0.02, 0.02], [0.05, 0.0, 0.09]])
    assert fixes.no_surer_than(gnss).position_sigma.tolist() == told.tolist()
