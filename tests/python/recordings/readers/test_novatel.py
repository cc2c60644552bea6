"""NovAtel logs, written here by the manual, come back as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from written.novatel import SECONDS, WEEK, best_position, best_velocity, log, raw_imu, short, written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import novatel
from sim_scenarios.recordings.readers.contents import Clock
from sim_scenarios.units import STANDARD_GRAVITY

SAMPLE = [11, -12, 40000, 1, -2, 3]


@pytest.mark.parametrize(
    ("imu", "angle", "velocity"),
    [
        (8, 2.0**-19, 2.0**-14),
        (11, 2.0**-33, 2.0**-27 * 0.3048),
        (12, 2.0**-33, 2.0**-26 * 0.3048),
        (13, np.radians(0.1 * 2.0**-8 / 3600), 0.05 * 2.0**-15),
        (16, 0.1 / (3600 * 256), 0.05 * 2.0**-15),
        (26, 1e-9, 2e-8),
        (31, np.radians(720 / 2**31), 200 / 2**31),
        (32, np.radians(2.0**-21), 2.0**-22),
        (41, np.radians(0.008 / 65536 / 125), 0.2 / 65536 * 9.80665e-3 / 125),
        (58, 2.0**-33, 2.0**-29),
        (61, np.radians(0.0151515 / 65536 / 200), 0.4 / 65536 * 9.80665e-3 / 200),
    ],
)
def test_counts_by_the_manual_s_table(tmp_path: Path, imu: int, angle: float, velocity: float) -> None:
    lines = [raw_imu(imu, SAMPLE, SECONDS + 0.01 * k) for k in range(3)]
    contents = novatel.read(written(tmp_path / "span.log", *lines))
    assert contents.clock is Clock.GPS
    assert contents.epoch == WEEK * 604800
    assert contents.imu is not None
    assert contents.imu.increments
    assert contents.imu.axes is None
    np.testing.assert_array_equal(contents.imu.time, SECONDS + 0.01 * np.arange(3))
    np.testing.assert_allclose(contents.imu.angular[0], np.array(SAMPLE[3:]) * angle, rtol=1e-13)
    np.testing.assert_allclose(contents.imu.force[0], np.array(SAMPLE[:3]) * velocity, rtol=1e-13)


@pytest.mark.parametrize(
    ("line", "rate"),
    [  # logs that others published: the manual, drivers, decoders
        (
            "%RAWIMUSXA,2209,491674.014;04,41,2209,491674.013699,ea59fe00,329308016,-2706935,4508389,196192,"
            "417138,-1000837*038422a7",
            125,
        ),
        (
            "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,"
            "-41188,-9895*a5db8c7b",
            100,
        ),
        (
            "%RAWIMUSXA,2075,507495.165;00,13,2075,507495.165000000,00000000,32068,-1612,-1320,256,1536,"
            "-255*dd88585c",
            200,
        ),
    ],
)
def test_published_logs_feel_gravity_at_their_rate(tmp_path: Path, line: str, rate: float) -> None:
    imu = novatel.read(written(tmp_path / "span.log", line)).imu
    assert imu is not None
    assert np.linalg.norm(imu.force[0]) * rate == pytest.approx(STANDARD_GRAVITY, rel=0.02)
    assert np.linalg.norm(imu.angular[0]) * rate < np.radians(1.0)


def test_published_logs_of_fixes_headings_and_solutions(tmp_path: Path) -> None:
    path = written(
        tmp_path / "span.log",
        "#BESTPOSA,COM1,0,78.5,FINESTEERING,1419,336208.000,02000040,6145,2724;SOL_COMPUTED,NARROW_INT,"
        '51.11635910984,-114.03833105168,1063.8416,-16.2712,WGS84,0.0135,0.0084,0.0172,"AAAA",1.000,0.000,8,8,'
        "8,8,0,01,0,03*072421c0",
        "#DUALANTENNAHEADINGA,UNKNOWN,0,66.5,FINESTEERING,1949,575614.000,02000000,d426,32768;SOL_COMPUTED,"
        'NARROW_INT,-1.000000000,255.538528442,0.006041416,0.0,0.043859947,0.052394450,"J56X",24,18,18,17,04,'
        "01,00,33*1f082ec5",
        "%INSPVASA,2083,374524.200;2083,374524.200000000,31.51668826020,120.38636567293,13.9998,13.1095,"
        "-12.9404,-0.0070,2.093819658,2.854168081,316.626703726,INS_SOLUTION_GOOD*8fc5adb1",
    )
    contents = novatel.read(path)
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    assert contents.reference is not None
    assert contents.gnss.position[0, 2] == pytest.approx(1063.8416 - 16.2712)
    np.testing.assert_array_equal(contents.gnss.position_sigma[0], [0.0084, 0.0135, 0.0172])
    assert np.degrees(contents.heading_aid.heading[0]) == pytest.approx(255.538528442)
    assert np.degrees(contents.heading_aid.sigma[0]) == pytest.approx(0.043859947)
    velocity, heading = contents.reference.velocity[0], contents.reference.attitude[0, 2]
    course = np.arctan2(velocity[0], velocity[1])
    assert np.degrees(course - heading) % 360 == pytest.approx(360, abs=2)  # a car moves where it points


def test_an_imu_that_is_not_told(tmp_path: Path) -> None:
    counts = short("RAWIMUS", f"{WEEK},{SECONDS},00000077,40000,12,11,3,2,1")
    path = written(tmp_path / "span.log", counts)
    with pytest.raises(InputError, match="RAWIMU does not say which IMU it is: log INSCONFIGA"):
        novatel.read(path)
    written(path, log("INSCONFIG", "STIM300,5,50,20,DEFAULT,7fd1bf,AUTOMATIC"), counts)
    imu = novatel.read(path).imu
    assert imu is not None
    np.testing.assert_allclose(imu.force[0], np.array([11, -12, 40000]) * 2.0**-22, rtol=1e-15)


def test_the_same_imu_told_twice_and_two_imus(tmp_path: Path) -> None:
    config = log("INSCONFIG", "LN200,5,50,20,DEFAULT")
    path = written(tmp_path / "span.log", config, raw_imu(8, SAMPLE))
    assert novatel.read(path).imu is not None
    written(path, config, raw_imu(32, SAMPLE))
    with pytest.raises(InputError, match="IMUs 32, LN200 stand in one file"):
        novatel.read(path)


def test_an_imu_without_a_documented_scale(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the IMU 64 has no scale that is documented"):
        novatel.read(written(tmp_path / "span.log", raw_imu(64, SAMPLE)))


def test_corrected_logs_are_not_read(tmp_path: Path) -> None:
    fields = f"{WEEK},{SECONDS},-0.000001643,0.000005388,-0.000007718,-0.000133894,-0.001313174,-0.000272190"
    with pytest.raises(
        InputError, match="CORRIMU logs are left out, gravity is taken out of them: log RAWIMUSXA"
    ):
        novatel.read(written(tmp_path / "span.log", short("CORRIMUDATAS", fields)))
    beside = novatel.read(written(tmp_path / "span.log", short("CORRIMUDATAS", fields), best_position()))
    assert beside.imu is None
    [remark] = beside.remarks
    assert "gravity is taken out" in remark


def test_position_and_velocity_of_one_time_are_one_fix(tmp_path: Path) -> None:
    contents = novatel.read(written(tmp_path / "span.log", best_position(), best_velocity()))
    assert contents.gnss is not None
    fix = contents.gnss
    np.testing.assert_array_equal(fix.time, [SECONDS])
    np.testing.assert_allclose(fix.position[0], [np.radians(51.5), np.radians(-114.25), 1047.25], rtol=1e-15)
    course = np.radians(210)
    np.testing.assert_allclose(fix.velocity[0], [10 * np.sin(course), 10 * np.cos(course), 0.25], rtol=1e-15)
    np.testing.assert_array_equal(fix.position_sigma[0], [0.01, 0.02, 0.03])
    np.testing.assert_array_equal(fix.velocity_sigma[0], [0, 0, 0])


def test_a_velocity_is_as_old_as_its_latency(tmp_path: Path) -> None:
    fix = novatel.read(written(tmp_path / "span.log", best_position(), best_velocity(0.25))).gnss
    assert fix is not None
    np.testing.assert_array_equal(fix.time, [SECONDS - 0.25, SECONDS])
    np.testing.assert_array_equal(np.isnan(fix.position[:, 0]), [True, False])
    np.testing.assert_array_equal(np.isnan(fix.velocity[:, 0]), [False, True])


def test_the_inertial_solution_is_no_fix(tmp_path: Path) -> None:
    """With an IMU, BESTPOS becomes the solution that it aids; BESTGNSSPOS remains that of the satellites."""
    mixed = [
        best_position("INS_RTKFIXED"),
        best_velocity(kind="INS_RTKFIXED"),
        best_position(status="COLD_START"),
    ]
    gnss = best_position("SINGLE", name="BESTGNSSPOS")
    fix = novatel.read(written(tmp_path / "span.log", *mixed, gnss, best_position())).gnss
    assert fix is not None
    assert len(fix.time) == 1
    with pytest.raises(InputError, match="no log has an IMU, a fix"):
        novatel.read(written(tmp_path / "span.log", *mixed))


def test_solutions(tmp_path: Path) -> None:
    place = "51.5,-114.25,{height},1.0,2.0,3.0,-0.5,0.25,158.5"
    plain = f"{WEEK},{SECONDS:.9f},{place.format(height=1080.5)},INS_SOLUTION_GOOD"
    extended = f"INS_SOLUTION_GOOD,INS_PPP,{place.format(height='1097.5,-17.0')},0.1,0.1,0.1"
    waiting = plain.replace("INS_SOLUTION_GOOD", "INS_ALIGNING")
    logs = [
        log("INSPVA", plain),
        short("INSPVAS", plain.replace(f"{SECONDS:.9f}", f"{SECONDS + 1:.9f}")),
        log("INSPVAX", extended, SECONDS + 2),
        log("INSPVA", waiting.replace(f"{SECONDS:.9f}", f"{SECONDS + 3:.9f}")),
    ]
    truth = novatel.read(written(tmp_path / "span.log", *logs)).reference
    assert truth is not None
    np.testing.assert_array_equal(truth.time, SECONDS + np.arange(3))
    np.testing.assert_array_equal(truth.position[:, 2], 1080.5)
    np.testing.assert_array_equal(truth.velocity, np.tile([2.0, 1.0, 3.0], (3, 1)))
    np.testing.assert_allclose(np.degrees(truth.attitude), np.tile([-0.5, 0.25, 158.5], (3, 1)), rtol=1e-14)


def test_before_the_week_is_known(tmp_path: Path) -> None:
    early = log("INSPVA", "0,5.0,0,0,0,0,0,0,0,0,0,INS_SOLUTION_GOOD", seconds=5.0, week=0)
    with pytest.raises(InputError, match="no log has"):
        novatel.read(written(tmp_path / "span.log", early))


def test_prompts_and_other_lines_are_passed_over(tmp_path: Path) -> None:
    path = written(tmp_path / "span.log", "<OK", "[COM1]" + best_position(), "$GPGGA,1*00", "#TIMEA,x", "")
    assert novatel.read(path).gnss is not None


def test_the_last_log_may_be_cut_short_but_no_other(tmp_path: Path) -> None:
    path = tmp_path / "span.log"
    path.write_text(f"{best_position()}\r\n{best_velocity()[:-9]}")
    assert novatel.read(path).gnss is not None
    path.write_text(f"{best_position()[:-9]}\r\n{best_velocity()}\r\n")
    with pytest.raises(InputError, match=r"span.log: line 1: the log BESTPOS is damaged: it does not end"):
        novatel.read(path)


def test_a_wrong_check_sum(tmp_path: Path) -> None:
    path = written(tmp_path / "span.log", best_position(), best_velocity().replace("210.0", "211.0"))
    with pytest.raises(InputError, match=r"span.log: line 2: the log BESTVEL is damaged: its check sum"):
        novatel.read(path)


def test_samples_have_their_lines(tmp_path: Path) -> None:
    path = written(
        tmp_path / "span.log", raw_imu(8, SAMPLE), best_position(), raw_imu(8, SAMPLE, SECONDS + 1)
    )
    contents = novatel.read(path)
    assert contents.place("imu", 1) == "line 3"
    assert contents.place("gnss", 0) == "row 1 of its gnss table"


def test_a_new_week(tmp_path: Path) -> None:
    place = "0,0,0,0,0,0,0,0,0,INS_SOLUTION_GOOD"
    last = log("INSPVA", f"{WEEK},604799.0,{place}", 604799.0)
    path = written(tmp_path / "span.log", last, log("INSPVA", f"{WEEK + 1},0.0,{place}", 0.0, WEEK + 1))
    contents = novatel.read(path)
    assert contents.reference is not None
    assert contents.epoch == WEEK * 604800
    np.testing.assert_array_equal(contents.reference.time, [604799, 604800])


def test_recognised(tmp_path: Path) -> None:
    assert novatel.recognises(written(tmp_path / "a", "noise", best_position()))
    assert not novatel.recognises(written(tmp_path / "b", "#FAKELOGA,COM1;0*00000000", "# comment"))
    assert not novatel.recognises(tmp_path / "there is none")


def test_damaged_files(tmp_path: Path) -> None:
    lines = [best_position(), best_velocity(), *(raw_imu(8, SAMPLE, SECONDS + k) for k in range(10))]
    assert len(refusals(novatel.read, written(tmp_path / "span.log", *lines))) > 50
