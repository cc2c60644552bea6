"""A replay smoothed: navigation at every instant by all fixes, those that came later too.

The filter goes forward as it does without. At each fix its outputs are recorded as they would be without it
and as they are with it, the whole covariance of its fifteen errors among them. What lies between is the
linear error model of `bounds` along the filter's own track, by which the covariance is carried from fix to
fix and the corrections back (`rauch_tung_striebel`). Corrections are differences on the group, computed minus
true: a rotation vector of the attitude, east, north, up of velocity and position, and biases that are left.

The chain is severed, and what precedes is smoothed by its own fixes alone, where the later tells nothing of
the earlier: where the attitude is not known to `WIDE`, for which linear errors are wrong; and where a fix
widened a covariance, or moved the estimate by more than `BEYOND` sigmas of what was predicted. That is the
filter on its way back, or a corrector that takes its prediction for wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim_scenarios import recording as results
from sim_scenarios.attitude import dcm
from sim_scenarios.bounds import (
    ACCELEROMETER_BIAS,
    ATTITUDE,
    GYRO_BIAS,
    POSITION,
    VELOCITY,
    Trajectory,
    discretised,
)
from sim_scenarios.cosimulation import Columns, Corrections
from sim_scenarios.earth import displaced, displacement
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import NAVIGATION_FILTER, Fmu, Number
from sim_scenarios.rauch_tung_striebel import Forward, smooth
from sim_scenarios.recordings import track
from sim_scenarios.recordings.tables import Recording
from sim_scenarios.units import DEGREE

Array = NDArray[np.float64]

WIDE: Final = 0.35
"""Sigma of the attitude from which linear errors are not believed [rad]: at 20 deg what is smoothed is
consistent, at 40 deg it is not."""
BEYOND: Final = 5.0
"""Sigmas of the prediction beyond which a correction contradicts it."""
GROWN: Final = 1.1
"""By how much a sigma may grow at a fix: the covariance before it is integrated apart from the filter's."""
MODELS: Final = ("loose", "invariant")
"""Error models whose fifteen states are those of `bounds`."""
UNFIT: Final = ("h_infinity",)
"""Correctors whose covariance is that of no estimate."""
STATES: Final = 15
_TOLD: Final = 5
"""Instants that a message names."""
_AT_ONCE: Final = 5000
"""Intervals whose matrices are made together; those of hours would fill the memory several times over."""
PREFIX: Final = "smoothed."
"""Beginning of the names of smoothed outputs in a data set."""

_ATTITUDE: Final = ("roll", "pitch", "heading")
_POSITION: Final = ("latitude", "longitude", "height")
_SIGMAS: Final = {"misalignment": ATTITUDE, "velocity": VELOCITY, "position": POSITION}
_BIASES: Final = {"gyro_bias": GYRO_BIAS, "accelerometer_bias": ACCELEROMETER_BIAS}
_ESTIMATE: Final = (*(f"nav.{name}" for name in (*_ATTITUDE, *_POSITION, "velocity")), *_BIASES)
_COVARIANCES: Final = ("covariance", "position_covariance")
_DENSITIES: Final = {
    "process.angle_random_walk": ATTITUDE,
    "process.velocity_random_walk": VELOCITY,
    "process.gyro_bias_random_walk": GYRO_BIAS,
    "process.accelerometer_bias_random_walk": ACCELEROMETER_BIAS,
}


def outputs(fmu: Fmu) -> list[str]:
    """Scalar outputs of a filter that are recorded with and without each fix."""
    return [scalar for name in (*_ESTIMATE, *_COVARIANCES) for scalar in fmu.arrays[name]]


def check(fmu: Fmu, values: Mapping[str, Number], recording: Recording) -> None:
    """Refuse what cannot be smoothed.

    Raises
    ------
    InputError
        The filter does not put out the covariance of fifteen errors, or is corrected by more than fixes.
    """
    if fmu.name != NAVIGATION_FILTER:
        raise InputError(
            f"smoothing: {fmu.name} does not navigate; choose the filter navigation or align_then_navigate"
        )
    if "position_covariance" not in fmu.arrays:
        raise InputError(f"smoothing: {fmu.path} is of a version without the output position_covariance")
    model, corrector = (_chosen(fmu, values, name) for name in ("error_model", "corrector"))
    if model not in MODELS:
        raise InputError(
            f"error_model = {model}: cannot be smoothed, as it does not estimate the biases of the sensors; "
            f"must be one of {', '.join(MODELS)}"
        )
    if corrector in UNFIT:
        raise InputError(
            f"corrector = {corrector}: cannot be smoothed, as its covariance is wider than its errors are"
        )
    aids = [name for name in ("body_velocity", "heading_aid", "height_aid") if getattr(recording, name)]
    aids += [
        name
        for name in ("standstill.velocity_sigma", "standstill.rate_sigma", "nonholonomic.velocity_sigma")
        if values.get(name, fmu.start(name))
    ]
    if aids:
        raise InputError(
            f"smoothing: knows corrections by fixes alone, and {', '.join(aids)} corrects the filter besides"
        )


