"""NMEA sentences, written here by the standard, come back as they were."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from written.nmea import gga, place, rmc, sentence, written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import nmea
from sim_scenarios.recordings.readers.contents import Clock

KNOT = 1852 / 3600  # m/s
MIDNIGHT = datetime(2025, 3, 1, tzinfo=timezone.utc).timestamp()
START = 86398.0


def test_an_epoch_is_one_fix(tmp_path: Path) -> None:
    log = written(
        tmp_path / "log.nmea",
        rmc("235958.25", "010325"),
        gga("235958.25", -33.5123456789, 151.2543210987),
        sentence("GPGST,235958.25,1.1,0.9,0.8,45.0,0.021,0.034,0.055"),
        sentence("HEHDT,271.25,T"),
    )
    contents = nmea.read(log)
    assert contents.clock is Clock.UNIX
    assert contents.epoch == MIDNIGHT
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    fix = contents.gnss
    np.testing.assert_array_equal(fix.time, [START + 0.25])
    resolution = np.radians(1e-7 / 60)
    np.testing.assert_allclose(
        fix.position[0, :2], np.radians([-33.5123456789, 151.2543210987]), atol=resolution
    )
    assert fix.position[0, 2] == pytest.approx(12.345 - 30.5, abs=1e-12)
    course = np.radians(210)
    expected = [10 * KNOT * np.sin(course), 10 * KNOT * np.cos(course), np.nan]
    np.testing.assert_allclose(fix.velocity[0], expected, rtol=1e-12)
    np.testing.assert_array_equal(fix.position_sigma, [[0.034, 0.021, 0.055]])
    np.testing.assert_array_equal(fix.velocity_sigma, [[0.0, 0.0, 0.0]])
    np.testing.assert_array_equal(contents.heading_aid.time, fix.time)
    assert contents.heading_aid.heading[0] == pytest.approx(np.radians(271.25), rel=1e-15)


@pytest.mark.parametrize("dated_first", [True, False])
def test_midnight(tmp_path: Path, dated_first: bool) -> None:
    lines = []
    for second, time in enumerate(("235958.00", "235959.00", "000000.00", "000001.00")):
        pair = [rmc(time, "010325" if second < 2 else "020325"), gga(time, 10 + second, 20)]
        lines += pair if dated_first else pair[::-1]
    contents = nmea.read(written(tmp_path / "log.nmea", *lines))
    fixes = contents.gnss
    assert contents.epoch == MIDNIGHT
    assert fixes is not None
    np.testing.assert_array_equal(fixes.time, START + np.arange(4))
    np.testing.assert_allclose(np.degrees(fixes.position[:, 0]), [10, 11, 12, 13], atol=1e-9)


def test_without_a_date_seconds_go_on_past_midnight(tmp_path: Path) -> None:
    lines = [gga(time, 10, 20) for time in ("235959.50", "000000.50", "000001.50")]
    contents = nmea.read(written(tmp_path / "log.nmea", *lines))
    assert contents.clock is Clock.OWN
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.time, 86399.5 + np.arange(3))


def test_days_without_a_sentence(tmp_path: Path) -> None:
    lines = [rmc("235958.00", "010325"), rmc("120000.00", "050325")]
    fixes = nmea.read(written(tmp_path / "log.nmea", *lines)).gnss
    assert fixes is not None
    np.testing.assert_array_equal(fixes.time, [START, START + 2 + 3.5 * 86400])


def test_zda_dates_too(tmp_path: Path) -> None:
    lines = [sentence("GPZDA,235958.00,01,03,2025,00,00"), gga("235958.00", 10, 20)]
    contents = nmea.read(written(tmp_path / "log.nmea", *lines))
    assert contents.epoch == MIDNIGHT
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.time, [START])


def test_position_of_rmc_only_where_there_is_no_gga(tmp_path: Path) -> None:
    alone = nmea.read(written(tmp_path / "a.nmea", rmc("120000.00", "010325"))).gnss
    both = nmea.read(written(tmp_path / "b.nmea", gga("120000.00", 1, 2), rmc("120000.00", "010325"))).gnss
    assert alone is not None
    assert both is not None
    np.testing.assert_allclose(np.degrees(alone.position[0]), [-33.5, 151.25, np.nan], atol=1e-9)
    np.testing.assert_allclose(np.degrees(both.position[0, :2]), [1, 2], atol=1e-9)


def test_what_is_not_said_is_not_measured(tmp_path: Path) -> None:
    log = written(
        tmp_path / "log.nmea",
        sentence("GPGGA,120000.00,,,,,0,00,99.9,,M,,M,,"),  # no fix
        rmc("120001.00", "010325", status="V"),
        gga("120002.00", 10, 20, altitude="5.0", geoid=""),  # height above what is not said
        rmc("120003.00", "010325", speed="0.05", course=""),  # u-blox when it hardly moves
        gga("120003.00", 10, 20),
    )
    fixes = nmea.read(log).gnss
    assert fixes is not None
    np.testing.assert_array_equal(fixes.time % 60, [2, 3])
    np.testing.assert_array_equal(np.isnan(fixes.position[:, 2]), [True, False])
    assert np.isnan(fixes.velocity).all()


def test_dead_reckoning_is_no_fix(tmp_path: Path) -> None:
    body = f"GPGGA,120000.00,{place(1, 2)},6,00,99.9,5.0,M,1.0,M,,"
    with pytest.raises(InputError, match="no sentence has a fix or a heading"):
        nmea.read(written(tmp_path / "log.nmea", sentence(body)))


def test_vtg_in_the_place_of_rmc_and_ths_of_hdt(tmp_path: Path) -> None:
    log = written(
        tmp_path / "log.nmea",
        gga("120000.00", 10, 20),
        sentence("GPVTG,90.0,T,,M,19.438,N,36.000,K,D"),
        sentence("GPTHS,123.4,A"),
        sentence("GPTHS,99.9,V"),
    )
    contents = nmea.read(log)
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    np.testing.assert_allclose(contents.gnss.velocity[0], [10, 0, np.nan], atol=1e-12)
    np.testing.assert_allclose(contents.heading_aid.heading, np.radians([123.4]))


def test_sentences_behind_a_logger_s_own_stamp_and_between_bytes(tmp_path: Path) -> None:
    """Ships' loggers put their own stamp in front; serial lines carry binary messages in between."""
    log = tmp_path / "log.nmea"
    stamped = f"ins_seapath  2014-12-11T22:09:32.5563Z  {gga('120000.00', 10, 20)}\r\n"
    log.write_bytes(b"\xb5b\x01\x07\x00$\x99\n" + stamped.encode() + b"\xd3\x00\x13$GN\x80\n")
    fixes = nmea.read(log).gnss
    assert fixes is not None
    assert len(fixes.time) == 1


