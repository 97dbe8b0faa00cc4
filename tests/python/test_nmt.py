"""Network management: boot-up, states and heartbeats."""

import time

import pytest
from canopen.sdo import SdoCommunicationError

from conftest import NODE_ID
from frames import SILENCE, Frames, wait_until

BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = b"\x00", b"\x04", b"\x05", b"\x7f"


@pytest.fixture
def error_control(network, node):
    return Frames(network, 0x700 + NODE_ID)


@pytest.mark.everywhere
@pytest.mark.parametrize("command", ["RESET", "RESET COMMUNICATION"])
def test_a_reset_ends_with_a_boot_up(node, error_control, command):
    node.nmt.state = command
    assert error_control.next() == BOOT_UP
    assert node.sdo[0x1000].raw == 0x40192


def test_a_reset_restores_the_defaults(node, error_control):
    node.sdo[0x6083].raw = 4321
    node.sdo[0x1017].raw = 500
    node.nmt.state = "RESET"
    error_control.until(lambda frame: frame == BOOT_UP)
    assert node.sdo[0x6083].raw == node.object_dictionary[0x6083].default
    assert node.sdo[0x1017].raw == 0


def test_heartbeats_tell_the_state(node, error_control):
    node.sdo[0x1017].raw = 50
    error_control.until(lambda frame: frame == PRE_OPERATIONAL)
    for command, state in [
        ("OPERATIONAL", OPERATIONAL),
        ("STOPPED", STOPPED),
        ("PRE-OPERATIONAL", PRE_OPERATIONAL),
    ]:
        node.nmt.state = command
        error_control.until(lambda frame: frame == state)


@pytest.mark.everywhere
def test_heartbeats_keep_their_period(node, error_control):
    period, count = 0.05, 40
    node.sdo[0x1017].raw = int(period * 1000)
    error_control.next()
    started = time.monotonic()
    for _ in range(count):
        assert error_control.next() == PRE_OPERATIONAL
    # A busy machine may be late with some of them, but never early with all.
    assert time.monotonic() - started > 0.8 * count * period


def test_no_heartbeat_unless_it_is_asked_for(node, error_control):
    assert error_control.none()


def test_a_stopped_node_serves_no_sdo(node):
    node.nmt.state = "STOPPED"
    node.sdo.RESPONSE_TIMEOUT = SILENCE
    with pytest.raises(SdoCommunicationError):
        node.sdo.upload(0x1000, 0)
    node.nmt.state = "PRE-OPERATIONAL"

    def serves():
        try:
            return node.sdo[0x1000].raw == 0x40192
        except SdoCommunicationError:
            return False

    wait_until(serves, "SDO in Pre-operational")
