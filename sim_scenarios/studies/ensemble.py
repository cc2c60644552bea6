"""Many runs of a scenario on the workers of a campaign, and the figures that they make together.

Of a run all is kept that figures and pictures are made of, at every recorded instant and fix: this is for
papers, which draw it. Campaigns keep figures, and what is expected of them.
"""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import provenance, recording, simulation
from sim_scenarios.cosimulation import Progress
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import Fmus, did_you_mean
from sim_scenarios.metrics import figures
from sim_scenarios.metrics.statistics import nees_of
from sim_scenarios.recordings.residuals import residuals as residuals_of
from sim_scenarios.scenario import load_scenario
from sim_scenarios.studies.measured import Measured
from sim_scenarios.timeline import Window

if TYPE_CHECKING:
    from sim_scenarios.studies.execution import Workers

Array = NDArray[np.float64]

ESTIMATED_NOISE: Final = "measurement_sigma_estimate"
"""Output of a filter that pictures show besides."""
OF_FIXES: Final = ("nis", "innovation_sigma", "fix_used", "rejected_fixes", ESTIMATED_NOISE)
"""Variables that are kept of the fixes of a run."""
OVER_TIME: Final = (
    *recording.ERRORS,
    *(f"{name}_sigma" for name in ("heading", "velocity", "position")),
    "status",
    "converged",
    "truth.velocity",
    *(f"{recording.ALIGNMENT}{name}" for name in ("heading_error", *recording.ALIGNMENT_OUTPUTS)),
)
"""Variables that are kept of its recorded instants, with the NEES in place of the covariance."""
TRUTH: Final = tuple(
    f"truth.{name}"
    for name in (
        *("roll", "pitch", "heading", "latitude", "longitude", "height", "velocity"),
        *("gyro_bias", "accelerometer_bias"),
    )
)
"""What figures of other packages may be made of besides."""


def outputs() -> tuple[str, ...]:
    """Outputs of a filter that are needed, at every recorded instant or fix, where it has them."""
    needs = (name for one in figures.known().values() for name in one.needs)
    return tuple(dict.fromkeys((*figures.OUTPUTS, ESTIMATED_NOISE, *needs)))


def variables() -> tuple[str, ...]:
    """Variables that are kept of a run, where it has them: more where other packages add figures."""
    kept = (*OVER_TIME, *OF_FIXES, recording.HAND_OVER)
    others = figures.own().values()
    if not others:
        return kept
    needs = (name for one in others for name in one.needs)
    return tuple(dict.fromkeys((*kept, *figures.OUTPUTS, *TRUTH, *needs)))


@dataclass(frozen=True)
class Ensemble(Measured):
    """Runs of a scenario.

    Attributes
    ----------
    filters : dict of str to list of xarray.Dataset
        Runs of each filter, by label (see `thinned`).
    """

    filters: dict[str, list[xr.Dataset]]

    @property
    def first(self) -> xr.Dataset:
        """The first run, of the first filter."""
        return next(iter(self.filters.values()))[0]

    @property
    def attributes(self) -> dict[str, Any]:
        """Those of the data set of `sim_scenarios.compare`, of the first run."""
        return {str(name): value for name, value in self.first.attrs.items()}

    @property
    def count(self) -> int:
        """How many runs there are."""
        return len(next(iter(self.filters.values())))

    @property
    def window(self) -> Window:
        """The evaluation window of the scenario [s]."""
        return figures.window(self.first)

    def runs(self, label: str) -> Sequence[xr.Dataset]:
        """Those of a filter."""
        return self.filters[label]

    def each(self, figure: figures.Figure, label: str, window: Window | None) -> Array:
        """A figure of each run of a filter, in SI units, shape (runs,)."""
        return figure.of_each(self.filters[label], window or self.window)


def ensemble(
    workers: Workers,
    scenario: str | Path,
    seeds: Sequence[int],
    labels: Sequence[str],
    settings: Mapping[str, object] | None = None,
    progress: Progress = lambda _: None,
    kept: Path | None = None,
    residuals: Path | None = None,
    versions: Mapping[str, str] | None = None,
) -> Ensemble:
    """Run filters that a scenario compares, with each seed.

    Parameters
    ----------
    workers : Workers
        Of `campaigns.execution.workers`.
    scenario : str or Path
        As for `sim_scenarios.run`.
    seeds : sequence of int
        One for each run.
    labels : sequence of str
        Filters to run.
    settings : mapping, optional
        As `set` of `sim_scenarios.run`.
    progress : callable
        Called with the completed share.
    kept : Path, optional
        Folder that keeps what is done: a run that is there is not done again. It holds the runs of one
        scenario with one choice of settings and filters; the workers must see it under the same path.
    residuals : Path, optional
        Recording whose residuals are added to the increments of the plant, in each run from another place on.
    versions : mapping of str to str, optional
        Of the FMUs that the workers must have.
    """
    do = partial(
        _runs,
        scenario=scenario,
        labels=labels,
        settings=dict(settings or {}),
        kept=kept and kept.resolve(),
        residuals=residuals and residuals.resolve(),
        versions=versions,
    )
    done: dict[int, xr.Dataset] = {}
    for batch, runs in workers.results(do, _batches(seeds, workers.count)):
        done |= zip(batch, runs, strict=True)
        progress(len(done) / len(seeds))
    return gathered([done[seed] for seed in seeds])


