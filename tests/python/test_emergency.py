"""EMCY: an error that a master can provoke, its history, and its end."""

from conftest import NODE_ID
from frames import Frames

#: "PDO not processed due to length error", CiA 301.
LENGTH_ERROR = 0x8210

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


def test_python_canopen_follows_the_error(network, node):
    node.nmt.state = "OPERATIONAL"
    listener = Frames(network, 0x80 + NODE_ID)
    network.send_message(0x200 + NODE_ID, b"\x06")
    listener.next()
    assert [error.code for error in node.emcy.active] == [LENGTH_ERROR]
    network.send_message(0x200 + NODE_ID, b"\x06\x00")
    listener.next()
    assert node.emcy.active == []