def test_the_last_sentence_may_be_cut_short_but_no_other(tmp_path: Path) -> None:
    first, last = gga("120000.00", 10, 20), gga("120001.00", 10, 20)
    log = tmp_path / "log.nmea"
    log.write_text(f"{first}\r\n{last[:40]}")
    fixes = nmea.read(log).gnss
    assert fixes is not None
    assert len(fixes.time) == 1
    log.write_text(f"{first}\r\n{last[:40]}\r\n{last}\r\n")
    with pytest.raises(InputError, match=r"log.nmea: line 2: '\$GPGGA,120001.*is damaged"):
        nmea.read(log)


def test_a_wrong_check_sum_is_refused_with_its_line(tmp_path: Path) -> None:
    wrong = gga("120001.00", 10, 20).replace("12.345", "12.346")
    log = written(tmp_path / "log.nmea", gga("120000.00", 10, 20), wrong)
    with pytest.raises(InputError, match=r"line 2: .*is damaged: its check sum does not fit"):
        nmea.read(log)


def test_a_number_that_is_none(tmp_path: Path) -> None:
    """Its check sum fits: it was written so."""
    log = written(tmp_path / "log.nmea", rmc("120000.00", "010325", speed="X.138"))
    with pytest.raises(InputError, match=r"line 1: .*is damaged: .*'X\.138'"):
        nmea.read(log)


def test_recognised(tmp_path: Path) -> None:
    assert nmea.recognises(written(tmp_path / "a", "garbage", gga("120000.00", 10, 20)))
    assert not nmea.recognises(written(tmp_path / "b", "$PUBX,00,1*00", "time,gyro"))
    assert not nmea.recognises(tmp_path / "there is none")
    assert not nmea.recognises(tmp_path)


def test_there_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"there is no recording .*none\.nmea"):
        nmea.read(tmp_path / "none.nmea")


def test_damaged_files(tmp_path: Path) -> None:
    lines = []
    for second in range(10):
        time = f"1200{second:02d}.00"
        lines += [rmc(time, "010325"), gga(time, 10, 20), sentence("GPHDT,90.0,T")]
    assert len(refusals(nmea.read, written(tmp_path / "log.nmea", *lines))) > 50