def gathered(runs: Sequence[xr.Dataset]) -> Ensemble:
    """Runs of a scenario together (data sets of `thinned`)."""
    labels = map(str, runs[0]["filter"].values)
    return Ensemble({label: [recording.of_filter(run, label) for run in runs] for label in labels})


def thinned(run: xr.Dataset) -> xr.Dataset:
    """A run of several filters with what figures and pictures are made of alone."""
    labels = run["filter"].values
    nees = np.stack([nees_of(recording.of_filter(run, str(label))) for label in labels])
    about = {"units": "1", "description": "Normalised estimation error squared for each state"}
    there = [name for name in variables() if name in run]
    thin: xr.Dataset = run[there].assign(nees=(("filter", "time"), nees, about))
    return thin


def run_file(kept: Path, seed: int) -> Path:
    """Where the run of a seed is kept."""
    return kept / f"run_{seed}.nc"


def _runs(
    seeds: Sequence[int],
    scenario: str | Path,
    labels: Sequence[str],
    settings: Mapping[str, object],
    kept: Path | None,
    residuals: Path | None,
    versions: Mapping[str, str] | None,
) -> list[xr.Dataset]:
    """Runs on a worker."""
    runs = []
    for seed in seeds:
        file = run_file(kept, seed) if kept else None
        if file and (done := _kept(file)) is not None:
            runs.append(done)
            continue
        run = thinned(_run(scenario, seed, labels, settings, residuals, versions))
        if file:
            unfinished = file.with_suffix(".part")
            recording.save(run, unfinished)
            unfinished.replace(file)
        runs.append(run)
    return runs


def _kept(file: Path) -> xr.Dataset | None:
    """A run that is kept; None of one that is not there, or damaged."""
    try:
        return recording.load(file) if file.is_file() else None
    except Exception:  # whatever the reader makes of it
        return None


class _OnWorker(threading.local):
    """What a thread of a worker keeps from one batch to the next."""

    @cached_property
    def fmus(self) -> Fmus:
        """Loaded once."""
        return Fmus()


_on_worker: Final = _OnWorker()


def _run(
    scenario: str | Path,
    seed: int,
    labels: Sequence[str],
    settings: Mapping[str, object],
    residuals: Path | None,
    versions: Mapping[str, str] | None,
) -> xr.Dataset:
    fmus = _on_worker.fmus
    loaded = load_scenario(scenario, fmus, seed=seed, settings=settings)
    found = {name: fmus[name].version for name in loaded.fmu_names()}
    if versions is not None and found != versions:
        from sim_scenarios.studies.execution import other_fmus  # slow: Dask

        raise other_fmus(found, versions)
    known = loaded.filters()
    for label in labels:
        if label not in known:
            hint = did_you_mean(label, list(known)) or f"; there are {', '.join(known)}"
            raise InputError(f"{scenario} compares no filter '{label}'{hint}")
    filters = {label: known[label] for label in labels}
    added = _residuals(residuals, loaded.communication_step, seed) if residuals else None
    data = simulation.thin(loaded, fmus, filters, outputs(), added)
    data.attrs = provenance.attributes(loaded, fmus)
    return data


def _residuals(path: Path, period: float, seed: int) -> dict[str, Array]:
    """Residuals of a recording from a place of its own for each seed on, and on from its beginning.

    There is one recording: runs share its pieces, and what they say together is surer than it looks.
    """
    rest = residuals_of(path, period, span=60.0)
    start = round(37.0 * seed / period)
    return {name: np.roll(values, -start) for name, values in rest.items()}


def _batches(seeds: Sequence[int], workers: int, most: int = 4) -> list[tuple[int, ...]]:
    """Seeds in groups, small enough to be shared out evenly."""
    size = max(1, min(most, len(seeds) // (4 * workers)))
    return [tuple(seeds[first : first + size]) for first in range(0, len(seeds), size)]
