"""What chooses the order and the master: the enumeration, or its value, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sim_scenarios
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.stepping import Master, Order
from sim_scenarios.studies.campaign import Campaign

SHORT = {"duration": 20.0, "evaluation.start": 10.0}


def test_the_order_may_be_given_by_its_value(fmus: Fmus) -> None:
    """A Jacobi master gives a filter the signals of the step before: its rows are a step behind."""
    by_value, by_item, other = (
        sim_scenarios.run("swaying_ship", set=SHORT, order=order, fmus=fmus)
        for order in ("jacobi", Order.jacobi, "gauss-seidel")
    )
    assert by_value["time"].values[1] == pytest.approx(0.09)
    assert other["time"].values[1] == pytest.approx(0.1)
    np.testing.assert_array_equal(by_value["heading_error"], by_item["heading_error"])


def test_what_is_no_choice_is_refused(tmp_path: Path, fmus: Fmus) -> None:
    with pytest.raises(InputError, match=r"^order = 'nonsense': must be one of gauss-seidel, jacobi$"):
        sim_scenarios.run("swaying_ship", order="nonsense", fmus=fmus)
    with pytest.raises(InputError, match=r"^master = 'pyhton': must be one of auto, compiled, python$"):
        sim_scenarios.campaign("swaying_ship", tmp_path, master="pyhton", fmus=fmus)
    with pytest.raises(InputError, match=r"^master = 'container': there is no container .*: compiled$"):
        sim_scenarios.campaign("swaying_ship", tmp_path, master="container", fmus=fmus)


def test_the_master_may_be_given_by_its_value(
    tmp_path: Path, fmus: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Asked(Exception):  # noqa: N818  (of no error)
        pass

    def asked(_plan: object, _folder: object, master: Master, _fmus: object) -> Campaign:
        raise Asked(master)

    monkeypatch.setattr(Campaign, "of", asked)
    with pytest.raises(Asked) as given:
        sim_scenarios.campaign("swaying_ship", tmp_path, master="python", fmus=fmus)
    assert given.value.args[0] is Master.python


def test_the_package_offers_its_report(tmp_path: Path, fmus: Fmus) -> None:
    run = sim_scenarios.run("swaying_ship", set=SHORT, fmus=fmus)
    assert sim_scenarios.report.report_run(run, tmp_path).read_text().startswith("<!")
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        sim_scenarios.nothing  # noqa: B018