def smoothed(
    data: xr.Dataset, corrections: Corrections, fmu: Fmu, values: Mapping[str, Number]
) -> tuple[xr.Dataset, list[str]]:
    """A replay with its smoothed navigation, and what there is to say of it.

    Parameters
    ----------
    data : Dataset
        Of `replay`.
    corrections : Corrections
        With `outputs` of the filter.
    fmu, values
        The filter and its parameters.

    Returns
    -------
    tuple of Dataset and list of str
        With the variables `smoothed.*` over time: the estimate, its sigmas and the covariance as they are
        named without that; where nothing is smoothed they are the filter's.
    """
    rows = data["time"].values
    going = rows >= track.navigates_from(data)
    if np.count_nonzero(going) < 2:
        return data, ["Nothing is smoothed: the filter does not navigate."]
    fixed = corrections.time > rows[going][0]
    periodic = going & ~np.isin(rows, corrections.time[fixed])
    time = np.concatenate((rows[periodic], corrections.time[fixed]))
    order = np.argsort(time)

    def of_all(columns: Columns, names: Iterable[str]) -> dict[str, Array]:
        parts = {name: (data[name].values[periodic], _array(columns, fmu, name)[fixed]) for name in names}
        return {name: np.concatenate(both)[order] for name, both in parts.items()}

    before = of_all(corrections.without, _ESTIMATE)
    after = of_all(corrections.after, (*_ESTIMATE, *_COVARIANCES))
    time, with_fix = time[order], np.repeat((False, True), (periodic.sum(), fixed.sum()))[order]
    forward = _forward(time, before, after, with_fix, _densities(fmu, values))
    severed, said = _severed(time, forward)
    deviation, covariance = smooth(forward, severed)

    place = np.searchsorted(time, rows[going])
    found = {
        name: data[name].values.copy()
        for name in (*_ESTIMATE, *(f"{name}_sigma" for name in (*_SIGMAS, *_BIASES, "heading")), "covariance")
    }
    estimate = _moved({name: values[place] for name, values in after.items()}, deviation[place])
    for name, array in {**estimate, **_of_covariance(estimate, covariance[place])}.items():
        found[name][going] = array
    about = {f"{PREFIX}{name}": data[name].copy(data=array) for name, array in found.items()}
    for variable in about.values():
        variable.attrs["description"] = f"Smoothed: {variable.attrs['description']}"
    return data.assign(about), said


def is_smoothed(run: xr.Dataset) -> bool:
    """Whether a replay has a smoothed navigation."""
    return f"{PREFIX}nav.heading" in run


def solution(run: xr.Dataset) -> xr.Dataset:
    """The smoothed navigation of a replay in the place of the filter's, with its own errors.

    It has no fixes of the filter's, as it is off from none before it takes it.
    """
    names = [str(name) for name in run if str(name).startswith(PREFIX)]
    own = run.drop_vars(["position_covariance", "misalignment", *results.ERRORS], errors="ignore")
    own = own.assign({name.removeprefix(PREFIX): run[name] for name in names}).drop_vars(names)
    own = own.isel(fix=slice(0, 0))
    errors = results.errors(own) if "truth.heading" in own else {}
    found: xr.Dataset = own.assign({name: error for name, error in errors.items() if name in run})
    return found


