"""Many runs of a scenario in a pool of processes, and the figures that they make together.

A run gives the errors of each filter at every recorded instant. A figure is a statistic of some of them over
a window and over all runs; of a single run it is the same statistic of that run alone.

This is for bands and papers, whose figures take any window and component, and NEES of the whole covariance.
Campaigns (`sim_scenarios.campaigns`) keep less of each run, on disk, and know intervals, bounds, resuming and
clusters.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from sim_scenarios import recording, simulation
from sim_scenarios.attitude import wrap
from sim_scenarios.campaigns import quantities
from sim_scenarios.cosimulation import Progress
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import did_you_mean
from sim_scenarios.metrics.statistics import holds_since, is_measured, nees_of
from sim_scenarios.recordings.residuals import residuals as residuals_of
from sim_scenarios.runner import Runner
from sim_scenarios.scenario import load_scenario
from sim_scenarios.timeline import RESOLUTION, Window, inside, within
from sim_scenarios.units import ARCMIN

Array = NDArray[np.float64]

HEADING, TILT_EAST, TILT_NORTH, NIS, NEES = 0, 1, 2, 9, 10
TILT, VELOCITY, HORIZONTAL_VELOCITY, POSITION, HORIZONTAL = (
    slice(first, end) for first, end in ((1, 3), (3, 6), (3, 5), (6, 9), (6, 8))
)
VERTICAL = 8
NOISE = slice(11, 17)
COLUMNS = 17
"""Columns of errors: heading and tilts [rad], velocity [m/s], position [m], NIS for each channel, NEES for
each state, sigma of position [m] and velocity [m/s] fixes as the filter has estimated it."""

OUTPUTS: Final = (
    *quantities.OUTPUTS,
    *("covariance", "gyro_bias", "accelerometer_bias", "clock_bias_sigma"),  # for the NEES
)
FIX_OUTPUTS: Final = (*quantities.FIX_OUTPUTS, "measurement_sigma_estimate")
"""Outputs of a filter that errors are made of, at every recorded instant and at every fix."""


@dataclass(frozen=True)
class Errors:
    """Errors of one filter.

    Attributes
    ----------
    time : ndarray, shape (times,)
        [s]
    values : ndarray, shape (runs, times, k)
        Estimated minus true, in SI units; NIS and estimated sigmas are those of the fix at the time, NaN
        where there was none; the NEES is NaN for a filter that does not put out its covariance, the sigmas
        for one that does not estimate them.
    limit : float
        Heading error within which a filter counts as settled [rad].
    """

    time: Array
    values: Array
    limit: float

    def part(self, columns: int | slice, window: Window) -> Errors:
        """Some columns over a window, ends included."""
        chosen = slice(columns, columns + 1) if isinstance(columns, int) else columns
        time = within(self.time, self.time, *window)
        return replace(self, time=time, values=self.values[:, inside(self.time, *window), chosen])

    def runs(self) -> Iterator[Errors]:
        """Each run alone."""
        for run in range(len(self.values)):
            yield replace(self, values=self.values[run : run + 1])


def rmse(errors: Errors) -> float:
    """Root mean square over runs and time."""
    return float(np.sqrt(np.mean(np.sum(errors.values**2, axis=2))))


def mean_rmse(errors: Errors) -> float:
    """Mean over runs of the root mean square over time."""
    return float(np.mean(np.sqrt(np.mean(np.sum(errors.values**2, axis=2), axis=1))))


def mean(errors: Errors) -> float:
    """Mean over runs and time of what there is."""
    return float(np.nanmean(errors.values))


def largest(errors: Errors) -> float:
    """Mean over runs of the largest size of a component."""
    return float(np.mean(np.max(np.abs(errors.values), axis=(1, 2))))


def at_end(errors: Errors) -> float:
    """Mean over runs of the size at the end of the window."""
    return float(np.mean(np.linalg.norm(errors.values[:, -1], axis=1)))


def settling(errors: Errors) -> float:
    """Time from which the root mean square over runs stays within the limit; infinite if it never does."""
    since = holds_since(errors.time, rms_over_runs(errors) <= errors.limit)
    return float("inf") if since is None else since


def median_settling(errors: Errors) -> float:
    """Median over runs of the time from which each stays within the limit."""
    return float(np.median([settling(run) for run in errors.runs()]))


def failures(errors: Errors) -> float:
    """How many runs have a root mean square over time of more than twice the limit."""
    return float(sum(rmse(run) > 2 * errors.limit for run in errors.runs()))


def rms_over_runs(errors: Errors) -> Array:
    """Root mean square over runs at each time, shape (times,)."""
    over_time: Array = np.sqrt(np.mean(np.sum(errors.values**2, axis=2), axis=0))
    return over_time


@dataclass(frozen=True)
class Figure:
    """What is measured of runs, and in which unit it is shown.

    Attributes
    ----------
    title, unit : str
    size : float
        Of the unit, in SI.
    columns : int or slice
        Of the errors.
    statistic : callable
    whole : bool
        Of the whole run instead of a window.
    """

    title: str
    unit: str
    size: float
    columns: int | slice
    statistic: Callable[[Errors], float]
    whole: bool = False

    def of(self, errors: Errors, window: Window) -> float:
        """The figure over all runs, in its unit."""
        return self.statistic(self.part(errors, window)) / self.size

    def of_each(self, errors: Errors, window: Window) -> list[float]:
        """The figure of each run, in its unit."""
        return [self.statistic(run) / self.size for run in self.part(errors, window).runs()]

    def part(self, errors: Errors, window: Window) -> Errors:
        """The errors that the figure is made of."""
        everything = float(errors.time[0]), float(errors.time[-1])
        return errors.part(self.columns, everything if self.whole else window)


FIGURES: Final[Mapping[str, Figure]] = {
    "heading": Figure("heading RMSE", "'", ARCMIN, HEADING, rmse),
    "tilt_east": Figure("tilt RMSE about east", "'", ARCMIN, TILT_EAST, rmse),
    "tilt_north": Figure("tilt RMSE about north", "'", ARCMIN, TILT_NORTH, rmse),
    "settling": Figure("heading settled", "s", 1.0, HEADING, settling, whole=True),
    "median_settling": Figure("median time to settle", "s", 1.0, HEADING, median_settling, whole=True),
    "failures": Figure("failed runs", "", 1.0, HEADING, failures),
    "horizontal": Figure("horizontal", "m", 1.0, HORIZONTAL, mean_rmse),
    "vertical": Figure("vertical", "m", 1.0, VERTICAL, mean_rmse),
    "velocity": Figure("velocity", "m/s", 1.0, VELOCITY, mean_rmse),
    "velocity_east": Figure("velocity east", "m/s", 1.0, VELOCITY.start, mean_rmse),
    "tilt": Figure("tilt", "'", ARCMIN, TILT, mean_rmse),
    "yaw": Figure("yaw", "'", ARCMIN, HEADING, mean_rmse),
    "largest_velocity": Figure("largest velocity error", "m/s", 1.0, HORIZONTAL_VELOCITY, largest),
    "horizontal_at_end": Figure("horizontal at the end", "m", 1.0, HORIZONTAL, at_end),
    "nis": Figure("NIS / channels", "", 1.0, NIS, mean),
    "nees_at_end": Figure("NEES / states at the end", "", 1.0, NEES, at_end),
}
"""Figures by name. RMSE of an alignment is over all runs; that of navigation is the mean of the runs' own."""


