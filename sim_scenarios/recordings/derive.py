"""Noise parameters of a filter from a recording, each with its evidence, as a file that `--set-from` takes.

A stretch at rest tells the noises of the sensors (`at_rest`), a drive those of fixes and sensors as a filter
meets them (`from_drive`). Where both tell a parameter, the drive counts: on the road sensors are shaken. What
neither shows is not told.

Of the slow errors of a sensor the NavigationFilter knows a random walk of the bias alone. Others become the
walk that grows as fast as they do where they emerge from the white noise N:

    Gauss-Markov s, T        K = s sqrt(2 / T)
    bias instability B       K = sqrt(3) b^2 / N,  b = 0.664 B: the walk has its Allan deviation where that of
                             the white noise has fallen to it
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from sim_scenarios.cosimulation import Progress
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, Fmu, Fmus
from sim_scenarios.recordings.allan import CONFIDENCE, FLICKER_FLOOR
from sim_scenarios.recordings.at_rest import SENSORS, AtRest, SensorAtRest, at_rest
from sim_scenarios.recordings.from_drive import FromDrive, ShortDriveError, from_drive, moves
from sim_scenarios.recordings.noise_fit import Estimate, NoiseFit
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.stretches import between, longest_standing
from sim_scenarios.recordings.tables import Recording
from sim_scenarios.toml import comment
from sim_scenarios.units import DEGREE, HOUR

Array = NDArray[np.float64]

FILTERS: Final = (NAVIGATION_FILTER, ALIGNMENT_FILTER)
EARTH_RATE: Final = 15.041 * DEGREE / HOUR
"""[rad/s]"""
WHITE: Final = {"gyro": "process.angle_random_walk", "accelerometer": "process.velocity_random_walk"}
"""Parameter of the white noise of each sensor."""
UNITS: Final = {
    "gyro": {
        "quantisation": "rad",
        "white_noise": "rad/s^0.5",
        "bias_instability": "rad/s",
        "random_walk": "rad/s^1.5",
        "markov_sigma": "rad/s",
        "markov_time": "s",
    },
    "accelerometer": {
        "quantisation": "m/s",
        "white_noise": "m/s^1.5",
        "bias_instability": "m/s2",
        "random_walk": "m/s^2.5",
        "markov_sigma": "m/s2",
        "markov_time": "s",
    },
}
NOT_QUITE: Final = "these noises do not explain the scatter of all axes; the vehicle was not quite at rest"
AXES: Final = ("right", "forward", "up")


@dataclass(frozen=True)
class Finding:
    """A parameter, and what it rests on.

    Attributes
    ----------
    name : str
        Parameter of a filter.
    value : float or None
        In the FMU's unit; None: not told.
    evidence : tuple of str
        Lines for a reader.
    """

    name: str
    value: float | None
    evidence: tuple[str, ...]


@dataclass(frozen=True)
class Derivation:
    """All that a recording tells.

    Attributes
    ----------
    recording : str
        Its name.
    fmu : Fmu
        Filter whose parameters they are.
    findings : tuple of Finding
    rest : AtRest or None
    drive : FromDrive or None
    unused : str or None
        Why a drive tells nothing.
    """

    recording: str
    fmu: Fmu
    findings: tuple[Finding, ...]
    rest: AtRest | None
    drive: FromDrive | None
    unused: str | None = None

    def toml(self) -> str:
        """File of the parameters, the evidence before each."""
        lines = [f"# Noise of {self.recording!a}, for {self.fmu.name}; [a, b]: 95 % interval.", ""]
        if self.drive is not None:
            lines[1:1] = [
                "# Of fixes that tell their sigmas, `replay` takes the larger of those and measurement.*.",
            ]
        if self.unused is not None:
            lines[1:1] = [comment(f"{self.unused}: the stretch at rest alone is told.")]
        for finding in self.findings:
            lines += map(comment, finding.evidence)
            if finding.value is None:
                lines.append(f"# {finding.name}: not told")
            else:
                shown = self.fmu.variables[finding.name].display(finding.value)
                lines.append(f'{finding.name} = "{shown}"')
            lines.append("")
        return "\n".join(lines)


def derive(
    recording: Recording,
    begin: float | None = None,
    end: float | None = None,
    *,
    filter_fmu: str = NAVIGATION_FILTER,
    start: Start | None = None,
    progress: Progress = lambda _: None,
    fmus: Fmus | None = None,
) -> Derivation:
    """Noise parameters that a recording tells.

    Parameters
    ----------
    recording : Recording
        With an IMU, and fixes of a drive.
    begin, end : float, optional
        Where the vehicle stands [s]; without either, its longest standing stretch is found.
    filter_fmu : str
        Filter whose parameters are told.
    start : Start, optional
        Of the filter on the drive; by default the course of the first fix that is fast enough.
    progress : callable
        Called with the completed share.
    fmus : Fmus, optional
        Those that are loaded already.

    Raises
    ------
    InputError
        When the vehicle neither stands nor drives, or drives for too short a time and does not stand.
    """
    fmus = fmus or Fmus()
    if filter_fmu not in FILTERS:
        raise InputError(f"filter {filter_fmu}: must be one of {', '.join(FILTERS)}")
    found_by_itself = begin is None and end is None
    chosen = longest_standing(recording) if found_by_itself else between(recording, begin, end)
    rest = None if chosen is None else at_rest(chosen)
    drives = start is not None or moves(recording)
    if rest is None and not drives:
        raise InputError(
            f"{recording.name}: the vehicle neither stands for a while nor drives with fixes; choose a "
            "stretch at rest with --from and --to"
        )
    found = {finding.name: finding for finding in _of_rest(rest)} if rest else {}
    drive, unused = None, None
    if drives:
        navigation = fmus[NAVIGATION_FILTER]
        told = {
            name: finding.value
            for name, finding in found.items()
            if finding.value is not None and navigation.has_parameter(name)
        }
        try:
            drive = from_drive(recording, start, told=told, progress=progress, fmus=fmus)
        except ShortDriveError as short:
            if rest is None:
                raise
            unused = str(short)
        else:
            for finding in _of_drive(drive):
                found[finding.name] = _both(finding, found.get(finding.name))
    fmu = fmus[filter_fmu]
    findings = tuple(finding for name, finding in found.items() if fmu.has_parameter(name))
    return Derivation(recording.name, fmu, findings, rest, drive, unused)


def bias_walk(sizes: Mapping[str, float]) -> float:
    """Random walk that stands for all slow noises [u/s^1.5]."""
    walk = sizes.get("random_walk", 0.0) ** 2
    if "markov_sigma" in sizes:
        walk += 2 * sizes["markov_sigma"] ** 2 / sizes["markov_time"]
    if "bias_instability" in sizes and sizes["white_noise"] > 0:
        walk += 3 * (FLICKER_FLOOR * sizes["bias_instability"]) ** 4 / sizes["white_noise"] ** 2
    return float(np.sqrt(walk))


def _both(drive: Finding, rest: Finding | None) -> Finding:
    """What the drive shows, else what the stretch at rest shows, with the evidence of both."""
    if rest is None:
        return drive
    value = rest.value if drive.value is None else drive.value
    return Finding(drive.name, value, (*rest.evidence, *drive.evidence))


def _of_rest(rest: AtRest) -> Iterator[Finding]:
    explained = all(fit.explains for triad in rest.sensors.values() for fit in triad.told)
    for sensor in SENSORS:
        triad = rest.sensors[sensor]
        where = f"at rest, {rest.begin:g} to {rest.end:g} s"
        seen = [{n: e.value for n, e in fit.estimates.items() if e.lower > 0} for fit in triad.told]
        evidence = _evidence(triad, sensor, where)
        doubt = () if explained else (NOT_QUITE,)
        yield _told(WHITE[sensor], seen, partial(_size, "white_noise"), (*evidence, *doubt))
        walk = f"process.{sensor}_bias_random_walk"
        if not explained:
            yield Finding(walk, None, (f"{where}: {NOT_QUITE}",))
            continue
        yield _told(walk, seen, bias_walk, (f"{where}: the walk of all slow noises above together",))
        for part in ("markov_sigma", "markov_time"):
            about = (f"{where}: Gauss-Markov part, as above",)
            if any(part in sizes for sizes in seen):
                yield _told(f"process.{sensor}_{part}", seen, partial(_size, part), about)
    mean = rest.sensors["gyro"].mean
    size = float(np.linalg.norm(mean))
    rates = ", ".join(f"{axis} {rate / DEGREE * HOUR:.4g}" for axis, rate in zip(AXES, mean, strict=True))
    sentence = f"at rest: mean rates {rates} deg/h, of which the Earth's are at most 15.04"
    known = size > 3 * EARTH_RATE
    yield Finding("prior.gyro_bias_sigma", _of_three(mean).value if known else None, (sentence,))


def _size(name: str, sizes: Mapping[str, float]) -> float:
    return sizes.get(name, 0.0)


def _told(
    name: str,
    seen: list[dict[str, float]],
    quantity: Callable[[Mapping[str, float]], float],
    evidence: tuple[str, ...],
) -> Finding:
    """Root mean square over the axes that show it; not told if none does."""
    values = [value for sizes in seen if (value := quantity(sizes)) > 0]
    return Finding(name, float(np.sqrt(np.mean(np.square(values)))) if values else None, evidence)


def _evidence(triad: SensorAtRest, sensor: str, where: str) -> tuple[str, ...]:
    """What was fitted."""
    if triad.alike:
        return (f"{where}, all axes: {_words(triad.joint, sensor)}",)
    lines = (f"{axis}: {_words(fit, sensor)}" for axis, fit in zip(AXES, triad.axes, strict=True))
    return (f"{where}; the axes differ:", *lines)


def _words(fit: NoiseFit, sensor: str) -> str:
    units = UNITS[sensor]
    return "; ".join(
        f"{name.replace('_', ' ')} {_interval(estimate)} {units[name]}"
        for name, estimate in fit.estimates.items()
    )


def _interval(estimate: Estimate) -> str:
    if estimate.lower == 0.0:
        return f"not seen, at most {estimate.upper:.3g}"
    return f"{estimate.value:.3g} [{estimate.lower:.3g}, {estimate.upper:.3g}]"


def _of_drive(drive: FromDrive) -> Iterator[Finding]:
    innovations = drive.fit.innovations
    z, tail = innovations.standardised, innovations.tail
    wider = f"times {tail:.3g}, so that 0.27 % are beyond 3 sigma and a gate refuses few"
    widened = () if tail == 1.0 else (wider,)
    where = f"drive, {drive.begin:g} to {drive.end:g} s, {len(innovations.time)} fixes"
    for name, estimate in drive.fit.estimates.items():
        evidence = f"{where}: innovations most likely with {_interval(estimate)} (SI)"
        if drive.believes and name.startswith("measurement."):
            evidence += ", where a fix does not tell a larger one"
        yield Finding(name, tail * estimate.value if estimate.lower > 0 else None, (evidence, *widened))
    fits = (
        f"the mean square of the standardised innovations is {np.mean(z**2):.3f}, and "
        f"{np.mean(np.abs(z) > 3):.2%} are beyond 3 sigma"
    )
    for sensor, (bias, sigma) in drive.biases.items():
        estimate = _of_three(np.hypot(bias, sigma))
        values = ", ".join(f"{b:.3g} +- {s:.1g}" for b, s in zip(bias, sigma, strict=True))
        lines = (f"drive: biases at its end {values}; sigma {_interval(estimate)} (SI)", fits)
        yield Finding(f"prior.{sensor}_bias_sigma", estimate.value, lines)


def _of_three(values: Array) -> Estimate:
    """Sigma of what three axes are samples of, around zero."""
    sigma, tail = float(np.sqrt(np.mean(values**2))), (1 - CONFIDENCE) / 2
    low, high = (sigma * float(np.sqrt(len(values) / chi2.ppf(p, len(values)))) for p in (1 - tail, tail))
    return Estimate(sigma, low, high)
