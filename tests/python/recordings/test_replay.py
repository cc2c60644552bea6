"""Recordings through the filters: what the plant makes, and a real one where it is present."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from plant_signals import as_csv, as_table, sensed, told_as_in
from town_drive import TownDrive

import sim_scenarios
from sim_scenarios import Outages, Start, ZeroVelocity, curves
from sim_scenarios.attitude import wrap
from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, Fmus
from sim_scenarios.recordings import comparison, outages
from sim_scenarios.recordings import load as load_recording
from sim_scenarios.recordings.feed import feed
from sim_scenarios.recordings.tables import ImuTable, Recording, ReferenceTable
from sim_scenarios.report import report_replay
from sim_scenarios.scenario import load_scenario
from sim_scenarios.units import DEGREE

REAL = Path(os.environ.get("TRUENORTH_RECORDINGS", ""), "parked_vehicle_rlg.csv.gz")
needs_real = pytest.mark.skipif(
    not REAL.exists(), reason=f"no {REAL.name} in the folder TRUENORTH_RECORDINGS"
)
SITE = (34.246048, 108.909664, 380.0)
GOOD_SENSORS = {
    "prior.gyro_bias_sigma": "0.02 deg/h",
    "prior.accelerometer_bias_sigma": "0.1 mg",
    "process.angle_random_walk": "0.001 deg/h^0.5",
    "process.velocity_random_walk": "50 ug/Hz^0.5",
}
SHIP = 320.0  # s
INVARIANT = {"error_model": "invariant", "predictor": "linearised", "corrector": "standard"}


@pytest.fixture(scope="module")
def ship(all_fmus: Fmus) -> Recording:
    return sensed(all_fmus, "swaying_ship", SHIP)


@pytest.mark.parametrize(
    ("scenario", "settings"),
    [
        ("swaying_ship", {}),
        ("swaying_ship", {"gnss.lever_arm": 2.0}),
        ("dvl_alignment", {}),
        ("compass_start", {}),
    ],
)
def test_replay_equals_the_direct_run(all_fmus: Fmus, scenario: str, settings: dict[str, object]) -> None:
    """The filter gets the same numbers from a recording of its sensors as from the plant, aids included."""
    seconds = {"duration": 160.0, "evaluation.start": 100.0, "evaluation.stop": 160.0}
    plant = {f"plant.{name}": value for name, value in settings.items()}
    told = {f"filter.{name}": value for name, value in settings.items()}
    live = sim_scenarios.run(scenario, seed=21, set={**seconds, **plant, **told}, fmus=all_fmus)
    made = sensed(all_fmus, scenario, 160.0, settings=plant)
    told = told_as_in(scenario, all_fmus)
    replayed = sim_scenarios.replay(replace(made, reference=None), Start(0.0), set=told, fmus=all_fmus)
    names = ("nav.heading", "nav.velocity", "nav.latitude", "heading_sigma", "gyro_bias", "nis", "fix_time")
    for name in names:
        np.testing.assert_allclose(replayed[name], live[name], rtol=1e-9, atol=1e-15, err_msg=name)


def test_replay_of_a_file_equals_the_direct_run(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    path = as_csv(ship, tmp_path / "ship.csv.gz")
    live = sim_scenarios.run(
        "swaying_ship", seed=21, set={"duration": SHIP, "evaluation.stop": SHIP}, fmus=all_fmus
    )
    told = told_as_in("swaying_ship", all_fmus)
    replayed = sim_scenarios.replay(path, Start(0.0), set=told, fmus=all_fmus)
    np.testing.assert_allclose(replayed["nav.heading"], live["nav.heading"], rtol=1e-9)
    np.testing.assert_allclose(replayed["fix_time"], live["fix_time"], rtol=1e-12)
    np.testing.assert_allclose(replayed["nis"], live["nis"], rtol=1e-9)


def test_an_alignment_hands_over_on_a_recording_as_in_a_scenario(all_fmus: Fmus) -> None:
    settings = {"alignment.convergence.heading_sigma": "3 deg", "alignment.convergence.hold_time": 5.0}
    seconds = {"duration": 200.0, "evaluation.start": 190.0, "evaluation.stop": 200.0}
    live = sim_scenarios.run("align_then_navigate", seed=21, set={**seconds, **settings}, fmus=all_fmus)
    made = sensed(all_fmus, "align_then_navigate", 200.0)
    told = handed_as_in("align_then_navigate", all_fmus)
    replayed = sim_scenarios.replay(
        made, Start(0.0), filter="align_then_navigate", set={**told, **settings}, fmus=all_fmus
    )
    assert 10.0 < float(live["hand_over_time"]) < 190.0
    names = ("hand_over_time", "nav.heading", "nav.latitude", "heading_sigma", "alignment.nav.heading", "nis")
    for name in names:
        np.testing.assert_allclose(replayed[name], live[name], rtol=1e-9, atol=1e-15, err_msg=name)
    np.testing.assert_allclose(replayed["position_error"], live["position_error"], atol=1e-6)
    off = wrap(replayed["heading_error"].values - live["heading_error"].values)
    assert np.nanmax(np.abs(off)) < 1e-9


def handed_as_in(scenario: str, fmus: Fmus) -> dict[str, object]:
    """Settings of both filters of a scenario, the start of the alignment included."""
    loaded = load_scenario(scenario, fmus, seed=21)
    assert loaded.alignment is not None
    start = {n: v for n, v in told_as_in(scenario, fmus).items() if n.startswith("initial.")}
    start = {name: value for name, value in start.items() if fmus[ALIGNMENT_FILTER].has_parameter(name)}
    return {
        **{f"alignment.{name}": value for name, value in {**start, **loaded.alignment}.items()},
        **{f"filter.{name}": value for name, value in loaded.filter.items()},
    }


@pytest.mark.parametrize(
    ("rate", "grid", "origin"),
    [(300.0, 1e-6, 0.0), (400.0, 1e-3, 0.0), (187.5, 1e-3, 0.0), (1000.0, 2.4e-7, 1.7e9)],
)
def test_coarse_stamps_change_nothing(rate: float, grid: float, origin: float, all_fmus: Fmus) -> None:
    """The same increments with stamps as a logger writes them: no sample is missing, the heading the same.

    A stamp that is off by dt carries gravity g dt into the velocity beside a fix of 0.1 m/s: three sigmas of
    the rounding to a grid are allowed, and one part in a hundred besides.
    """
    fixes = rate / int(rate)
    settings = {"plant.imu.rate": rate, "plant.gnss.rate": fixes, "communication_step": 1 / rate}
    made = sensed(all_fmus, "swaying_ship", 40.0, settings=settings)
    made = replace(made, reference=None)
    told = {**told_as_in("swaying_ship", all_fmus), **INVARIANT, "coarse.enabled": False}
    clean = sim_scenarios.replay(made, Start(0.0), set=told, fmus=all_fmus)
    time = origin + np.round(made.imu.time / grid) * grid
    gnss = replace(made.gnss, time=made.gnss.time + origin)
    logged = replace(made, imu=replace(made.imu, time=time), gnss=gnss)
    found = sim_scenarios.replay(logged, Start(0.0), set=told, fmus=all_fmus)
    assert int(found["missed_samples"].values[-1]) == 0
    assert int(found["rejected_samples"].values[-1]) == 0
    assert int(found["clock_disagreements"].values[-1]) == 0
    assert int(found["rejected_fixes"].values[-1]) == 0
    off = wrap(found["nav.heading"].values[-1] - clean["nav.heading"].values[-1])
    rounding = 3 * 9.8 * grid / np.sqrt(12) / 0.1
    assert abs(off) < (0.01 + rounding) * float(clean["heading_sigma"].values[-1])


def test_late_stamps_change_nothing(ship: Recording, all_fmus: Fmus) -> None:
    """Up to nine tenths of a period late, as of a host that has more to do: no sample passes for lost."""
    made = replace(ship, reference=None)
    told = {**told_as_in("swaying_ship", all_fmus), **INVARIANT, "coarse.enabled": False}
    clean = sim_scenarios.replay(made, Start(0.0), set=told, fmus=all_fmus)
    late = 0.009 * np.random.default_rng(3).uniform(0.0, 1.0, len(made.imu.time))
    logged = replace(made, imu=replace(made.imu, time=made.imu.time + late))
    found = sim_scenarios.replay(logged, Start(0.0), set=told, fmus=all_fmus)
    assert int(found["missed_samples"].values[-1]) == 0
    assert int(found["rejected_fixes"].values[-1]) == 0
    off = wrap(found["nav.heading"].values[-1] - clean["nav.heading"].values[-1])
    assert abs(off) < 0.05 * float(clean["heading_sigma"].values[-1])
    assert "moved onto its own steady clock" in found.attrs["messages"]


def test_a_gap_is_bridged_and_counted(ship: Recording, all_fmus: Fmus) -> None:
    kept = np.ones(len(ship.imu.time), dtype=bool)
    kept[5000:5007] = False
    imu = ImuTable(*(values[kept] for values in vars(ship.imu).values()))
    gapped = replace(ship, imu=imu, reference=None)
    assert feed(gapped).columns["imu.sample"][-1] == len(ship.imu.time)
    run = sim_scenarios.replay(gapped, Start(0.0), set=told_as_in("swaying_ship", all_fmus), fmus=all_fmus)
    assert int(run["missed_samples"].values[-1]) == 7


def test_a_parked_vehicle_finds_its_heading(all_fmus: Fmus) -> None:
    made = replace(sensed(all_fmus, "parked_vehicle", SHIP), gnss=None, reference=None)
    run = sim_scenarios.replay(
        made, Start(100.6 * DEGREE), zero_velocity=ZeroVelocity(SITE), set=GOOD_SENSORS, fmus=all_fmus
    )
    late = run["time"].values >= 300
    error = run["nav.heading"].values[late] / DEGREE - 90.6
    sigma = run["heading_sigma"].values[late] / DEGREE
    assert np.all(np.abs(error) < 3 * sigma)
    assert bool(run["converged"].values[-1])


@needs_real
def test_the_real_recording_comes_to_its_heading(all_fmus: Fmus) -> None:
    run = sim_scenarios.replay(
        REAL, Start(100.6 * DEGREE), zero_velocity=ZeroVelocity(SITE), set=GOOD_SENSORS, fmus=all_fmus
    )
    late = run["nav.heading"].values[run["time"].values >= 300] / DEGREE
    assert np.all(np.abs(late - 90.60) < 0.1)
    assert bool(run["converged"].values[-1])
    assert int(run["rejected_samples"].values[-1]) == 0


@needs_real
def test_the_real_recording_comes_to_its_heading_without_being_told_one(all_fmus: Fmus) -> None:
    run = sim_scenarios.replay(
        REAL,
        zero_velocity=ZeroVelocity(SITE),
        set={**GOOD_SENSORS, "prior.tilt_sigma": "1 deg"},
        fmus=all_fmus,
    )
    late = run["nav.heading"].values[run["time"].values >= 300] / DEGREE
    assert np.all(np.abs(late - 90.60) < 0.05)
    assert bool(run["converged"].values[-1])


@needs_real
@pytest.mark.parametrize("coarse", [True, False])
@pytest.mark.parametrize("off", [10.0, 80.0, 170.0])
def test_the_real_recording_comes_to_its_heading_from_anywhere(
    all_fmus: Fmus, off: float, coarse: bool
) -> None:
    """With the coarse stage without any heading: whatever the start says is not used."""
    run = sim_scenarios.replay(
        REAL,
        Start((90.6 + off) * DEGREE, heading_sigma=104 * DEGREE),
        zero_velocity=ZeroVelocity(SITE),
        set={**GOOD_SENSORS, **INVARIANT, "prior.tilt_sigma": "1 deg", "coarse.enabled": coarse},
        fmus=all_fmus,
    )
    late = run["nav.heading"].values[run["time"].values >= 300] / DEGREE
    assert np.all(np.abs(late - 90.60) < 0.05)
    assert bool(run["converged"].values[-1])


def test_without_a_heading_the_alignment_is_one_that_needs_none(ship: Recording, all_fmus: Fmus) -> None:
    run = sim_scenarios.replay(replace(ship, reference=None), fmus=all_fmus)
    assert '"error_model": "invariant"' in run.attrs["settings"]
    assert "started without a heading" in run.attrs["description"]
    with pytest.raises(InputError, match="the model large_azimuth of AlignmentFilter needs a heading"):
        sim_scenarios.replay(ship, set={"error_model": "large_azimuth"}, fmus=all_fmus)
    with pytest.raises(InputError, match="the model loose of NavigationFilter needs a heading"):
        sim_scenarios.replay(ship, filter="navigation", fmus=all_fmus)


def test_what_is_likely_wrong_is_told(all_fmus: Fmus) -> None:
    town = TownDrive().recording(60.0)
    left = [part[:, [1, 0, 2]] * [1, -1, 1] for part in (town.imu.delta_angle, town.imu.delta_velocity)]
    made = replace(town, imu=ImuTable(town.imu.time, *left), remarks=("one row left out",))
    run = sim_scenarios.replay(made, Start(heading=0.0), filter="navigation", fmus=all_fmus)
    assert json.loads(run.attrs["messages"])[0] == "town: one row left out"
    assert "town: speed is gained along 1.00, " in run.attrs["messages"]


@pytest.mark.parametrize("unmeasured", [slice(0, 3), slice(2, 3)], ids=["positions alone", "no velocity up"])
def test_fixes_that_are_not_whole_are_used(
    ship: Recording, all_fmus: Fmus, tmp_path: Path, unmeasured: slice
) -> None:
    """The coarse stage takes none of them."""
    velocity = ship.gnss.velocity.copy()
    velocity[:, unmeasured] = np.nan
    made = replace(ship, gnss=replace(ship.gnss, velocity=velocity), reference=None)
    run = sim_scenarios.replay(made, fmus=all_fmus)
    assert int(run["used_fixes"].values[-1]) > 0
    assert "coarse.enabled = false" in run.attrs["messages"]
    assert '<figure id="innovations">' in report_replay(run, tmp_path / "a").read_text(encoding="utf-8")
    run = sim_scenarios.replay(made, set={"coarse.enabled": True}, fmus=all_fmus)
    assert int(run["used_fixes"].values[-1]) == 0
    assert "the alignment begins without" not in run.attrs["messages"]
    page = report_replay(run, tmp_path / "b").read_text(encoding="utf-8")
    assert '<figure id="heading">' in page
    assert '<figure id="innovations">' not in page


def test_what_a_recording_lacks_is_said(ship: Recording, all_fmus: Fmus) -> None:
    bare = replace(ship, gnss=None)
    with pytest.raises(InputError, match=r"no fix has a position; record GNSS, .*zero-velocity"):
        sim_scenarios.replay(bare, Start(0.0), fmus=all_fmus)
    with pytest.raises(InputError, match="a rate and a sigma greater than 0"):
        ZeroVelocity(SITE, sigma=0.0)
    with pytest.raises(InputError, match="rate = 1000 Hz: must be at most that of the recording, 100 Hz"):
        sim_scenarios.replay(bare, Start(0.0), zero_velocity=ZeroVelocity(SITE, rate=1e3), fmus=all_fmus)
    with pytest.raises(InputError, match=r"did you mean 'robust.gamma'"):
        sim_scenarios.replay(ship, Start(0.0), set={"robust.gama": 1.0}, fmus=all_fmus)
    with pytest.raises(InputError, match="filter = 'both': must be one of alignment, navigation"):
        sim_scenarios.replay(ship, Start(0.0), filter="both", fmus=all_fmus)
    with pytest.raises(InputError, match="error_model = tight: needs channels of a receiver"):
        sim_scenarios.replay(
            ship, Start(0.0), filter="navigation", set={"error_model": "tight"}, fmus=all_fmus
        )


def test_a_setting_goes_to_every_filter_that_has_it(all_fmus: Fmus) -> None:
    made = sensed(all_fmus, "align_then_navigate", 20.0)
    run = sim_scenarios.replay(
        made,
        filter="align_then_navigate",
        set={"gate.threshold": 9.0, "filter.gate.threshold": 12.0, "coarse.heading_sigma": "2 deg"},
        fmus=all_fmus,
    )
    assert '"alignment": {' in run.attrs["settings"]
    alignment, navigation = run.attrs["settings"].split('"filter": {')
    assert '"gate.threshold": "9"' in alignment
    assert '"coarse.heading_sigma": "2 deg"' in alignment
    assert '"gate.threshold": "12"' in navigation
    assert np.isnan(run["hand_over_time"])  # twenty seconds are too short
    assert outages.ends(run) == []
    assert comparison.against_reference(run) is None


def test_a_reference_is_the_truth(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    told = told_as_in("swaying_ship", all_fmus)
    live = sim_scenarios.run(
        "swaying_ship", seed=21, set={"duration": SHIP, "evaluation.stop": SHIP}, fmus=all_fmus
    )
    run = sim_scenarios.replay(ship, Start(0.0), set=told, evaluate_after=300.0, fmus=all_fmus)
    rows = (live["time"].values >= 300) & (live["time"].values <= SHIP)
    found = comparison.against_reference(run)
    assert found is not None
    error = wrap(live["heading_error"].values[rows])
    assert found.heading == pytest.approx(float(np.sqrt(np.mean(error**2))), rel=1e-6)
    assert found.horizontal == pytest.approx(
        float(np.sqrt(np.mean(np.sum(live["position_error"].values[rows, :2] ** 2, axis=1)))), rel=1e-6
    )
    assert found.certainty.wrongly == 0
    page = report_replay(run, tmp_path).read_text(encoding="utf-8")
    assert f"{found.heading / DEGREE:.3f} deg" in page
    for name in ("heading", "states", "navigation", "errors", "track"):
        assert f'<figure id="{name}">' in page


def test_a_reference_of_positions_alone_judges_positions_alone(
    ship: Recording, all_fmus: Fmus, tmp_path: Path
) -> None:
    reference = ship.reference
    reference = replace(reference, attitude=np.full_like(reference.attitude, np.nan))
    reference = replace(reference, velocity=np.full_like(reference.velocity, np.nan))
    told = told_as_in("swaying_ship", all_fmus)
    run = sim_scenarios.replay(replace(ship, reference=reference), Start(0.0), set=told, fmus=all_fmus)
    found = comparison.against_reference(run)
    assert found is not None
    assert 0 < found.horizontal < 10
    assert np.isnan([found.heading, found.tilt, found.velocity, found.nees]).all()
    assert "heading_error" not in run
    assert "Horizontal RMSE" in report_replay(run, tmp_path).read_text(encoding="utf-8")


@pytest.mark.parametrize("after", [-1.0, 1e9, float("nan")])
def test_a_result_is_judged_from_a_time_of_the_recording_on(
    ship: Recording, all_fmus: Fmus, after: float
) -> None:
    words = re.escape(f"evaluate_after = {after:g} s: must be at least 0 and less than")
    with pytest.raises(InputError, match=words):
        sim_scenarios.replay(ship, Start(0.0), evaluate_after=after, fmus=all_fmus)


def test_a_reference_counts_where_it_is(ship: Recording, all_fmus: Fmus, tmp_path: Path) -> None:
    """It begins at 100 s, tells nothing from 200 s to 250 s, and ends at 300 s."""
    time = ship.reference.time
    kept = (time >= 100) & (time <= 300) & ((time <= 200) | (time >= 250))
    reference = ReferenceTable(*(values[kept] for values in vars(ship.reference).values()))
    told = told_as_in("swaying_ship", all_fmus)
    made = replace(ship, reference=reference)
    run = sim_scenarios.replay(made, Start(0.0), set=told, evaluate_after=0.0, fmus=all_fmus)
    judged = comparison.compared(run)["time"].values
    assert judged.min() == pytest.approx(100, abs=0.06)
    assert judged.max() == pytest.approx(300, abs=0.06)
    assert not np.any((judged > 200.06) & (judged < 249.94))
    whole = sim_scenarios.replay(ship, Start(0.0), set=told, evaluate_after=0.0, fmus=all_fmus)
    rows = np.isin(whole["time"].values, judged)
    expected = np.sqrt(np.mean(wrap(whole["heading_error"].values[rows]) ** 2))
    found = comparison.against_reference(run)
    assert found is not None
    assert found.heading == pytest.approx(float(expected), rel=1e-6)
    report_replay(run, tmp_path)


def test_fixes_are_withheld_in_outages_and_are_their_truth(all_fmus: Fmus) -> None:
    settings = {"motion.turn.angle": 0.0}
    made = sensed(all_fmus, "align_then_navigate", 120.0, settings=settings)
    truth = made.reference.attitude[0]
    run = sim_scenarios.replay(
        made,
        Start(float(truth[2]), heading_sigma=0.5 * DEGREE),
        filter="navigation",
        outages=Outages(10.0, 40.0),
        set={"prior.gyro_bias_sigma": "0.05 deg/h"},
        fmus=all_fmus,
    )
    withheld = run["receiver.withheld"].values
    np.testing.assert_array_equal(
        run["receiver_time"].values[withheld], [*range(30, 40), *range(70, 80), *range(110, 120)]
    )
    used = run["fix_time"].values
    assert not np.isin([30.0, 39.0, 75.0, 119.0], used).any()
    assert np.isin([29.0, 40.0, 69.0, 80.0], used).all()
    found = outages.ends(run)
    assert [(end.begin, end.end, end.time) for end in found] == [
        (30.0, 40.0, 39.0),
        (70.0, 80.0, 79.0),
        (110.0, 120.0, 119.0),
    ]
    # The fix itself is off by 5 m in each direction: held against the truth, not by how much but by what.
    for end in found:
        row = int(np.searchsorted(run["time"].values, end.time))
        fix = made.gnss.position[np.searchsorted(made.gnss.time, end.time)]
        path = np.array([run[f"nav.{n}"].values[row] for n in ("latitude", "longitude", "height")])
        off = (path - fix) * [6.36e6, 6.37e6 * np.cos(fix[0]), 1.0]
        assert end.horizontal == pytest.approx(np.hypot(off[0], off[1]), rel=0.01)
        assert end.vertical == pytest.approx(abs(off[2]), rel=1e-6)


@pytest.mark.parametrize(("length", "every"), [(0.0, 10.0), (10.0, 10.0), (20.0, 10.0), (1.0, np.inf)])
def test_outages_that_are_none_are_refused(length: float, every: float) -> None:
    with pytest.raises(InputError, match="must be longer than 0 and shorter than their period"):
        Outages(length, every)


def test_outages_need_a_recording_that_is_long_enough() -> None:
    with pytest.raises(InputError, match="must be at least that long; it lasts 50 s"):
        Outages(10.0, 60.0).windows(10.0, 60.0)


def test_heading_minus_course_of_a_ship_without_leeway(all_fmus: Fmus) -> None:
    """It is what the filter is off by, and the yaw of the ship: 5 deg, 3.5 in the mean square."""
    made = sensed(all_fmus, "align_then_navigate", 120.0)
    start = Start(float(made.reference.attitude[0, 2]), heading_sigma=0.5 * DEGREE)
    run = sim_scenarios.replay(made, start, filter="navigation", evaluate_after=20.0, fmus=all_fmus)
    found = comparison.against_fixes(run)
    moving = made.gnss.time >= 20.0
    heading = np.interp(made.gnss.time[moving], made.imu.time, np.unwrap(made.reference.attitude[:, 2]))
    course = np.arctan2(made.gnss.velocity[moving, 0], made.gnss.velocity[moving, 1])
    true = wrap(heading - course)
    assert found.heading_mean == pytest.approx(float(np.mean(true)), abs=0.5 * DEGREE)
    assert found.heading_deviation == pytest.approx(float(np.std(true)), abs=0.2 * DEGREE)
    assert found.horizontal == pytest.approx(5 * 2**0.5, rel=0.2)  # of the fixes themselves
    assert found.fixes == np.count_nonzero(moving)


def test_the_plain_form_has_what_the_recording_has(ship: Recording, tmp_path: Path) -> None:
    read = load_recording(as_csv(ship, tmp_path / "ship.csv"))
    np.testing.assert_array_equal(read.imu.delta_angle, ship.imu.delta_angle)
    np.testing.assert_array_equal(read.gnss.velocity, ship.gnss.velocity)
    np.testing.assert_allclose(read.gnss.position, ship.gnss.position, rtol=1e-15)
    assert len(as_table(ship)) == len(read.imu.time)


@pytest.mark.parametrize(
    "known", [{"attitude"}, {"attitude", "velocity"}, {"attitude", "position"}, {"position"}]
)
def test_the_page_shows_what_a_reference_knows(
    known: set[str], ship: Recording, all_fmus: Fmus, tmp_path: Path
) -> None:
    """Somebody else's solution may be an attitude alone."""
    reference = ship.reference
    assert reference is not None
    unknown = {
        name: np.full_like(getattr(reference, name), np.nan)
        for name in {"attitude", "velocity", "position"} - known
    }
    told = {**told_as_in("swaying_ship", all_fmus), **INVARIANT, "coarse.enabled": False}
    partly = replace(ship, reference=replace(reference, **unknown))
    run = sim_scenarios.replay(partly, Start(0.0), set=told, fmus=all_fmus)
    assert {name for name in ("attitude", "velocity", "position") if f"{name}_error" in run} == known
    of_errors = {
        panel["title"].split()[0] for panel in curves.of_replay(run) if "error with" in panel["title"]
    }
    names = {"attitude": "Misalignment", "velocity": "Velocity", "position": "Position"}
    assert of_errors == ({names[name] for name in known} if "attitude" in known else set())
    assert report_replay(run, tmp_path).is_file()
