"""Error control: the drive watches a heartbeat, and is guarded by a master that asks for its state."""

import can
import pytest

from conftest import NODE_ID
from frames import Frames

#: The node that the drive watches.
OTHER = 5

#: "Life guard error or heartbeat error", CiA 301.
NOBODY_THERE = 0x8130

PRE_OPERATIONAL, OPERATIONAL, TOGGLE = 0x7F, 0x05, 0x80

#: So much patience does the drive have, in milliseconds: a busy machine must not use it up between two frames.
PATIENCE = 2000


@pytest.fixture
def emergencies(network, node):
    return Frames(network, 0x80 + NODE_ID)


@pytest.fixture
def error_control(network, node):
    return Frames(network, 0x700 + NODE_ID)


def code(emergency):
    return int.from_bytes(emergency[:2], "little")


def beat(network):
    """A heartbeat of the other node, Operational."""
    network.send_message(0x700 + OTHER, [OPERATIONAL])


def guard(network):
    """The request of a guarding master."""
    network.bus.send(can.Message(arbitration_id=0x700 + NODE_ID, is_remote_frame=True, is_extended_id=False, dlc=1))


@pytest.mark.everywhere
def test_a_heartbeat_that_stays_away_is_an_error_until_it_returns(network, node, emergencies):
    node.sdo[0x1016][1].raw = OTHER << 16 | PATIENCE
    node.nmt.state = "OPERATIONAL"
    # The watch begins with the first one.
    assert emergencies.none()
    for _ in range(5):
        beat(network)
        assert emergencies.none()
    assert code(emergencies.next()) == NOBODY_THERE
    assert node.sdo[0x1001].raw == 0x11
    beat(network)
    assert code(emergencies.next()) == 0
    assert node.sdo[0x1001].raw == 0


@pytest.mark.everywhere
def test_a_lost_heartbeat_ends_operational(network, node, emergencies, error_control):
    node.sdo[0x1016][8].raw = OTHER << 16 | 100
    node.sdo[0x1017].raw = 50
    node.nmt.state = "OPERATIONAL"
    error_control.until(lambda frame: frame == bytes([OPERATIONAL]))
    beat(network)
    assert code(emergencies.next()) == NOBODY_THERE
    error_control.until(lambda frame: frame == bytes([PRE_OPERATIONAL]))


def test_the_drive_answers_a_guarding_master(network, node, error_control):
    for toggle in (0, TOGGLE, 0):
        guard(network)
        assert error_control.next() == bytes([PRE_OPERATIONAL | toggle])
    node.nmt.state = "OPERATIONAL"
    guard(network)
    assert error_control.next() == bytes([OPERATIONAL | TOGGLE])
    # It says nothing by itself.
    assert error_control.none()


# On SocketCAN python-canopen lets the kernel's broadcast manager ask, which the test's small kernel has not.
@pytest.mark.only("virtual", "firmware")
def test_python_canopen_guards_the_drive(node, error_control):
    node.nmt.start_node_guarding(0.05)
    answers = [error_control.next()[0] for _ in range(6)]
    node.nmt.stop_node_guarding()
    assert answers == [PRE_OPERATIONAL, PRE_OPERATIONAL | TOGGLE] * 3
    assert node.nmt.state == "PRE-OPERATIONAL"


@pytest.mark.everywhere
def test_a_guarding_master_that_stays_away_is_an_error_until_it_returns(network, node, emergencies, error_control):
    node.sdo[0x100C].raw = PATIENCE // 2
    node.sdo[0x100D].raw = 2
    # Nobody has asked yet, so nobody is missed.
    assert emergencies.none()
    for _ in range(3):
        guard(network)
        error_control.next()
        assert emergencies.none()
    assert code(emergencies.next()) == NOBODY_THERE
    assert node.sdo[0x1001].raw == 0x11
    guard(network)
    assert code(emergencies.next()) == 0
    assert node.sdo[0x1001].raw == 0


def test_a_drive_with_a_heartbeat_is_not_guarded(network, node, error_control):
    node.sdo[0x1017].raw = 10_000
    error_control.next()
    guard(network)
    assert error_control.none()
