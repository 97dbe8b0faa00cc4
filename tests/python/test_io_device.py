"""The example of the crate `canopen`: a device that is no drive, as its user would build it."""

import canopen
import pytest

from conftest import ROOT
from frames import Frames
from server import Slcan, free_port

EDS = ROOT / "firmware" / "canopen" / "examples" / "io_device" / "io-device.eds"

#: What the example calls itself.
NODE_ID = 5

#: The inputs and the voltage, as they are mapped at power-on.
INPUTS, VOLTAGE = 0x180 + NODE_ID, 0x280 + NODE_ID

pytestmark = pytest.mark.only("virtual")


@pytest.fixture
def io_device(pytestconfig):
    """The program. It runs until it is ended, and keeps nothing."""
    port = free_port()
    bus = Slcan([pytestconfig.getoption("--io-device"), f"127.0.0.1:{port}"], port)
    bus.server.wait_until_ready()
    yield bus
    is_running = bus.server.process.poll() is None
    bus.server.kill()
    assert is_running, bus.server.words()


@pytest.fixture
def network(io_device, connect):
    return connect(io_device)


@pytest.fixture
def device(network):
    return network.add_node(canopen.RemoteNode(NODE_ID, str(EDS)))


def test_it_tells_who_it_is(device):
    assert device.sdo[0x1000].raw == 0x70191
    assert [device.sdo[0x1018][sub].raw for sub in range(5)] == [4, 0, 0x401, 0x10000, 1]


def test_heartbeats_tell_its_state(network, device):
    heartbeats = Frames(network, 0x700 + NODE_ID)
    device.sdo[0x1017].raw = 50
    assert heartbeats.until(lambda data: data == b"\x7f")
    device.nmt.state = "OPERATIONAL"
    heartbeats.until(lambda data: data == b"\x05")


def test_inputs_are_sent_when_they_change(network, device):
    inputs = Frames(network, INPUTS)
    device.nmt.state = "OPERATIONAL"
    assert inputs.next() == b"\x00"
    device.sdo[0x6200][1].raw = 0xA5
    assert inputs.next() == b"\xa5"
    assert inputs.none()


def test_outputs_are_set_by_a_pdo(network, device):
    inputs = Frames(network, INPUTS)
    device.nmt.state = "OPERATIONAL"
    inputs.next()
    network.send_message(0x200 + NODE_ID, b"\x81")
    assert inputs.next() == b"\x81"
    assert device.sdo[0x6200][1].raw == 0x81


def test_the_voltage_is_sent_at_each_sync(network, device):
    voltage = Frames(network, VOLTAGE)
    device.sdo[0x6200][1].raw = 0b111
    device.nmt.state = "OPERATIONAL"
    assert voltage.none(), "there was no SYNC"
    for _ in range(3):
        network.sync.transmit()
        assert voltage.next() == (3000).to_bytes(2, "little")
    assert voltage.none(), "once for each SYNC"


def test_another_mapping_is_taken(network, device):
    device.tpdo.read()
    pdo = device.tpdo[2]
    pdo.clear()
    pdo.add_variable(0x6401, 1)
    pdo.add_variable(0x6000, 1)
    pdo.save()
    device.sdo[0x6200][1].raw = 0b11
    voltage = Frames(network, VOLTAGE)
    device.nmt.state = "OPERATIONAL"
    network.sync.transmit()
    assert voltage.next() == (2000).to_bytes(2, "little") + b"\x03"


def test_a_reset_ends_with_a_boot_up_and_the_defaults(network, device):
    boot_up = Frames(network, 0x700 + NODE_ID)
    device.sdo[0x6200][1].raw = 0xFF
    device.nmt.state = "RESET"
    boot_up.until(lambda data: data == b"\x00")
    assert device.sdo[0x6200][1].raw == 0