@dataclass(frozen=True)
class Ensemble:
    """Runs of a scenario.

    Attributes
    ----------
    filters : dict of str to Errors
        By label.
    attributes : dict
        Those of the data set of `sim_scenarios.compare`, of the first run.
    velocity : ndarray, shape (times, 3)
        The true one of the first run, east, north, up [m/s].
    """

    filters: dict[str, Errors]
    attributes: dict[str, Any]
    velocity: Array = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def count(self) -> int:
        """How many runs there are."""
        return len(next(iter(self.filters.values())).values)

    @property
    def window(self) -> Window:
        """The evaluation window of the scenario [s]."""
        return float(self.attributes["evaluation.start"]), float(self.attributes["evaluation.stop"])

    def largest_difference(self, one: str, other: str) -> float:
        """Largest difference of any error of two filters at any time, in SI units."""
        differences = self.filters[one].values[:, :, :NIS] - self.filters[other].values[:, :, :NIS]
        return float(np.max(np.abs(differences)))

    def figure(self, name: str, label: str, window: Window | None = None, over: str | None = None) -> float:
        """A figure of a filter over all runs; over that of another filter, if one is named."""
        value = FIGURES[name].of(self.filters[label], window or self.window)
        return value / FIGURES[name].of(self.filters[over], window or self.window) if over else value


def ensemble(
    pool: ProcessPoolExecutor,
    scenario: str | Path,
    seeds: Sequence[int],
    labels: Sequence[str],
    settings: Mapping[str, object] | None = None,
    progress: Progress = lambda _: None,
    kept: Path | None = None,
    residuals: Path | None = None,
) -> Ensemble:
    """Run filters that a scenario compares, with each seed.

    Parameters
    ----------
    pool : ProcessPoolExecutor
        Of `processes.processes`.
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
        scenario with one choice of settings and filters.
    residuals : Path, optional
        Recording whose residuals are added to the increments of the plant, in each run from another place on.
    """
    batches = _batches(seeds)
    futures: list[Future[list[xr.Dataset]]] = [
        pool.submit(_runs, scenario, batch, labels, dict(settings or {}), kept, residuals)
        for batch in batches
    ]
    done = 0
    for future in as_completed(futures):
        done += len(future.result())
        progress(done / len(seeds))
    runs = [run for future in futures for run in future.result()]
    return gathered(runs)


