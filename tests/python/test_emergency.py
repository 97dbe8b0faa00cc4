"""EMCY: an error that a master can provoke, its history, and its end."""

import time

import pytest

from conftest import NODE_ID
from frames import Frames

#: "PDO not processed due to length error", CiA 301.
LENGTH_ERROR = 0x8210

#: "Life guard error or heartbeat error", CiA 301.
HEARTBEAT_ERROR = 0x8130

#: Error register: generic error, communication error.
COMMUNICATION = 0x11


def test_a_short_rpdo_is_an_error_until_a_good_one_comes(network, node):
    emergencies = Frames(network, 0x80 + NODE_ID)
    node.nmt.state = "OPERATIONAL"
    network.send_message(0x200 + NODE_ID, b"\x06")
    frame = emergencies.next()
    assert int.from_bytes(frame[:2], "little") == LENGTH_ERROR
    assert frame[2] == COMMUNICATION
    assert node.sdo[0x1001].raw == COMMUNICATION
    assert node.sdo[0x1003][0].raw == 1
    assert node.sdo[0x1003][1].raw & 0xFFFF == LENGTH_ERROR

    # The same error again is no news.
    network.send_message(0x200 + NODE_ID, b"\x06")
    assert emergencies.none()

    network.send_message(0x200 + NODE_ID, b"\x06\x00")
    assert emergencies.next()[:3] == b"\x00\x00\x00"
    assert node.sdo[0x1001].raw == 0
    # The history stays until it is cleared.
    assert node.sdo[0x1003][0].raw == 1
    node.sdo[0x1003][0].raw = 0
    assert node.sdo[0x1003][0].raw == 0


def test_the_history_begins_with_the_newest_error(network, node):
    emergencies = Frames(network, 0x80 + NODE_ID)
    node.nmt.state = "OPERATIONAL"
    network.send_message(0x200 + NODE_ID, b"\x06")
    emergencies.next()
    # A heartbeat that stays away.
    node.sdo[0x1029][1].raw = 1
    node.sdo[0x1016][1].raw = 5 << 16 | 50
    network.send_message(0x705, b"\x05")
    assert int.from_bytes(emergencies.next()[:2], "little") == HEARTBEAT_ERROR
    assert node.sdo[0x1003][0].raw == 2
    assert [node.sdo[0x1003][number].raw & 0xFFFF for number in (1, 2)] == [HEARTBEAT_ERROR, LENGTH_ERROR]
    # One of two errors ends; the register shows the other.
    network.send_message(0x200 + NODE_ID, b"\x06\x00")
    assert emergencies.next()[2] == COMMUNICATION
    assert node.sdo[0x1001].raw == COMMUNICATION


@pytest.mark.everywhere
def test_the_inhibit_time_delays_errors_and_loses_none(network, node):
    inhibit = 0.5
    node.sdo[0x1015].raw = int(inhibit * 10_000)
    emergencies = Frames(network, 0x80 + NODE_ID)
    node.nmt.state = "OPERATIONAL"
    for _ in range(2):
        network.send_message(0x200 + NODE_ID, b"\x06")
        network.send_message(0x200 + NODE_ID, b"\x06\x00")
    codes, started = [], None
    for _ in range(4):
        codes.append(int.from_bytes(emergencies.next()[:2], "little"))
        started = started or time.monotonic()
    assert codes == [LENGTH_ERROR, 0] * 2
    assert time.monotonic() - started > 0.8 * 3 * inhibit


def test_python_canopen_follows_the_error(network, node):
    node.nmt.state = "OPERATIONAL"
    listener = Frames(network, 0x80 + NODE_ID)
    network.send_message(0x200 + NODE_ID, b"\x06")
    listener.next()
    assert [error.code for error in node.emcy.active] == [LENGTH_ERROR]
    network.send_message(0x200 + NODE_ID, b"\x06\x00")
    listener.next()
    assert node.emcy.active == []