def beside(runs: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Replays by label, behind each its smoothed navigation if it has one."""
    found = {}
    for label, run in runs.items():
        found[label] = run
        if is_smoothed(run):
            found[f"{label}, smoothed"] = solution(run)
    return found


def _chosen(fmu: Fmu, values: Mapping[str, Number], parameter: str) -> str:
    """Item of an enumeration that a filter is set to."""
    return fmu.variables[parameter].display(values.get(parameter, fmu.start(parameter)))


def _densities(fmu: Fmu, values: Mapping[str, Number]) -> Array:
    """Of the white noise that the filter assumes for each state, shape (15,)."""
    density = np.zeros(STATES)
    for name, states in _DENSITIES.items():
        density[states] = float(values.get(name, fmu.start(name))) ** 2
    return density


def _array(columns: Columns, fmu: Fmu, name: str) -> Array:
    """An output of all its scalars, shape (n, ...)."""
    values = np.column_stack([columns[scalar] for scalar in fmu.arrays[name]])
    size = [int(number) for number in fmu.arrays[name][-1].partition("[")[2].rstrip("]").split(",") if number]
    return values.reshape(len(values), *size)


def _forward(
    time: Array,
    before: Mapping[str, Array],
    after: Mapping[str, Array],
    with_fix: NDArray[np.bool_],
    density: Array,
) -> Forward:
    """What the filter did; its covariance between two fixes is carried on from that of the first."""
    begin, end = _trajectory(time, after)[:-1], _trajectory(time, before)[1:]
    filtered = _whole(after)
    predicted, transition = filtered.copy(), np.empty_like(filtered[1:])
    for first in range(0, len(transition), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        transition[part], noise = discretised(begin[part], end[part], density)
        for k, Q in enumerate(noise, start=first):
            predicted[k + 1] = transition[k] @ filtered[k] @ transition[k].T + Q
            if not with_fix[k + 1]:
                filtered[k + 1] = predicted[k + 1]
    return Forward(transition, predicted, filtered, _difference(before, after))


def _whole(columns: Mapping[str, Array]) -> Array:
    """Covariance of all states, shape (n, 15, 15)."""
    handed, of_position = (columns[name] for name in _COVARIANCES)
    rest = np.swapaxes(of_position[..., :12], -1, -2)
    return np.concatenate((np.concatenate((handed, rest), axis=-1), of_position), axis=-2)


def _severed(time: Array, forward: Forward) -> tuple[NDArray[np.bool_], list[str]]:
    """Intervals over which nothing is carried back, and the reasons for people."""
    predicted, filtered = (
        np.sqrt(np.diagonal(P, axis1=1, axis2=2)) for P in (forward.predicted, forward.filtered)
    )
    lost = (np.maximum(filtered[:-1], predicted[1:])[:, ATTITUDE] > WIDE).any(axis=1)
    against = (np.abs(forward.correction[1:]) > BEYOND * predicted[1:]) | (
        filtered[1:] > GROWN * predicted[1:]
    )
    contradicted = against.any(axis=1) & ~lost
    said = []
    if lost.any():
        said.append(
            f"Smoothing: until {time[1:][lost][-1]:.10g} s the attitude was at times not known to "
            f"{WIDE / DEGREE:.0f} deg; there the filter's navigation stands."
        )
    if contradicted.any():
        times = ", ".join(f"{when:.10g}" for when in time[1:][contradicted][:_TOLD])
        more = f" and {contradicted.sum() - _TOLD} more" if contradicted.sum() > _TOLD else ""
        said.append(
            f"Smoothing: nothing is carried back over {times}{more} s, where a fix contradicted the "
            "prediction, and the filter no longer relied on what it had."
        )
    return np.logical_or(lost, contradicted), said


def _trajectory(time: Array, columns: Mapping[str, Array]) -> Trajectory:
    return Trajectory(
        time, _attitude(columns), columns["nav.velocity"], columns["nav.latitude"], columns["nav.height"]
    )


def _attitude(columns: Mapping[str, Array]) -> Array:
    return dcm(*(columns[f"nav.{name}"] for name in _ATTITUDE))


def _position(columns: Mapping[str, Array]) -> Array:
    return np.column_stack([columns[f"nav.{name}"] for name in _POSITION])


def _difference(before: Mapping[str, Array], after: Mapping[str, Array]) -> Array:
    """By how much the errors, computed minus true, change from one estimate to another, shape (n, 15)."""
    turn = _attitude(after) @ np.swapaxes(_attitude(before), -1, -2)
    change = np.zeros((len(turn), STATES))
    change[:, ATTITUDE] = -Rotation.from_matrix(turn).as_rotvec()
    change[:, VELOCITY] = after["nav.velocity"] - before["nav.velocity"]
    change[:, POSITION] = displacement(_position(after), _position(before))
    for name, states in _BIASES.items():
        change[:, states] = before[name] - after[name]
    return change


def _moved(columns: Mapping[str, Array], change: Array) -> dict[str, Array]:
    """The estimate whose difference from another is a change, the inverse of `_difference`."""
    C_bn = Rotation.from_rotvec(-change[:, ATTITUDE]).as_matrix() @ _attitude(columns)
    minus_heading, pitch, roll = Rotation.from_matrix(C_bn).as_euler("ZXY").T
    position = displaced(_position(columns), change[:, POSITION])
    return {
        "nav.roll": roll,
        "nav.pitch": pitch,
        "nav.heading": -minus_heading % (2 * np.pi),
        **{f"nav.{name}": column for name, column in zip(_POSITION, position.T, strict=True)},
        "nav.velocity": columns["nav.velocity"] + change[:, VELOCITY],
        **{name: columns[name] - change[:, states] for name, states in _BIASES.items()},
    }


def _of_covariance(estimate: Mapping[str, Array], covariance: Array) -> dict[str, Array]:
    """Outputs that follow from the covariance of an estimate, by name."""
    sigma = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    east, north, up = _attitude(estimate)[:, :, 1].T  # the forward axis
    slope = -up / (east**2 + north**2)
    gradient = np.column_stack((slope * east, slope * north, np.ones_like(slope)))
    return {
        **{f"{name}_sigma": sigma[:, states] for name, states in {**_SIGMAS, **_BIASES}.items()},
        "heading_sigma": np.sqrt(
            np.einsum("ki,kij,kj->k", gradient, covariance[:, ATTITUDE, ATTITUDE], gradient)
        ),
        "covariance": covariance[:, :12, :12],
    }
