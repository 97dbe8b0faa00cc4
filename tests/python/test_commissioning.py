"""Putting a drive into service with the script of the walk-through, power cuts included."""

import contextlib
import importlib.util
import random
import struct
import subprocess
import sys

import can
import pytest

from conftest import EDS, NODE_ID, ROOT
from frames import SILENCE, Frames
from server import Socketcan

SCRIPT = ROOT / "examples" / "commission.py"

#: The node-ID of a drive that has none.
UNCONFIGURED = 255


@pytest.fixture
def commission():
    """Runs the script on a bus."""

    def commission(bus, *arguments, code=0, timeout=170):
        if isinstance(bus, Socketcan):
            where = ["--interface", "socketcan", "--channel", bus.INTERFACE]
        else:
            where = ["--interface", "slcan", "--channel", f"socket://127.0.0.1:{bus.port}"]
        command = [sys.executable, SCRIPT, *where, "--patience", "3", *map(str, arguments)]
        run = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        assert run.returncode == code, (run.stdout, run.stderr)
        assert len(run.stderr.splitlines()) == (0 if code == 0 else 1), run.stderr
        return run.stdout + run.stderr

    return commission


@pytest.fixture
def restart(start, tmp_path):
    """Starts the drive with what it has stored; a drive that runs is stopped before."""
    running = []

    def restart(*arguments):
        if running:
            assert running.pop().server.stop() == 0
        running.append(start(tmp_path, arguments))
        return running[0]

    return restart


def node_id_by_lss(network):
    """What the drive says is its node-ID."""
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    node_id = network.lss.inquire_node_id()
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    return node_id


@pytest.mark.only("virtual", "firmware")
def test_node_id_and_bit_rate_come_back_after_a_power_cycle(restart, connect, commission, kind):
    said = commission(restart(), "--node-id", NODE_ID, "--new-bitrate", 500)
    assert "the drives use 500 kbit/s now" in said
    assert f"node {NODE_ID}: Axis402" in said
    bus = restart()
    network = connect(bus, 500_000)
    assert node_id_by_lss(network) == NODE_ID
    drive = network.add_node(NODE_ID, str(EDS))
    stored, number_of_500_kbit = 1, 2
    assert [drive.sdo["Node-ID and bit rate"][sub].raw for sub in range(1, 5)] == [NODE_ID, number_of_500_kbit, stored, stored]
    network.disconnect()
    # An adapter does not know at which rate the emulated serial line is; the virtual drive's does.
    if kind == "virtual":
        network = connect(bus)
        network.lss.RESPONSE_TIMEOUT = SILENCE
        with pytest.raises(Exception, match="No LSS response"):
            node_id_by_lss(network)


def test_a_drive_that_has_a_node_id_is_selected_by_its_address(restart, connect, commission):
    said = commission(restart(), "--node-id", NODE_ID)
    address = said.splitlines()[0].removeprefix("found ").split(", ")
    address = [f"0x{word.split()[1].rstrip('h')}" for word in address]
    assert "no drive without a node-ID" in commission(restart(), "--node-id", 1, code=1)
    commission(restart(), "--node-id", NODE_ID + 1, "--address", *address)
    bus = restart()
    address[3] = "0xFFFFFFFF"
    assert "no drive has the address" in commission(bus, "--node-id", 1, "--address", *address, code=1)
    assert node_id_by_lss(connect(bus)) == NODE_ID + 1


@pytest.mark.only("virtual", "firmware")
def test_the_only_drive_needs_no_address(restart, connect, commission):
    for node_id in (NODE_ID, 127):
        assert f"node {node_id}: Axis402" in commission(restart(), "--node-id", node_id, "--only")
    assert node_id_by_lss(connect(restart())) == 127


@pytest.mark.only("socketcan")
@pytest.mark.timeout(900)
def test_all_drives_are_numbered_and_get_a_bit_rate(start, tmp_path, connect, commission):
    serials = (7, 3)
    stores = [tmp_path / str(serial) for serial in serials]

    def start_all():
        for serial, store in zip(serials, stores):
            store.mkdir(exist_ok=True)
            yield start(store, ["--serial", serial])

    drives = list(start_all())
    # Where the machine is busy answers are late, and numbers are asked for anew.
    said = commission(drives[0], "--node-id", 5, "--all", "--new-bitrate", 250, timeout=850)
    assert "the drives use 250 kbit/s from the next power-on" in said
    for drive in drives:
        assert drive.server.stop() == 0
    network = connect(list(start_all())[0])
    for node_id, serial in zip((5, 6), sorted(serials)):
        assert network.add_node(node_id, str(EDS)).sdo[0x1018][4].raw == serial