def gathered(runs: Sequence[xr.Dataset]) -> Ensemble:
    """Runs of a scenario together (data sets of `errors_of_run`)."""
    first = runs[0]
    limit = float(first.attrs["evaluation.heading_limit"])
    values = {
        str(label): np.stack([run["errors"].sel(filter=label).values for run in runs])
        for label in first["filter"].values
    }
    filters = {label: Errors(first["time"].values, errors, limit) for label, errors in values.items()}
    return Ensemble(filters, dict(first.attrs), first["velocity"].values)


def errors_of_run(run: xr.Dataset) -> xr.Dataset:
    """What an ensemble keeps of a run: the errors of each filter (filter, time, column)."""
    labels = run["filter"].values
    columns = [_columns(recording.of_filter(run, str(label))) for label in labels]
    return xr.Dataset(
        {
            "errors": (("filter", "time", "column"), np.stack(columns)),
            "velocity": (("time", "axis"), run["truth.velocity"].values),
        },
        coords={"filter": labels, "time": run["time"].values},
        attrs=run.attrs,
    )


def _columns(run: xr.Dataset) -> Array:
    errors = np.full((run.sizes["time"], COLUMNS), np.nan)
    errors[:, HEADING] = wrap(run["heading_error"].values)
    errors[:, TILT] = wrap(run["attitude_error"].values[:, :2])
    errors[:, VELOCITY] = run["velocity_error"].values
    errors[:, POSITION] = run["position_error"].values
    used = run["fix_used"].values
    row = np.searchsorted(run["time"].values, run["fix_time"].values[used] - RESOLUTION)
    recorded = row < len(errors)
    channels = is_measured(run)[used].sum(axis=1)  # none of a fix that a coarse stage used
    nis = np.where(channels > 0, run["nis"].values[used] / np.maximum(channels, 1), np.nan)
    errors[row[recorded], NIS] = nis[recorded]
    if "measurement_sigma_estimate" in run:
        estimate = run["measurement_sigma_estimate"]
        units = np.array(estimate.attrs["units"].split())
        first = [i for unit in ("m", "m/s") for i in np.flatnonzero(units == unit)[:3]]
        errors[row[recorded], NOISE] = estimate.values[used][recorded][:, first]
    if "covariance" in run:
        errors[:, NEES] = nees_of(run)
    return errors


def run_file(kept: Path, seed: int) -> Path:
    """Where the run of a seed is kept."""
    return kept / f"run_{seed}.nc"


def _runs(
    scenario: str | Path,
    seeds: Sequence[int],
    labels: Sequence[str],
    settings: Mapping[str, object],
    kept: Path | None,
    residuals: Path | None,
) -> list[xr.Dataset]:
    """Runs in a process of the pool."""
    runs = []
    for seed in seeds:
        file = run_file(kept, seed) if kept else None
        if file and (done := _kept(file)) is not None:
            runs.append(done)
            continue
        run = errors_of_run(_run(scenario, seed, labels, settings, residuals))
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
    def runner(self) -> Runner:
        """With FMUs that are loaded once."""
        return Runner(OUTPUTS, FIX_OUTPUTS)


_on_worker: Final = _OnWorker()


def _run(
    scenario: str | Path,
    seed: int,
    labels: Sequence[str],
    settings: Mapping[str, object],
    residuals: Path | None,
) -> xr.Dataset:
    runner = _on_worker.runner
    loaded = load_scenario(scenario, runner.fmus, seed=seed, settings=settings)
    known = loaded.filters()
    for label in labels:
        if label not in known:
            hint = did_you_mean(label, list(known)) or f"; there are {', '.join(known)}"
            raise InputError(f"{scenario} compares no filter '{label}'{hint}")
    filters = {label: known[label] for label in labels}
    if residuals:
        added = _residuals(residuals, loaded.communication_step, seed)
        recorded, _ = simulation.simulated(loaded, runner.fmus, filters, added=added)
        data = simulation.dataset(recorded, loaded, runner.fmus, list(labels))
    else:
        data = runner.simulated(loaded, filters, runner.uses_container(loaded))
    data.attrs = simulation.attributes(loaded, runner.fmus)
    return data


def _residuals(path: Path, period: float, seed: int) -> dict[str, Array]:
    """Residuals of a recording from a place of its own for each seed on, and on from its beginning.

    There is one recording: runs share its pieces, and what they say together is surer than it looks.
    """
    rest = residuals_of(path, period, span=60.0)
    start = round(37.0 * seed / period)
    return {name: np.roll(values, -start) for name, values in rest.items()}


def _batches(seeds: Sequence[int], most: int = 4) -> list[Sequence[int]]:
    """Seeds in groups, small enough to be shared out evenly."""
    size = max(1, min(most, len(seeds) // (4 * (os.cpu_count() or 1))))
    return [seeds[first : first + size] for first in range(0, len(seeds), size)]
