"""The device whose flash is measured, with what other open stacks have by default: in virtual time, on the simulated bus."""

import canopen
import pytest
from conformance import PROCEDURES, Device

from conftest import NODE_ID, ROOT, give_node_id
from frames import Frames, wait_until

EDS = ROOT / "tests" / "eds" / "basic-device.eds"

#: The number that makes it tell of an error.
ALARMING = 0xA1A1A1A1

pytestmark = [pytest.mark.own_limits, pytest.mark.only("virtual")]


@pytest.fixture
def network(start, connect):
    network = connect(start(arguments=["--basic-device"]))
    give_node_id(network)
    return network


@pytest.fixture
def device(network):
    return network.add_node(canopen.RemoteNode(NODE_ID, str(EDS)))


@pytest.mark.parametrize("procedure", PROCEDURES, ids=lambda procedure: procedure.__name__)
def test_the_device_is_what_its_data_sheet_says(network, procedure):
    procedure(Device(network, NODE_ID, EDS, sent=0x2005, received=0x2004))


def test_what_a_pdo_brings_comes_back(network, device):
    device.tpdo.read()
    device.rpdo.read()
    for pdo, variable in ((device.rpdo[1], 0x2004), (device.tpdo[1], 0x2006)):
        pdo.clear()
        pdo.add_variable(variable)
        pdo.trans_type = 255
        pdo.enabled = True
        pdo.save()
    sent = Frames(network, 0x180 + NODE_ID)
    device.nmt.state = "OPERATIONAL"
    assert sent.next() == bytes(4)
    device.rpdo[1][0x2004].raw = 0x12345678
    device.rpdo[1].transmit()
    assert sent.next() == bytes.fromhex("78563412")
    assert sent.none()


def told(device, count):
    """The last of so many emergency messages."""
    wait_until(lambda: len(device.emcy.log) == count, f"{count} emergency messages")
    return device.emcy.log[-1]


def test_an_error_is_told_and_its_end(device):
    device.sdo[0x2004].raw = ALARMING
    error = told(device, 1)
    assert (error.code, error.register) == (0x2310, 0x03)
    assert device.sdo[0x1001].raw == 0x03
    assert device.sdo[0x1003][1].raw == 0x2310
    device.sdo[0x2004].raw = 0
    end = told(device, 2)
    assert (end.code, end.register) == (0, 0)


def test_a_lost_master_is_told(network, device):
    device.sdo[0x1016][1].raw = 0x7F << 16 | 50
    network.send_message(0x77F, b"\x05")
    error = told(device, 1)
    assert (error.code, error.data[0]) == (0x8130, 0x7F)
    network.send_message(0x77F, b"\x05")
    assert told(device, 2).code == 0


def test_a_long_text_comes_in_segments(device):
    assert device.sdo[0x2001].raw == "ABCDEFGHIJKLMNOPQRSTUVWXYZ" * 2 + "ABCDEFGHIJKL"
    device.sdo[0x2001].raw = "abcdefghij" * 6
    assert device.sdo[0x2001].raw == "abcdefghij" * 6


def test_the_node_id_is_kept_until_power_off(network, device):
    boot_up = Frames(network, 0x700 + NODE_ID)
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.store_configuration()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    device.nmt.state = "RESET"
    boot_up.until(lambda data: data == b"\x00")
    assert device.sdo[0x1000].raw == 0
