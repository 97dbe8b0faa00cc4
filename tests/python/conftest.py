"""What the tests share: the programs, a fresh device for every test, and a master connected to it.

`--target virtual` is a virtual drive that serves SLCAN, `--target firmware` the firmware image in QEMU, and
`--target socketcan` a virtual drive on `vcan0`. Without it the virtual drive is tested.

Against the virtual drive every test runs. The other two have the same core inside, so they run what they may do otherwise: the tests marked
`everywhere`, which are about timing, the transport with many frames, LSS, and what is stored, with one of each kind of motion, and those that name them (`only`).

Against a virtual drive, the tests marked `own_limits` run in virtual time (`stepped.py`), with the time-outs of python-canopen as they are. On the
other targets, which run in real time, its time-outs are those of `patience`: a PC that is busy tells nothing about the drive.
"""

import pathlib
import tempfile

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402

from frames import Frames
from server import Programs
from stepped import VirtualTime

ROOT = pathlib.Path(__file__).resolve().parents[2]
EDS = ROOT / "eds" / "axis402.eds"

#: The node-ID that the tests give to the device.
NODE_ID = 10

#: How long the drive waits for the next frame of a transfer, and what it is told here: milliseconds.
SDO_TIME_OUT, SERVER_PATIENCE = 0x5FF3, 20_000


def pytest_addoption(parser):
    parser.addoption("--target", action="append", choices=["virtual", "firmware", "socketcan"])
    parser.addoption("--sim", default=ROOT / "target" / "debug" / "sim", help="the virtual drive's program")
    parser.addoption(
        "--stepped", default=ROOT / "target" / "debug" / "stepped_drive", help="the virtual drive in virtual time"
    )
    parser.addoption("--od-gen", default=ROOT / "target" / "debug" / "od-gen", help="the generator's command line")
    parser.addoption("--axis402", default=ROOT / "target" / "debug" / "axis402", help="the master's command line")
    parser.addoption(
        "--io-device", default=ROOT / "target" / "debug" / "examples" / "io_device", help="the example of the crate canopen"
    )
    parser.addoption(
        "--plant-trace", default=ROOT / "target" / "debug" / "examples" / "plant_trace", help="the plant of the servo, played"
    )
    parser.addoption("--panel", default=ROOT / "target" / "debug" / "axis402-panel", help="the panel's program")
    parser.addoption("--pictures", help="a folder for pictures of the panel's pages")
    parser.addoption("--xtask", default=ROOT / "target" / "debug" / "xtask", help="the program that runs the emulator")
    parser.addoption("--node-modules", help="the packages of Node.js")
    parser.addoption("--image", help="the firmware's ELF file; without it, it is built")


def kinds(config):
    return config.getoption("--target") or ["virtual"]


def pytest_configure(config):
    config.addinivalue_line("markers", "only(kind, ...): the test is about these targets alone")
    config.addinivalue_line("markers", "everywhere: the test is for every target, and not for the virtual drive alone")
    config.addinivalue_line("markers", "own_limits: with the time-outs of python-canopen, if the drive is virtual")


def pytest_generate_tests(metafunc):
    if "kind" in metafunc.fixturenames:
        metafunc.parametrize("kind", kinds(metafunc.config))


def pytest_collection_modifyitems(config, items):
    """Leaves out the tests that are not about the chosen targets."""

    def wanted(item):
        only = item.get_closest_marker("only")
        here = [item.callspec.params["kind"]] if "kind" in item.fixturenames else kinds(config)
        if only is not None:
            return any(kind in only.args for kind in here)
        return "virtual" in here or item.get_closest_marker("everywhere") is not None

    config.hook.pytest_deselected(items=[item for item in items if not wanted(item)])
    items[:] = [item for item in items if wanted(item)]


def pytest_make_parametrize_id(val):
    """Numbers in the names of tests are hexadecimal, as in the standards."""
    return f"{val:X}h" if isinstance(val, int) and val > 9 else None


@pytest.fixture(autouse=True)
def virtual_time(request, monkeypatch):
    """The clock of a test that runs in virtual time, otherwise nothing."""
    if "kind" in request.fixturenames and request.getfixturevalue("kind") == "virtual":
        if request.node.get_closest_marker("own_limits"):
            return VirtualTime(monkeypatch)
    return None