class LateDrives:
    """Drives without a node-ID on a bus of virtual time, each of whose answers takes as long as `delay` says."""

    LSS_TX_COBID, LSS_RX_COBID, WAITING_STATE = 0x7E5, 0x7E4, 0

    def __init__(self, addresses, delay):
        self.addresses = addresses
        self.delay = delay
        self.now = 0.0
        self.arrivals = []
        self.questions = 0
        self.positions = [0] * len(addresses)
        self.lss = self

    def send_message(self, _cob_id, data):
        _, number, bit, sub, following = struct.unpack("<BIBBB", data)
        self.questions += 1
        for drive, address in enumerate(self.addresses):
            if bit == 128:
                self.positions[drive] = 0
            elif self.positions[drive] != sub or (address[sub] ^ number) >> bit:
                continue
            elif bit == 0 and following != sub:
                self.positions[drive] = following
            self.arrivals.append(self.now + self.delay())

    def comes(self, _frames, wait=None):
        end = self.now + (wait or 3)
        if self.arrivals and min(self.arrivals) <= end:
            self.now = max(self.now, min(self.arrivals))
            self.arrivals.remove(min(self.arrivals))
            return True
        self.now = end
        return False


def test_an_answer_that_comes_late_costs_a_number_and_not_the_scan():
    spec = importlib.util.spec_from_file_location("commission", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    chance = random.Random(402)
    # One answer in a hundred is later than the first wait, 150 ms.
    late = LateDrives(
        [[0, 0x402, 0x10000, serial] for serial in (7, 3)],
        lambda: chance.uniform(0.2, 0.5) if chance.random() < 0.01 else 0.005,
    )
    bus = script.Bus.__new__(script.Bus)
    bus.patience, bus.network, bus.lss, bus.comes = 3, late, late, late.comes
    scans = 40
    found = [bus.scan(None) for _ in range(scans)]
    assert late.questions > 133 * scans, "nothing was late"
    assert late.questions < 2 * 133 * scans
    assert sum(address in late.addresses for address in found) > scans * 3 // 4


@pytest.mark.only("virtual")
def test_the_switches_rescue_a_drive_whose_bit_rate_nobody_knows(restart, connect, commission):
    commission(restart(), "--node-id", NODE_ID, "--new-bitrate", 125)
    assert "is its bit rate that of the bus?" in commission(restart(), "--node-id", NODE_ID, "--only", code=1)
    # Position 80h: the stored node-ID, at 1 Mbit/s.
    bus = restart("--switches", "80")
    network = connect(bus)
    assert node_id_by_lss(network) == NODE_ID
    network.disconnect()
    commission(bus, "--node-id", NODE_ID, "--only", "--new-bitrate", 500)
    assert node_id_by_lss(connect(restart(), 500_000)) == NODE_ID


@pytest.mark.only("virtual")
def test_a_position_of_the_switches_goes_before_the_store(restart, connect):
    network = connect(restart("--switches", "85"))
    assert network.add_node(5, str(EDS)).sdo[0x1000].raw == 0x40192
    network.disconnect()
    # Nothing was stored by it.
    assert node_id_by_lss(connect(restart())) == UNCONFIGURED


@pytest.mark.only("virtual")
def test_the_factory_reset_forgets_settings_and_parameters(restart, connect, commission):
    bus = restart("--serial", 77)
    commission(bus, "--node-id", NODE_ID)
    network = connect(bus)
    drive = network.add_node(NODE_ID, str(EDS))
    drive.sdo.RESPONSE_TIMEOUT = 3
    drive.sdo[0x6081].raw = 4321
    drive.store()
    network.disconnect()
    bus = restart("--serial", 77, "--factory-reset")
    assert "serial 0000004Dh" in commission(bus, "--node-id", NODE_ID)
    assert connect(bus).add_node(NODE_ID, str(EDS)).sdo[0x6081].raw == 10_000


def leave(network):
    """Disconnects a master from a bus that is gone."""
    with contextlib.suppress(can.CanError, OSError):
        network.disconnect()
    network.bus = None


# The master's thread reads from a server that has vanished.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
@pytest.mark.only("virtual", "firmware")
def test_a_power_cut_while_storing_leaves_a_reachable_drive(start, connect, tmp_path):
    stored = UNCONFIGURED
    bus = start(tmp_path)
    for node_id, delay in enumerate((0, 0, 0.0003, 0.0006, 0.001, 0.002, 0.005, 0.02), start=1):
        network = connect(bus)
        network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
        network.lss.configure_node_id(node_id)
        answers = Frames(network, network.lss.LSS_RX_COBID)
        network.send_message(network.lss.LSS_TX_COBID, b"\x17" + bytes(7))
        answered = not answers.none(delay)
        bus.server.kill()
        leave(network)
        bus = start(tmp_path)
        network = connect(bus)
        found = node_id_by_lss(network)
        assert found in ((node_id,) if answered else (stored, node_id))
        stored = found
        network.disconnect()
