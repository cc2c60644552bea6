"""Tables put together from parts."""

from __future__ import annotations

import numpy as np

from sim_scenarios.recordings.readers.epochs import BodyVelocities, Fixes, Headings, References


def test_parts_of_one_time_are_one_row_in_the_order_of_time() -> None:
    fixes = Fixes()
    fixes.velocity(2.0, 1.0, 2.0)
    fixes.position(1.0, 0.1, 0.2, 3.0)
    fixes.position(2.0, 0.4, 0.5, 6.0)
    fixes.velocity_sigma(2.0, 7.0, 8.0, 9.0)
    table = fixes.table()
    assert table is not None
    np.testing.assert_array_equal(table.time, [1, 2])
    np.testing.assert_array_equal(table.position, [[0.1, 0.2, 3.0], [0.4, 0.5, 6.0]])
    np.testing.assert_array_equal(table.velocity, [[np.nan] * 3, [1, 2, np.nan]])
    np.testing.assert_array_equal(table.position_sigma, np.zeros((2, 3)))
    np.testing.assert_array_equal(table.velocity_sigma, [[0, 0, 0], [7, 8, 9]])


def test_what_is_said_twice_is_as_said_last() -> None:
    headings = Headings()
    headings.heading(1.0, 0.5, 0.1)
    headings.heading(1.0, 0.6)
    table = headings.table()
    assert table is not None
    np.testing.assert_array_equal(table.heading, [0.6])
    np.testing.assert_array_equal(table.sigma, [0.0])


def test_rows_that_measure_nothing_are_none() -> None:
    fixes, body = Fixes(), BodyVelocities()
    fixes.position_sigma(1.0, 1.0, 1.0, 1.0)
    body.sigma(1.0, 1.0, 1.0, 1.0)
    assert fixes.table() is None
    assert body.table() is None
    assert Headings().table() is None
    assert References().table() is None
