"""u-blox messages, packed here by the interface description, come back as they were."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from damage import refusals
from written.ubx import WEEK, frame, precise, pvt, written

from sim_scenarios.errors import InputError
from sim_scenarios.recordings.readers import ubx
from sim_scenarios.recordings.readers.contents import Clock

pytest.importorskip("pyubx2", reason="reading UBX needs pyubx2")


def relative(tow: int, flags: int = 0x135, version: int = 1) -> bytes:
    """NAV-RELPOSNED: heading 210.12345 deg, 0.25 deg."""
    payload = struct.pack(
        "<BBHI5i4s4b5I4sI",
        version,
        0,
        0,
        tow,
        1,
        2,
        3,
        100,
        21012345,
        b"",
        0,
        0,
        0,
        0,
        1,
        1,
        1,
        1,
        25000,
        b"",
        flags,
    )
    assert len(payload) == 64
    return frame(0x3C, payload)


def test_an_epoch_is_one_fix(tmp_path: Path) -> None:
    contents = ubx.read(written(tmp_path / "log.ubx", pvt(302400250, nano=250_000_000), relative(302400250)))
    assert contents.clock is Clock.GPS
    assert contents.epoch == WEEK * 604800
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    fix = contents.gnss
    np.testing.assert_array_equal(fix.time, [302400.25])
    expected = [np.radians(-33.5123456), np.radians(151.2543210), -18.155]
    np.testing.assert_allclose(fix.position[0], expected, rtol=1e-14)
    np.testing.assert_allclose(fix.velocity[0], [5.0, -8.66, 0.25], rtol=1e-15)
    np.testing.assert_allclose(fix.position_sigma[0], [0.014, 0.014, 0.023], rtol=1e-15)
    np.testing.assert_allclose(fix.velocity_sigma[0], [0.045] * 3, rtol=1e-15)
    np.testing.assert_array_equal(contents.heading_aid.time, fix.time)
    assert np.degrees(contents.heading_aid.heading[0]) == pytest.approx(210.12345, rel=1e-14)
    assert np.degrees(contents.heading_aid.sigma[0]) == pytest.approx(0.25, rel=1e-14)


@pytest.mark.parametrize("nano", [-361_875, 0, 333_219])
def test_time_to_the_nanosecond(tmp_path: Path, nano: int) -> None:
    """Receivers solve a fraction of a millisecond beside the round one: their UTC says what iTOW rounds."""
    fix = ubx.read(written(tmp_path / "log.ubx", pvt(302400000, nano=nano), precise(302400000))).gnss
    assert fix is not None
    np.testing.assert_allclose(fix.time, [302400 + nano * 1e-9], atol=1e-10, rtol=0)
    rough = ubx.read(written(tmp_path / "log.ubx", pvt(302400000, nano=nano, valid=3))).gnss
    assert rough is not None
    np.testing.assert_array_equal(rough.time, [302400])


def test_the_precise_position_wins_wherever_it_stands(tmp_path: Path) -> None:
    for frames in ([pvt(1000), precise(1000)], [precise(1000), pvt(1000)]):
        fix = ubx.read(written(tmp_path / "log.ubx", *frames)).gnss
        assert fix is not None
        assert len(fix.time) == 1
        expected = [-33.512345641, 151.254321037]
        np.testing.assert_allclose(np.degrees(fix.position[0, :2]), expected, rtol=0, atol=1e-11)
        assert fix.position[0, 2] == pytest.approx(-18.1544, abs=1e-9)
        np.testing.assert_allclose(fix.position_sigma[0], [0.0121, 0.0121, 0.0199], rtol=1e-12)
        assert not np.isnan(fix.velocity).any()


def test_a_new_week_and_a_leap_second(tmp_path: Path) -> None:
    log = written(
        tmp_path / "log.ubx", pvt(604799000), pvt(0, WEEK + 1), pvt(1000, WEEK + 1, second=60), relative(2000)
    )
    contents = ubx.read(log)
    assert contents.gnss is not None
    assert contents.heading_aid is not None
    np.testing.assert_array_equal(contents.gnss.time - 604800, [-1, 0, 1])
    np.testing.assert_array_equal(contents.heading_aid.time - 604800, [2])


def test_the_week_reaches_back_to_what_came_before_the_date(tmp_path: Path) -> None:
    frames = [pvt(604799000, valid=0), pvt(0, WEEK + 1, valid=0), pvt(1000, WEEK + 1)]
    contents = ubx.read(written(tmp_path / "log.ubx", *frames))
    assert contents.gnss is not None
    assert contents.epoch == WEEK * 604800
    np.testing.assert_array_equal(contents.gnss.time - 604800, [-1, 0, 1])


def test_without_a_date(tmp_path: Path) -> None:
    contents = ubx.read(written(tmp_path / "log.ubx", pvt(216697000, valid=0)))
    assert contents.clock is Clock.OWN
    assert contents.gnss is not None
    np.testing.assert_array_equal(contents.gnss.time, [216697])


def test_what_is_no_fix(tmp_path: Path) -> None:
    none = [
        pvt(1000, fix=0),
        pvt(2000, fix=1),  # dead reckoning alone
        pvt(3000, fix=5),  # time alone
        pvt(4000, flags=0),
        relative(5000, flags=0x115),  # from a base that stands
        relative(6000, flags=0x35),  # no heading
        relative(7000, version=0),
    ]
    path = written(tmp_path / "log.ubx", *none)
    with pytest.raises(InputError, match="no NAV-PVT has a fix and no NAV-RELPOSNED a heading"):
        ubx.read(path)
    fix = ubx.read(written(path, *none, pvt(8000, fix=2), pvt(9000, fix=4))).gnss
    assert fix is not None
    np.testing.assert_array_equal(fix.time % 604800, [8, 9])
    np.testing.assert_array_equal(np.isnan(fix.position[:, 2]), [True, False])  # the first is flat


def test_a_precise_position_counts_where_there_is_a_spatial_fix(tmp_path: Path) -> None:
    """NAV-HPPOSLLH itself says neither that the fix is good nor of which type it is."""
    epochs = [pvt(1000, flags=0), pvt(2000, fix=1), pvt(3000, fix=2), pvt(4000), pvt(5000)]
    positions = [*(precise(tow) for tow in (1000, 2000, 3000, 4000)), precise(5000, invalid=1), precise(6000)]
    fix = ubx.read(written(tmp_path / "log.ubx", *epochs, *positions)).gnss
    assert fix is not None
    np.testing.assert_array_equal(fix.time % 604800, [3, 4, 5])
    np.testing.assert_array_equal(np.isnan(fix.position[:, 2]), [True, False, False])
    np.testing.assert_allclose(fix.position_sigma[:, 0], [0.014, 0.0121, 0.014], rtol=1e-12)


@pytest.mark.parametrize("number", [2, 3])
def test_sensors_are_left_out_and_said_so(tmp_path: Path, number: int) -> None:
    sensor = frame(number, bytes(16), kind=0x10)
    [remark] = ubx.read(written(tmp_path / "log.ubx", pvt(1000), sensor)).remarks
    assert "log.ubx: ESF-RAW and ESF-MEAS are left out" in remark
    with pytest.raises(InputError, match="ESF-RAW and ESF-MEAS are not read"):
        ubx.read(written(tmp_path / "log.ubx", sensor))


def test_other_messages_in_between(tmp_path: Path) -> None:
    """Receivers mix NMEA, RTCM and what they are asked for; a sync pattern can stand in a payload."""
    log = written(
        tmp_path / "log.ubx",
        b"$GNGGA,,,,*00\r\n",
        frame(0x35, b"\x00" * 8 + b"\xb5b\x01\x07\x5c\x00" + b"\x00" * 30),
        pvt(1000),
        b"\xd3\x00\x13\xb5b\x01",
        frame(0x10, b"\x01\x02", kind=0x10),
        pvt(2000),
    )
    fix = ubx.read(log).gnss
    assert fix is not None
    np.testing.assert_array_equal(fix.time % 604800, [1, 2])


def test_the_last_message_may_be_cut_short_but_no_other_damaged(tmp_path: Path) -> None:
    path = written(tmp_path / "log.ubx", pvt(1000), pvt(2000)[:50])
    fix = ubx.read(path).gnss
    assert fix is not None
    assert len(fix.time) == 1
    broken = bytearray(pvt(2000))
    broken[30] ^= 1
    written(path, pvt(1000), bytes(broken), pvt(3000))
    with pytest.raises(InputError, match=r"log.ubx: byte 100: the message NAV-PVT is damaged: its check sum"):
        ubx.read(path)
    written(path, frame(0x07, b"\x00" * 84))
    with pytest.raises(InputError, match=r"log.ubx: byte 0: the message NAV-PVT is damaged: it has 84 bytes"):
        ubx.read(path)


def test_recognised(tmp_path: Path) -> None:
    assert ubx.recognises(written(tmp_path / "a", b"noise", pvt(1000)))
    assert ubx.recognises(written(tmp_path / "b", frame(0x02, b"\x00" * 10, kind=0x10)))
    assert not ubx.recognises(written(tmp_path / "c", b"$GNGGA", frame(0x02, b"\x00" * 10, kind=0x10)))
    assert not ubx.recognises(written(tmp_path / "d", pvt(1000)[:99]))
    assert not ubx.recognises(tmp_path / "there is none")


def test_damaged_files(tmp_path: Path) -> None:
    frames = [part for k in range(5) for part in (pvt(1000 * k), precise(1000 * k), relative(1000 * k))]
    assert len(refusals(ubx.read, written(tmp_path / "log.ubx", *frames))) > 50
