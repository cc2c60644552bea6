"""Monte-Carlo campaigns: many seeds, filters and parameters, on one machine or on a cluster, resumable.

::

    if __name__ == "__main__":       # the workers are processes that import this file
        results = sim_scenarios.campaign("swaying_ship", "results", runs=100)
        print(results["heading_rmse"].sel(filter="UKF").values)

The results are an xarray Dataset (see `store`); `statistics.summarise` condenses it.

What is kept of a run is fixed (`quantities`) but for what is expected of it (`expectations`), so that
campaigns of any size resume and spread over machines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from sim_scenarios import compiled
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus
from sim_scenarios.folders import reserved
from sim_scenarios.stepping import Master
from sim_scenarios.studies import execution, packing, store
from sim_scenarios.studies.case import Case
from sim_scenarios.studies.cases import cases, expected_of, fingerprint
from sim_scenarios.studies.execution import Effort, Report, Workers
from sim_scenarios.studies.expectations import Row, rows
from sim_scenarios.studies.measured import Stored
from sim_scenarios.studies.plan import Plan, load_plan


@dataclass(frozen=True)
class Campaign:
    """A campaign that is checked and ready to run in a folder."""

    plan: Plan
    cases: Sequence[Case]
    folder: Path
    master: Master
    versions: Mapping[str, str]
    fmus: Fmus

    @classmethod
    def of(cls, plan: Plan, folder: Path, master: Master = Master.auto, fmus: Fmus | None = None) -> Campaign:
        """Campaign of a plan; everything that can be refused before the first run is."""
        fmus = fmus or Fmus()
        made = cases(plan, fmus)
        compiled.steps(master)  # refuses what was asked for and is not there
        return cls(plan, made, folder, master, execution.versions(fmus, plan, made), fmus)

    def run(
        self,
        *,
        workers: int | None = None,
        scheduler: str | None = None,
        insecure: bool = False,
        overwrite: bool = False,
        report: Report = lambda _: None,
        working: Workers | None = None,
    ) -> Effort:
        """Run all that is missing; workers are started, or asked, only if something is, unless some work.

        With `overwrite`, results of another campaign in the folder give way, as late as this one's can begin;
        its own results are kept and gone on with. The folder is this call's alone meanwhile.
        """
        with reserved(self.folder, "campaign"):
            identity = fingerprint(self.plan, self.cases, self.versions)
            there, damaged = self._found(identity, overwrite)
            if working is not None:
                effort = self._work(working, identity, there, report)
            else:
                work = partial(self._missing, workers, scheduler, insecure, identity, report)
                effort = work(there)
                while scheduler is None and (late := packing.pack(self.folder)):
                    damaged += late
                    effort = work(True)
            store.sweep(self.path)
            return replace(effort, damaged=tuple(damaged))

    def _missing(
        self,
        workers: int | None,
        scheduler: str | None,
        insecure: bool,
        identity: str,
        report: Report,
        there: bool,
    ) -> Effort:
        """Run what is missing, if something is, with workers that are started or asked for it."""
        if there and not any(store.unfinished(self.path)):
            return Effort(0, 0, 0.0, 0.0)
        try:
            with execution.workers(workers, scheduler, insecure) as working:
                return self._work(working, identity, there, report)
        finally:
            if scheduler is None:  # its workers have ended
                store.sweep(self.path)

    def _work(self, working: Workers, identity: str, there: bool, report: Report) -> Effort:
        if not there:
            bounds = execution.bounds(working, self.cases, self.fmus)
            store.clear(self.folder)
            store.create(self.folder, self.plan, self.cases, identity, bounds, self.fmus.plant)
        return execution.execute(
            working, self.path, self.plan, self.cases, self.master, dict(self.versions), report
        )

    def measured(self) -> list[Row]:
        """What is expected of it, beside what its runs have measured."""
        data = store.open_results(self.folder)
        return [
            row
            for expectations in self.plan.expect
            for case in expected_of(expectations, self.cases)
            for row in rows(expectations, Stored(data, case.label), case.label)
        ]

    def _found(self, identity: str, overwrite: bool) -> tuple[bool, list[str]]:
        """Whether results of this campaign are there to go on with, and their chunks that were damaged."""
        packing.recover(self.folder)
        try:
            there = store.is_there(self.folder, identity)
            return there, store.discard_damaged(self.path) if there else []
        except InputError:
            if overwrite:
                return False, []
            raise

    @property
    def path(self) -> Path:
        """Where the results are."""
        return self.folder / store.NAME


def campaign(
    name: str | Path,
    folder: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    insecure: bool = False,
    master: Master | str = Master.auto,
    overwrite: bool = False,
    report: Report = lambda _: None,
    fmus: Fmus | None = None,
    **given: Any,
) -> xr.Dataset:
    """Run a campaign, or what is missing of it, and open its results.

    Parameters
    ----------
    name : str or Path
        Campaign file, shipped campaign, or scenario.
    folder : str or Path
        Where the results are kept; seen under the same path by the workers.
    workers : int, optional
        Processes of this machine, by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler to use instead: tls://, with certificates in Dask's configuration.
    insecure : bool
        Whether a scheduler of another machine may do without TLS.
    master : Master or str
        Who steps plant and filters, as enumeration or its value; the results are the same.
    overwrite : bool
        Whether results of another campaign in the folder give way.
    report : callable
        Told of the progress after every batch.
    fmus : Fmus, optional
        Those that are loaded already.
    **given : object
        Entries in place of the file's: `runs`, `seed`, `filters`, `set`, `grid` ...

    Returns
    -------
    xarray.Dataset
        See `store`; its arrays are read from disk as they are needed.
    """
    made = Campaign.of(load_plan(name, **given), Path(folder), Master(master), fmus)
    made.run(workers=workers, scheduler=scheduler, insecure=insecure, overwrite=overwrite, report=report)
    return store.open_results(folder)