@pytest.fixture(autouse=True)
def patience(virtual_time, monkeypatch):
    """In real time python-canopen's patience is for a PC that does nothing else; what it waits for must come, but may come late."""
    if virtual_time is None:
        for name in vars(BaseNode402):
            if name.startswith(("TIMEOUT_SWITCH", "TIMEOUT_CHECK")):
                monkeypatch.setattr(BaseNode402, name, 10)
        monkeypatch.setattr(BaseNode402, "TIMEOUT_HOMING_DEFAULT", 60)
        monkeypatch.setattr(canopen.sdo.SdoClient, "RESPONSE_TIMEOUT", 10)
        monkeypatch.setattr(canopen.lss.LssMaster, "RESPONSE_TIMEOUT", 3)
        # How often its thread looks whether it is to end.
        monkeypatch.setattr(canopen.Network, "NOTIFIER_CYCLE", 0.02)


@pytest.fixture(autouse=True)
def late(virtual_time, monkeypatch, caplog):
    """What has not come in time, which must be nothing. `BaseNode402` tells it only when a path of several states is late too, and logs a
    mode that is late."""
    late = []
    if virtual_time is not None:
        change_state = BaseNode402._change_state

        def watched(drive, target):
            is_there = change_state(drive, target)
            if not is_there:
                late.append(target)
            return is_there

        monkeypatch.setattr(BaseNode402, "_change_state", watched)
    yield late
    if virtual_time is not None:
        late += [record.getMessage() for record in caplog.get_records("call") if "imeout" in record.getMessage()]
        assert late == []


@pytest.fixture(scope="session")
def programs(pytestconfig):
    return Programs(*[pytestconfig.getoption(name) for name in ("--sim", "--stepped", "--axis402", "--xtask", "--image")])


@pytest.fixture
def tmp_path():
    """A folder of the test's own. Nothing is left of it, while pytest would keep those of the last runs."""
    with tempfile.TemporaryDirectory(prefix="axis402-") as folder:
        yield pathlib.Path(folder)


@pytest.fixture
def started(tmp_path):
    """The devices of the test. All of them are stopped at its end, before the test's folder is removed."""
    started = []
    yield started
    servers = [bus.server for bus in started if not bus.server.was_killed]
    codes = [server.stop() for server in servers]
    assert codes == [0] * len(codes), [server.words() for server in servers]


@pytest.fixture
def start(programs, kind, started, virtual_time):
    """Starts devices, each with its store and its other arguments."""

    def start(store=None, arguments=()):
        if virtual_time is not None:
            assert store is None
            started.append(virtual_time.start([programs.stepped, *arguments]))
        else:
            started.append(programs.start(kind, store, arguments))
        return started[-1]

    return start


@pytest.fixture
def connect():
    """Connects masters. All of them are disconnected at the end of the test, before the devices are stopped."""
    networks = []

    def connect(bus, *bitrate):
        networks.append(bus.connect(*bitrate))
        return networks[-1]

    yield connect
    for network in networks:
        if network.bus is not None:
            network.disconnect()


@pytest.fixture
def network(start, connect):
    """A master, and an unconfigured device on its bus."""
    return connect(start())


def give_node_id(network, node_id=NODE_ID):
    """LSS gives a node-ID to the only device on the bus, which then boots."""
    boot_up = Frames(network, 0x700 + node_id)
    network.lss.send_switch_state_global(network.lss.CONFIGURATION_STATE)
    network.lss.configure_node_id(node_id)
    network.lss.send_switch_state_global(network.lss.WAITING_STATE)
    assert boot_up.next() == b"\x00"


def add(network, node):
    """Gives the device a node-ID; python-canopen learns its state from the boot-up."""
    network.add_node(node)
    give_node_id(network, node.id)
    # A master on a busy PC may pause for longer than the second that a server grants.
    node.sdo.download(SDO_TIME_OUT, 0, SERVER_PATIENCE.to_bytes(2, "little"))
    return node


@pytest.fixture
def node(network):
    """The device with a node-ID, Pre-operational."""
    return add(network, canopen.RemoteNode(NODE_ID, str(EDS)))


@pytest.fixture
def drive(network):
    """The device with a node-ID, Pre-operational, as python-canopen's CiA 402 drive."""
    return add(network, BaseNode402(NODE_ID, str(EDS)))
