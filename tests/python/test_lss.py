"""Layer setting services (CiA 305): finding an unconfigured drive and giving it a node-ID."""

import pytest
from canopen.lss import (
    CS_INQUIRE_PRODUCT_CODE,
    CS_INQUIRE_REVISION_NUMBER,
    CS_INQUIRE_SERIAL_NUMBER,
    CS_INQUIRE_VENDOR_ID,
    LssError,
)

from conftest import EDS, NODE_ID, give_node_id
from frames import SILENCE, Frames

INQUIRIES = [CS_INQUIRE_VENDOR_ID, CS_INQUIRE_PRODUCT_CODE, CS_INQUIRE_REVISION_NUMBER, CS_INQUIRE_SERIAL_NUMBER]

#: The node-ID of a node that has none.
UNCONFIGURED = 255


@pytest.fixture
def lss(network):
    return network.lss


def identity(lss):
    """The four words of the identity, by inquiry."""
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    words = [lss.inquire_lss_address(inquiry) for inquiry in INQUIRIES]
    lss.send_switch_state_global(lss.WAITING_STATE)
    return words


@pytest.mark.everywhere
def test_fastscan_finds_the_unconfigured_drive(lss):
    expected = identity(lss)
    # Every bit that is 1 costs one time-out, and an answer that comes late spoils the scan.
    lss.RESPONSE_TIMEOUT = 2
    found, words = lss.fast_scan()
    assert found
    assert words == expected
    assert words[:3] == [0, 0x402, 0x10000]
    # The drive that was found is in the configuration state.
    lss.RESPONSE_TIMEOUT = 3
    assert lss.inquire_node_id() == UNCONFIGURED


class TwoAnswer:
    """python-canopen goes on at the first answer, and takes a second drive's late one for that to its next question. So
    the next question waits for an answer of each drive, or for a while where not all of them have one."""

    def __init__(self, network, monkeypatch):
        self.answers = Frames(network, network.lss.LSS_RX_COBID)
        self.drives = 0
        self.lss = network.lss
        send = network.send_message

        def send_later(cob_id, *message, **options):
            if cob_id == self.lss.LSS_TX_COBID:
                self.await_the_others()
            return send(cob_id, *message, **options)

        monkeypatch.setattr(network, "send_message", send_later)

    def await_the_others(self):
        # Nobody has answered: the time-out has passed, and nobody will.
        if self.answers.none(0):
            return
        for _ in range(self.drives - 1):
            self.answers.none(1)
        self.lss.responses.queue.clear()


@pytest.mark.only("socketcan")
def test_fastscan_finds_two_drives_in_turn(start, connect, monkeypatch):
    # Each bit that is 1 costs a time-out, so there are few; and time enough for two drives to answer on a busy machine.
    serials = (0x10000, 0x10001)
    network = connect([start(arguments=["--serial", serial]) for serial in serials][0])
    network.lss.RESPONSE_TIMEOUT = 4
    scan = TwoAnswer(network, monkeypatch)
    for node_id, serial in enumerate(serials, start=1):
        scan.drives = len(serials) + 1 - node_id
        boot_up = Frames(network, 0x700 + node_id)
        assert network.lss.fast_scan() == (True, [0, 0x402, 0x10000, serial])
        network.lss.configure_node_id(node_id)
        network.lss.send_switch_state_global(network.lss.WAITING_STATE)
        assert boot_up.next() == b"\x00"
        assert network.add_node(node_id, str(EDS)).sdo[0x1018][4].raw == serial
    assert network.lss.fast_scan() == (False, None)


def test_fastscan_does_not_find_a_configured_drive(network, lss):
    give_node_id(network)
    lss.RESPONSE_TIMEOUT = SILENCE
    assert lss.fast_scan() == (False, None)


@pytest.mark.everywhere
def test_the_drive_with_the_address_is_selected(lss):
    vendor, product, revision, serial = identity(lss)
    assert lss.send_switch_state_selective(vendor, product, revision, serial)
    assert lss.inquire_node_id() == UNCONFIGURED


@pytest.mark.everywhere
def test_a_drive_with_another_address_is_not_selected(lss):
    vendor, product, revision, serial = identity(lss)
    lss.RESPONSE_TIMEOUT = SILENCE
    with pytest.raises(LssError):
        lss.send_switch_state_selective(vendor, product, revision, serial ^ 1)
    with pytest.raises(LssError):
        lss.inquire_node_id()


@pytest.mark.everywhere
def test_an_unconfigured_drive_is_silent_but_for_lss(network, lss):
    others = [Frames(network, cob_id) for cob_id in range(0x800) if cob_id != lss.LSS_RX_COBID]
    network.nmt.send_command(129)  # reset node
    network.nmt.send_command(1)  # start
    for node_id in (1, NODE_ID, 127):
        network.send_message(0x600 + node_id, bytes.fromhex("40 00 10 00 00 00 00 00"))
    network.sync.transmit()
    assert others[0].none()
    assert all(frames.queue.empty() for frames in others)
    # It is there all the same.
    assert identity(lss)[1] == 0x402


@pytest.mark.parametrize("node_id", [0, 128, 254])
def test_a_node_id_that_is_none_is_refused(lss, node_id):
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    with pytest.raises(LssError, match="LSS Error: 1"):
        lss.configure_node_id(node_id)
    assert lss.inquire_node_id() == UNCONFIGURED


def test_a_reserved_bit_timing_is_refused(lss):
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    with pytest.raises(LssError, match="LSS Error: 1"):
        lss.configure_bit_timing(5)


@pytest.mark.everywhere
def test_a_new_node_id_is_used_after_reset_communication(network, lss):
    give_node_id(network)
    new = NODE_ID + 1
    boot_up = Frames(network, 0x700 + new)
    lss.send_switch_state_global(lss.CONFIGURATION_STATE)
    lss.configure_node_id(new)
    lss.send_switch_state_global(lss.WAITING_STATE)
    assert boot_up.none()
    network.nmt.send_command(130)  # reset communication
    assert boot_up.next() == b"\x00"
